/* hdr: the driver. Reads the command line, decides where the result goes, and turns faults into words and an exit
 * status. */
#include "cmd.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* The verbs that are programs: they report about pictures instead of making one. */
static const struct program {
    const char *name;
    hdr_status (*run)(hdr_chain *chain, hdr_error *error);
} programs[] = {{"info", cmd_info},   {"stats", cmd_stats}, {"bench", cmd_bench},
                {"error", cmd_error}, {"noise", cmd_noise}, {"crosscheck", cmd_crosscheck}};

/* ---- Words to standard error ---- */

hdr_status cmd_refuse(hdr_error *error, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    error->status = HDR_USAGE;
    return HDR_USAGE;
}

hdr_status cmd_out_of_memory(hdr_error *error) {
    snprintf(error->message, sizeof error->message, "out of memory");
    return error->status = HDR_INTERNAL;
}

void cmd_report(const hdr_error *error) {
    fprintf(stderr, "hdr: %s\n", error->message);
}

static void say(void *context, hdr_message kind, const char *line) {
    const hdr_settings *settings = context;
    if (kind == HDR_NOTE && settings->quiet) return;
    if (kind == HDR_NOTE) fprintf(stderr, "hdr: ");
    cmd_print_plain(stderr, line);
    putc('\n', stderr);
}

hdr_listener cmd_listener(const hdr_chain *chain) {
    /* The context is only read, and only by say. */
    return (hdr_listener){say, (void *)hdr_chain_settings(chain)};
}

/* ---- The process ---- */

/* A program may be started with standard descriptors closed; the next file that is opened would then get such a number,
 * and words would be written into it. What is put there instead refuses to be used, so that nothing is lost in silence.
 */
static bool occupy_standard_descriptors(void) {
    for (int descriptor = 0; descriptor <= 2; descriptor++) {
        if (fcntl(descriptor, F_GETFD) >= 0) continue;
        int opened = open("/dev/null", descriptor == 0 ? O_WRONLY : O_RDONLY);
        if (opened != descriptor) return false; /* the lowest free number is this one: those below are occupied */
    }
    return true;
}

static void end_by_signal(int signal_number) {
    hdr_output_remove_temporary();
    /* The default action is in force again (SA_RESETHAND): the shell sees which signal it was. */
    raise(signal_number);
}

/* A signal that is ignored (nohup) stays ignored. SIGPIPE keeps its default action: a closed pipe ends the program. */
static void catch_signals(void) {
    static const int caught[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {0}, before;
    action.sa_handler = end_by_signal;
    action.sa_flags = (int)SA_RESETHAND;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof caught / sizeof *caught; i++)
        sigaddset(&action.sa_mask, caught[i]);
    signal(SIGXFSZ, SIG_IGN); /* a file that outgrows its limit is a write that fails, and is told as such */
    for (size_t i = 0; i < sizeof caught / sizeof *caught; i++)
        if (sigaction(caught[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN)
            sigaction(caught[i], &action, NULL);
}

/* Text that was printed is only there once it could be written. */
static hdr_status close_standard_output(hdr_status status) {
    bool failed = ferror(stdout) != 0;
    errno = 0;
    if (fclose(stdout) == 0 && !failed) return status;
    const char *why = errno ? strerror(errno) : "it could not be written";
    fprintf(stderr, "hdr: standard output: %s\n", why);
    return status == HDR_OK ? HDR_IO : status;
}

/* ---- Where the result goes ---- */

/* Whether all clauses can go along in a pipe's head. */
static bool travels(const hdr_chain *chain) {
    for (int i = 1; hdr_chain_clause(chain, i); i++)
        if (hdr_chain_clause(chain, i)->stays) return false;
    return true;
}

/* Whether a chain of filters is handed on as text: there is somebody at the other end who will compute the pixels. */
static bool deferred(const hdr_chain *chain) {
    struct stat about;
    const char *environment = getenv("HDR_DEFER");
    return !hdr_chain_settings(chain)->output && hdr_chain_last(chain)->kind == HDR_FILTER && travels(chain) &&
           !(environment && strcmp(environment, "0") == 0) && fstat(STDOUT_FILENO, &about) == 0 &&
           S_ISFIFO(about.st_mode);
}

/* The name of the regular file that standard output was redirected to, where its ending is a format's: the library then
 * takes that format. Anything else gets a name without an ending, which means EXR. */
static const char *redirected_name(char *path, size_t size) {
    static const char plain[] = "standard output";
    struct stat about;
    if (fstat(STDOUT_FILENO, &about) != 0 || !S_ISREG(about.st_mode)) return plain;
    ssize_t length = readlink("/proc/self/fd/1", path, size - 1);
    if (length <= 0) return plain;
    path[length] = '\0';
    return hdr_format_named(path) ? path : plain;
}

static hdr_output *open_output(const hdr_chain *chain, hdr_error *error) {
    char path[4096];
    const char *name = hdr_chain_settings(chain)->output;
    if (name && strcmp(name, "-") != 0) return hdr_output_open(name, error);
    bool follow_name = !name && hdr_chain_last(chain)->kind != HDR_FORMAT;
    return hdr_output_descriptor(STDOUT_FILENO, follow_name ? redirected_name(path, sizeof path) : "standard output",
                                 error);
}

/* ---- Where pictures come from ---- */

/* Hundreds of renders may be open at a time. */
static void allow_many_files(void) {
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    limit.rlim_cur = limit.rlim_max;
    (void)setrlimit(RLIMIT_NOFILE, &limit); /* where it is refused, opening tells */
}

hdr_status cmd_check_standard_input(const char *const files[], const char *other, hdr_error *error) {
    int named = !files[0]; /* then it is meant */
    named += other && strcmp(other, "-") == 0;
    for (int i = 0; files[i]; i++)
        named += strcmp(files[i], "-") == 0;
    return named > 1 ? cmd_refuse(error, "standard input is one picture, and is named %d times", named) : HDR_OK;
}

cmd_inputs cmd_open_files(const hdr_chain *chain, hdr_error *error) {
    const char *const *files = hdr_chain_files(chain);
    cmd_inputs opened = {NULL, 0};
    int count = 0;
    if (cmd_check_standard_input(files, NULL, error) != HDR_OK) return opened;
    while (files[count])
        count++;
    if (count == 0) count = 1; /* standard input */
    allow_many_files();
    opened.inputs = calloc((size_t)count, sizeof(hdr_input *));
    if (!opened.inputs) {
        cmd_out_of_memory(error);
        return opened;
    }
    while (opened.count < count) {
        hdr_input *input = hdr_input_open(files[opened.count], error);
        if (!input) {
            cmd_close_files(&opened);
            return opened;
        }
        opened.inputs[opened.count++] = input;
    }
    return opened;
}

void cmd_close_files(cmd_inputs *opened) {
    for (int i = 0; i < opened->count; i++)
        hdr_input_free(opened->inputs[i]);
    free(opened->inputs);
    *opened = (cmd_inputs){NULL, 0};
}

cmd_input cmd_open_input(const hdr_chain *chain, hdr_error *error) {
    cmd_input opened = {NULL, {NULL, 0}};
    if (!hdr_chain_joins(chain)) {
        opened.input = hdr_input_open(hdr_chain_files(chain)[0], error);
        return opened;
    }
    opened.members = cmd_open_files(chain, error);
    if (opened.members.count) opened.input = hdr_input_join(opened.members.count, opened.members.inputs, error);
    return opened;
}

void cmd_close_input(cmd_input *opened) {
    hdr_input_free(opened->input);
    cmd_close_files(&opened->members);
}

double cmd_number(const hdr_chain *chain, int clause, const char *name, double word) {
    const char *text = hdr_chain_given(chain, clause, name);
    const hdr_verb_about *verb = clause ? hdr_chain_clause(chain, clause) : hdr_chain_leader(chain);
    for (const hdr_option *o = verb->options; !text && o->name; o++)
        if (strcmp(o->name, name) == 0) text = o->default_value;
    char *end = NULL;
    double number = text ? strtod(text, &end) : word;
    return text && end == text ? word : number;
}

/* ---- Running ---- */

/* The output is asked for first: a terminal there is a mistake that must not wait for the input's end. */
static hdr_status compute(hdr_chain *chain, hdr_error *error) {
    hdr_listener listener = cmd_listener(chain);
    hdr_output *output = open_output(chain, error);
    cmd_input opened = output ? cmd_open_input(chain, error) : (cmd_input){NULL, {NULL, 0}};
    hdr_status status = opened.input ? hdr_chain_run(chain, opened.input, output, &listener, error) : error->status;
    cmd_close_input(&opened);
    hdr_output_free(output);
    return status;
}

static hdr_status defer(hdr_chain *chain, hdr_error *error) {
    hdr_input *input = hdr_input_open(hdr_chain_files(chain)[0], error);
    hdr_status status = input ? hdr_chain_defer(chain, input, STDOUT_FILENO, error) : error->status;
    hdr_input_free(input);
    return status;
}

static hdr_status run_program(const struct program *program, hdr_chain *chain, hdr_error *error) {
    if (hdr_chain_settings(chain)->output)
        return cmd_refuse(error, "%s prints text, to standard output: -o is for pictures", program->name);
    return program->run(chain, error);
}

/* What the command line is about. */
static const hdr_verb_about *chosen_verb(const hdr_chain *chain) {
    const hdr_verb_about *leader = hdr_chain_leader(chain);
    return leader ? leader : hdr_chain_last(chain);
}

/* The clause that asks for a list, and no picture; 0: none does. */
static int listing_clause(const hdr_chain *chain) {
    for (int i = 1; hdr_chain_clause(chain, i); i++)
        if (hdr_chain_given(chain, i, "list")) return i;
    return 0;
}

static hdr_status run_chain(hdr_chain *chain, hdr_error *error) {
    const hdr_verb_about *verb = chosen_verb(chain);
    const char *const *files = hdr_chain_files(chain);
    if (listing_clause(chain) && verb->kind == HDR_PROGRAM)
        return cmd_refuse(error, "--list prints names and makes no picture: leave %s out", verb->name);
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++)
        if (strcmp(verb->name, programs[i].name) == 0) return run_program(&programs[i], chain, error);
    if (listing_clause(chain)) return cmd_ocio_list(chain, listing_clause(chain), error);
    if (files[0] && files[1] && !hdr_chain_joins(chain))
        return cmd_refuse(error, "one picture at a time: '%.200s' is one file too many", files[1]);
    return deferred(chain) ? defer(chain, error) : compute(chain, error);
}

/* ---- The command line ---- */

static hdr_status parse_and_run(int count, const char *const words[], hdr_error *error) {
    hdr_chain *chain = hdr_chain_new(error);
    hdr_status status = chain ? hdr_chain_parse(chain, count, words, error) : error->status;
    if (status == HDR_OK && hdr_chain_settings(chain)->help)
        cmd_print_verb_help(stdout, chosen_verb(chain));
    else if (status == HDR_OK && hdr_chain_settings(chain)->version)
        cmd_print_version();
    else if (status == HDR_OK)
        status = run_chain(chain, error);
    hdr_chain_free(chain);
    return status;
}

/* words: what stands behind `hdr`. */
static hdr_status run_words(int count, const char *const words[], hdr_error *error) {
    if (count == 0) {
        cmd_print_usage(stderr);
        return HDR_USAGE;
    }
    if (strcmp(words[0], "help") == 0) return cmd_help(count - 1, words + 1, error);
    if (strcmp(words[0], "--help") == 0 || strcmp(words[0], "-h") == 0) {
        cmd_print_overview(stdout);
        return HDR_OK;
    }
    if (strcmp(words[0], "--version") == 0 || strcmp(words[0], "-V") == 0) {
        cmd_print_version();
        return HDR_OK;
    }
    return parse_and_run(count, words, error);
}

/* `hdr-VERB` is `hdr VERB`: its words begin with the verb in the program's own name. */
static hdr_status run_as_named(int argc, char **argv, hdr_error *error) {
    const char *slash = strrchr(argv[0], '/');
    const char *name = slash ? slash + 1 : argv[0];
    const char *const *words = (const char *const *)argv;
    if (strncmp(name, "hdr-", 4) != 0) return run_words(argc - 1, words + 1, error);
    argv[0] = (char *)name + 4; /* only read from here on */
    return run_words(argc, words, error);
}

int main(int argc, char **argv) {
    static char *no_words[] = {"hdr", NULL};
    hdr_error error = {0};
    if (!occupy_standard_descriptors()) return HDR_INTERNAL;
    catch_signals();
    hdr_status status = argc > 0 ? run_as_named(argc, argv, &error) : run_as_named(1, no_words, &error);
    if (error.status != HDR_OK) cmd_report(&error);
    return (int)close_standard_output(status);
}
