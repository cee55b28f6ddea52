/* hdr help: usage, help and manual pages. Whatever they say about verbs and options comes from the library's tables. */
#include "cmd.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define MANUAL_DATE "November 22, 2026" /* unless SOURCE_DATE_EPOCH says another */
#define LINE_LENGTH 76                  /* of the manual's source */

static const struct kind {
    hdr_verb_kind kind;
    const char *title, *word;
    const char *operands; /* what stands behind the verb's options */
} kinds[] = {{HDR_FILTER, "Filters", "filter", "[then VERB [OPTION...]]... [-o OUT] [FILE]"},
             {HDR_FORMAT, "Formats", "format", "[-o OUT] [FILE]"},
             {HDR_PROGRAM, "Programs", "program", "[FILE...]"},
             {HDR_JOIN, "Joins", "join", "[then VERB [OPTION...]]... [-o OUT] FILE..."},
             {HDR_GUIDED, "Guided by a second picture", "guided", "[then VERB [OPTION...]]... [-o OUT] [FILE]"}};
#define KINDS (sizeof kinds / sizeof *kinds)

static const struct exit_status {
    hdr_status status;
    const char *meaning;
} exit_statuses[] = {{HDR_OK, "Done."},
                     {HDR_DIFFERENT, "A comparison found a difference, or some file of several failed."},
                     {HDR_USAGE, "The words make no command: unknown verb or option, value out of range."},
                     {HDR_BAD_DATA, "The picture cannot be read, or cannot be used so."},
                     {HDR_NO_INPUT, "There is no such file, or it cannot be opened."},
                     {HDR_INTERNAL, "Out of memory, or a fault of the program itself."},
                     {HDR_CANT_CREATE, "The output cannot be created."},
                     {HDR_IO, "Reading or writing failed; the disk may be full."}};

static const char led_operands[] = "VERB [OPTION...] [then VERB [OPTION...]]... [FILE]";

static const struct kind *kind_of(const hdr_verb_about *verb) {
    for (size_t i = 0; i < KINDS; i++)
        if (kinds[i].kind == verb->kind) return &kinds[i];
    return &kinds[0];
}

/* ---- On the terminal ---- */

void cmd_print_version(void) {
    printf("hdrpipe %s\n", HDRPIPE_VERSION);
}

void cmd_print_usage(FILE *to) {
    fprintf(to, "usage: hdr VERB [OPTION...] [then VERB [OPTION...]]... [-o OUT] [FILE]\n"
                "       hdr help [VERB]\n"
                "hdr --help lists the verbs.\n");
}

static void print_option_table(FILE *to, const hdr_option *options) {
    char line[500];
    for (const hdr_option *option = options; option && option->name; option++) {
        hdr_option_describe(option, line, sizeof line);
        fprintf(to, "%s\n", line);
    }
}

static void print_verbs_of_kind(FILE *to, const struct kind *kind) {
    fprintf(to, "\n%s:\n", kind->title);
    const hdr_verb_about *verb;
    for (int i = 0; (verb = hdr_verb_at(i)) != NULL; i++)
        if (verb->kind == kind->kind) fprintf(to, "  %-10s %s\n", verb->name, verb->summary);
}

void cmd_print_overview(FILE *to) {
    fprintf(to, "usage: hdr VERB [OPTION...] [then VERB [OPTION...]]... [-o OUT] [FILE]\n"
                "       hdr-VERB ...              the same, one program a verb\n"
                "       hdr help VERB             what a verb does, and its options\n"
                "\n"
                "Turns HDR renders (OpenEXR) into pictures for a display, as a chain of verbs:\n"
                "  hdr log then png -o a.png a.exr\n"
                "  hdr-log < a.exr | hdr-png > a.png\n");
    for (size_t i = 0; i < KINDS; i++)
        print_verbs_of_kind(to, &kinds[i]);
    fprintf(to, "\nOptions of every verb:\n");
    print_option_table(to, hdr_common_options());
    fprintf(to, "\nMore is in the manual: hdr(1), hdrpipe(7).\n");
}

void cmd_print_verb_help(FILE *to, const hdr_verb_about *verb) {
    const char *operands = verb->leads ? led_operands : verb->alone ? "" : kind_of(verb)->operands;
    fprintf(to, "usage: hdr %s [OPTION...]%s%s\n", verb->name, *operands ? " " : "", operands);
    fprintf(to, "       hdr-%s ...\n\n%s: %s\n", verb->name, verb->name, verb->summary);
    if (verb->options && verb->options->name) {
        fprintf(to, "\nOptions:\n");
        print_option_table(to, verb->options);
    }
    fprintf(to, "\nOptions of every verb:\n");
    print_option_table(to, hdr_common_options());
    fprintf(to, "\nExamples:\n");
    for (int i = 0; verb->examples && verb->examples[i]; i++)
        fprintf(to, "  %s\n", verb->examples[i]);
    fprintf(to, "\nMore is in the manual: hdr-%s(1).\n", verb->name);
}

/* ---- For scripts ---- */

static void print_list(void) {
    const hdr_verb_about *verb;
    for (int i = 0; (verb = hdr_verb_at(i)) != NULL; i++)
        printf("%s\t%s\t%s\n", verb->name, kind_of(verb)->word, verb->summary);
}

static void print_option_names(const hdr_option *options) {
    for (const hdr_option *option = options; option && option->name; option++) {
        printf("--%s", option->name);
        if (option->letter) printf(" -%c", option->letter);
        putchar('\n');
    }
}

/* ---- Manual pages: text to mdoc ---- */

/* Between two letters it is a hyphen, anywhere else a minus, which must stay one on every device. */
static bool is_hyphen(const char *at, const char *start) {
    return at > start && isalpha((unsigned char)at[-1]) && isalpha((unsigned char)at[1]);
}

/* One byte of text as mdoc has it. at must point into a string that goes on behind it, or ends. */
static const char *escaped(const char *at, const char *start) {
    static char same[2];
    switch (*at) {
    case '\\':
        return "\\e";
    case '-':
        return is_hyphen(at, start) ? "-" : "\\-";
    case '^':
        return "\\(ha";
    case '~':
        return "\\(ti";
    case '`':
        return "\\(ga";
    case '\'':
        return "\\(aq";
    case '"':
        return "\\(dq";
    default:
        same[0] = *at;
        return same;
    }
}

/* Prints text of that length, with what would be a request at a line's start made harmless. Returns the bytes printed.
 */
static size_t print_escaped(const char *text, size_t length, bool at_line_start) {
    size_t printed = 0;
    if (at_line_start && length > 0 && (*text == '.' || *text == '\'')) printed += (size_t)printf("\\&");
    for (const char *c = text; c < text + length; c++)
        printed += (size_t)printf("%s", escaped(c, text));
    return printed;
}

static size_t escaped_length(const char *text, size_t length) {
    size_t total = 2; /* perhaps \& */
    for (const char *c = text; c < text + length; c++)
        total += strlen(escaped(c, text));
    return total;
}

/* Whether a sentence ends with this word: a new one begins on a new line. A single letter and a point is an initial. */
static bool ends_sentence(const char *word, size_t length, const char *next) {
    while (length > 0 && strchr(")\"'", word[length - 1]))
        length--;
    if (length < 2 || !strchr(".!?", word[length - 1])) return false;
    char before = word[length - 2];
    if (!isalnum((unsigned char)before) && !strchr(")]", before)) return false;
    if (length == 2 && isalpha((unsigned char)before)) return false;
    return isupper((unsigned char)*next) || *next == '-' || *next == '(';
}

/* Prints a paragraph, of that length, as lines of text. */
static void print_paragraph(const char *text, size_t length) {
    const char *end = text + length;
    size_t column = 0;
    while (text < end) {
        size_t word = strcspn(text, " \n");
        if (word > (size_t)(end - text)) word = (size_t)(end - text);
        if (column > 0 && column + 1 + escaped_length(text, word) > LINE_LENGTH) {
            putchar('\n');
            column = 0;
        }
        if (column > 0 && word > 0) column += (size_t)printf(" ");
        column += print_escaped(text, word, column == 0);
        const char *next = text + word;
        while (next < end && (*next == ' ' || *next == '\n'))
            next++;
        if (next < end && ends_sentence(text, word, next)) {
            putchar('\n');
            column = 0;
        }
        text = next;
    }
    putchar('\n');
}

/* Paragraphs are separated by an empty line. */
static void print_paragraphs(const char *text) {
    while (*text) {
        const char *gap = strstr(text, "\n\n");
        size_t length = gap ? (size_t)(gap - text) : strlen(text);
        print_paragraph(text, length);
        text += length + strspn(text + length, "\n");
        if (*text) printf(".Pp\n");
    }
}

/* An argument of a macro; what could be taken for a macro's name, or for punctuation, is marked as text. */
static void print_argument(const char *text) {
    bool quoted = strchr(text, ' ') != NULL;
    printf(quoted ? " \"\\&" : " \\&");
    print_escaped(text, strlen(text), false);
    if (quoted) putchar('"');
}

/* ---- Manual pages: parts ---- */

static void print_date(void) {
    static const char *const months[] = {"January", "February", "March",     "April",   "May",      "June",
                                         "July",    "August",   "September", "October", "November", "December"};
    const char *epoch = getenv("SOURCE_DATE_EPOCH");
    char *end = NULL;
    time_t seconds = epoch ? (time_t)strtoll(epoch, &end, 10) : 0;
    struct tm date;
    if (epoch && end != epoch && !*end && gmtime_r(&seconds, &date))
        printf(".Dd %s %d, %d\n", months[date.tm_mon], date.tm_mday, date.tm_year + 1900);
    else
        printf(".Dd %s\n", MANUAL_DATE);
}

static void print_title(const char *name, const char *summary) {
    printf(".\\\" Made by \"hdr help --man\" from the program's own tables: change those instead.\n");
    print_date();
    printf(".Dt ");
    for (const char *c = name; *c; c++)
        putchar(toupper((unsigned char)*c));
    printf(" 1\n.Os\n.Sh NAME\n.Nm %s\n.Nd %s\n", name, summary);
}

/* What --help says behind an option's name: what it does, its range and its default. */
static void print_option_text(const hdr_option *option) {
    char line[500];
    hdr_option_describe(option, line, sizeof line - 1);
    char *text = strstr(line, option->help);
    if (!text) text = line;
    *text = (char)toupper((unsigned char)*text);
    strcat(text, ".");
    print_paragraph(text, strlen(text));
}

static void print_option_items(const hdr_option *options) {
    printf(".Bl -tag -width Ds\n");
    for (const hdr_option *option = options; option->name; option++) {
        printf(".It");
        if (option->letter) printf(" Fl %c ,", option->letter);
        printf(" Fl Fl %s", option->name);
        if (option->type != HDR_OPTION_FLAG) {
            printf(" Ar");
            print_argument(option->metavar ? option->metavar : "WORD");
        }
        putchar('\n');
        print_option_text(option);
    }
    printf(".El\n");
}

static void print_exit_statuses(void) {
    printf(".Sh EXIT STATUS\n.Bl -tag -width Ds\n");
    for (size_t i = 0; i < sizeof exit_statuses / sizeof *exit_statuses; i++)
        printf(".It %d\n%s\n", exit_statuses[i].status, exit_statuses[i].meaning);
    printf(".El\n");
}

static void print_examples(const char *const *examples) {
    if (!examples || !examples[0]) return;
    printf(".Sh EXAMPLES\n.Bd -literal -offset indent\n");
    for (int i = 0; examples[i]; i++) {
        print_escaped(examples[i], strlen(examples[i]), true);
        putchar('\n');
    }
    printf(".Ed\n");
}

/* ---- Manual pages: of a verb ---- */

static void print_synopsis(const hdr_verb_about *verb) {
    printf(".Sh SYNOPSIS\n.Nm hdr\n.Cm %s\n", verb->name);
    for (const hdr_option *option = verb->options; option && option->name; option++) {
        printf(".Op Fl Fl %s", option->name);
        if (option->type != HDR_OPTION_FLAG) {
            printf(" Ar");
            print_argument(option->metavar ? option->metavar : "WORD");
        }
        putchar('\n');
    }
    printf(".Op Ar common-option ...\n");
    if (verb->leads) printf(".Ar VERB Op Ar OPTION ...\n");
    if (verb->kind == HDR_FILTER || verb->kind == HDR_JOIN || verb->kind == HDR_GUIDED || verb->leads)
        printf(".Op Cm then Ar VERB Op Ar OPTION ...\n.Ar ...\n");
    if (verb->leads)
        printf(".Op Ar FILE\n");
    else if (verb->kind == HDR_JOIN)
        printf(".Op Fl o Ar OUT\n.Ar FILE ...\n");
    else if (!verb->alone)
        printf(verb->kind == HDR_PROGRAM ? ".Op Ar FILE ...\n" : ".Op Fl o Ar OUT\n.Op Ar FILE\n");
    printf(".Nm hdr-%s\n.Ar ...\n", verb->name);
}

static void print_common_pointer(void) {
    printf(".Pp\nThe options of every verb are described in\n.Xr hdr 1 :\n");
    for (const hdr_option *option = hdr_common_options(); option->name; option++)
        printf(".Fl Fl %s %s\n", option->name, option[1].name ? "," : ".");
}

static void print_verb_page(const hdr_verb_about *verb) {
    char name[100];
    snprintf(name, sizeof name, "hdr-%s", verb->name);
    print_title(name, verb->summary);
    print_synopsis(verb);
    printf(".Sh DESCRIPTION\n");
    print_paragraphs(verb->details);
    printf(".Sh OPTIONS\n");
    if (verb->options && verb->options->name)
        print_option_items(verb->options);
    else
        printf("This verb has no options of its own.\n");
    print_common_pointer();
    print_exit_statuses();
    print_examples(verb->examples);
    printf(".Sh SEE ALSO\n.Xr hdr 1 ,\n.Xr hdrpipe 5 ,\n.Xr hdrpipe 7\n");
}

/* ---- Manual pages: of hdr itself ---- */

static const char hdr_synopsis[] = ".Sh SYNOPSIS\n"
                                   ".Nm\n"
                                   ".Ar VERB\n"
                                   ".Op Ar OPTION ...\n"
                                   ".Op Cm then Ar VERB Op Ar OPTION ...\n"
                                   ".Ar ...\n"
                                   ".Op Fl o Ar OUT\n"
                                   ".Op Ar FILE\n"
                                   ".Nm hdr-VERB\n"
                                   ".Ar ...\n"
                                   ".Nm hdr\n"
                                   ".Cm help\n"
                                   ".Op Ar VERB\n";

static const char hdr_description[] =
    ".Sh DESCRIPTION\n"
    "Turns HDR renders into pictures for a display, by a chain of verbs.\n"
    "Each verb does one thing to the picture; the words\n"
    ".Cm then\n"
    "and\n"
    ".Cm \\&:\n"
    "put another verb behind it.\n"
    ".Nm hdr-VERB\n"
    "is the same as\n"
    ".Nm hdr Ar VERB .\n"
    ".Pp\n"
    "The picture is read from\n"
    ".Ar FILE ,\n"
    "or from standard input when there is none or it is\n"
    ".Sq \\- .\n"
    "The words behind\n"
    ".Sq \\-\\-\n"
    "are files even where they look like options.\n"
    ".Pp\n"
    "The result goes to\n"
    ".Ar OUT ,\n"
    "which appears under its name only when it is whole, or else to standard output.\n"
    "Its format is that of the last verb.\n"
    "Where that is no format, it follows the ending of the file's name\n"
    "(also of a file that standard output is redirected to),\n"
    "and is OpenEXR where there is none.\n"
    "A chain without a format that writes to a pipe does no work itself:\n"
    "it hands the picture on with a note of what is to be done,\n"
    "and the next program does it.\n"
    ".Xr hdrpipe 7\n"
    "explains this, and the terms that the manual uses.\n";

/* Those that stand in a pipe's head. */
static void print_travelling(void) {
    const char *before = ".Pp\nOf these, the ones that change the picture go along with it through a pipe:\n";
    for (const hdr_option *option = hdr_common_options(); option->name; option++) {
        if (!option->travels) continue;
        printf("%s.Fl Fl %s", before, option->name);
        before = " ,\n";
    }
    printf(" .\nThe others are for the program that they are given to.\n");
}

static const char hdr_environment[] = ".Sh ENVIRONMENT\n"
                                      ".Bl -tag -width Ds\n"
                                      ".It Ev HDR_THREADS\n"
                                      "The number of threads where\n"
                                      ".Fl j\n"
                                      "is not given.\n"
                                      ".It Ev HDR_CPU\n"
                                      "Holds the kernels down to an instruction set:\n"
                                      ".Cm c , sse2 , avx2\n"
                                      "or\n"
                                      ".Cm avx512 .\n"
                                      "The result is the same; this is for tests.\n"
                                      ".It Ev HDR_DEFER\n"
                                      "If\n"
                                      ".Cm 0 ,\n"
                                      "a chain without a format puts OpenEXR pixels on a pipe, too.\n"
                                      ".It Ev OCIO\n"
                                      "The configuration of\n"
                                      ".Xr hdr-ocio 1\n"
                                      "where\n"
                                      ".Fl Fl config\n"
                                      "is not given.\n"
                                      "OpenColorIO looks at OCIO_ACTIVE_DISPLAYS, OCIO_ACTIVE_VIEWS and\n"
                                      "OCIO_OPTIMIZATION_FLAGS, too.\n"
                                      ".El\n";

static const char *const hdr_examples[] = {"hdr log then png -o OUT.png IN.exr",
                                           "hdr divmax --percentile 99.9 then srgb then png IN.exr > OUT.png",
                                           "hdr-log < IN.exr | hdr-srgb | hdr-png > OUT.png",
                                           "hdr expose --ev 1.5 : exr -o OUT.exr IN.exr",
                                           "hdr stats --json IN.exr",
                                           NULL};

static void print_verb_items(const struct kind *kind) {
    const hdr_verb_about *verb;
    printf(".Ss %s\n.Bl -tag -width Ds\n", kind->title);
    for (int i = 0; (verb = hdr_verb_at(i)) != NULL; i++)
        if (verb->kind == kind->kind) printf(".It Xr hdr-%s 1\n%s\n", verb->name, verb->summary);
    printf(".El\n");
}

static void print_hdr_page(void) {
    print_title("hdr", "tone map HDR renders and encode them for a display");
    printf("%s%s", hdr_synopsis, hdr_description);
    for (size_t i = 0; i < KINDS; i++)
        print_verb_items(&kinds[i]);
    printf(".Sh OPTIONS\nEvery verb takes these, once in a chain, beside its own:\n");
    print_option_items(hdr_common_options());
    print_travelling();
    printf("%s", hdr_environment);
    print_exit_statuses();
    print_examples(hdr_examples);
    printf(".Sh SEE ALSO\n.Xr hdrpipe 5 ,\n.Xr hdrpipe 7\n");
}

/* ---- hdr help ---- */

/* hdr help, --list, --man [VERB], --options [VERB], VERB. */
hdr_status cmd_help(int count, const char *const words[], hdr_error *error) {
    const char *mode = count > 0 && words[0][0] == '-' ? words[0] : "";
    const char *name = *mode ? (count > 1 ? words[1] : NULL) : (count > 0 ? words[0] : NULL);
    const hdr_verb_about *verb = name ? hdr_verb_named(name) : NULL;
    if (count > (*mode ? 2 : 1)) return cmd_refuse(error, "help: '%.100s' is one word too many", words[count - 1]);
    if (name && !verb) return cmd_refuse(error, "help: unknown verb '%.100s'; hdr --help lists them", name);
    if (count == 0) {
        cmd_print_usage(stderr);
        return HDR_USAGE;
    }
    if (strcmp(mode, "") == 0) {
        cmd_print_verb_help(stdout, verb);
    } else if (strcmp(mode, "--help") == 0 || strcmp(mode, "-h") == 0) {
        cmd_print_overview(stdout);
    } else if (strcmp(mode, "--list") == 0) {
        print_list();
    } else if (strcmp(mode, "--options") == 0) {
        print_option_names(verb ? verb->options : NULL);
        print_option_names(hdr_common_options());
    } else if (strcmp(mode, "--man") == 0 && verb) {
        print_verb_page(verb);
    } else if (strcmp(mode, "--man") == 0) {
        print_hdr_page();
    } else {
        return cmd_refuse(error, "help: unknown option %.100s", mode);
    }
    return HDR_OK;
}
