/* What the files of the command line share. Only hdr.c ends the program. */
#ifndef HDR_CMD_H
#define HDR_CMD_H

#include "hdrpipe.h"

#include <stdio.h>

/* Fills the error with words that make no command; HDR_USAGE. */
hdr_status cmd_refuse(hdr_error *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The same where memory is out; HDR_INTERNAL. */
hdr_status cmd_out_of_memory(hdr_error *error);

/* Prints an error on standard error, as "hdr: MESSAGE". */
void cmd_report(const hdr_error *error);

/* What a run has to say, to standard error: notes unless -q, the plan and details as the library sends them. */
hdr_listener cmd_listener(const hdr_chain *chain);

/* All files that are named, or standard input where none is. count 0: the error is filled. */
typedef struct cmd_inputs {
    hdr_input **inputs;
    int count;
} cmd_inputs;
cmd_inputs cmd_open_files(const hdr_chain *chain, hdr_error *error);
void cmd_close_files(cmd_inputs *opened);

/* HDR_USAGE where standard input is named twice, by the files or by another option; NULL: there is none. */
hdr_status cmd_check_standard_input(const char *const files[], const char *other, hdr_error *error);

/* What the chain is run on: the first of them, or all joined, if that is how it begins. */
typedef struct cmd_input {
    hdr_input *input; /* NULL: the error is filled */
    cmd_inputs members;
} cmd_input;
cmd_input cmd_open_input(const hdr_chain *chain, hdr_error *error);
void cmd_close_input(cmd_input *opened);

/* Writes a picture of one plane, in the format that the output's name asks for. */
hdr_status cmd_write_plane(const hdr_chain *chain, int width, int height, const float *numbers, hdr_output *output,
                           hdr_error *error);

/* The number of an option of a clause, 0 being the program that leads: as given or by default. A word instead of a
 * number, or nothing at all: `word`. */
double cmd_number(const hdr_chain *chain, int clause, const char *name, double word);

/* help.c: words after `hdr help`. */
hdr_status cmd_help(int count, const char *const words[], hdr_error *error);
void cmd_print_usage(FILE *to);
void cmd_print_version(void);
void cmd_print_overview(FILE *to);
void cmd_print_verb_help(FILE *to, const hdr_verb_about *verb);

/* info.c: what a picture is. */
hdr_status cmd_info(hdr_chain *chain, hdr_error *error);
void cmd_print_picture(const hdr_picture *picture);
void cmd_json_picture(const hdr_picture *picture); /* members of an object, without the braces around them */

/* info.c: one file after another, standard input when there is none. Faults of single files are reported, and the rest
 * goes on: HDR_DIFFERENT when some of several failed. */
typedef hdr_status (*cmd_file_job)(hdr_chain *chain, hdr_input *input, const char *name, hdr_error *error);
hdr_status cmd_each_file(hdr_chain *chain, cmd_file_job job, hdr_error *error);

/* What windows and types look like; width: of the label's column. */
void cmd_print_window(const char *label, const hdr_window *window, int width);
const char *cmd_type_name(hdr_type type);

/* contents.c: all that a file holds. */
void cmd_print_contents(const hdr_contents *contents);
void cmd_json_contents(const hdr_contents *contents); /* one member of an object */

/* text.c: text for people. Names in a file may hold any byte; what is no character that can be shown becomes '?'. */
void cmd_print_plain(FILE *to, const char *text);

/* text.c: the shortest decimal that reads back as the same double. */
void cmd_print_number(double number);

/* text.c: JSON, to standard output. Each is a member of an object or, key being NULL, an element of an array or a whole
 * text; commas come by themselves. */
void cmd_json_open(const char *key, char bracket); /* '{' or '[' */
void cmd_json_close(char bracket);
void cmd_json_end(void);                               /* the whole text's last '}', and a newline */
void cmd_json_text(const char *key, const char *text); /* NULL: null */
void cmd_json_number(const char *key, double number);  /* not finite: null */
void cmd_json_known(const char *key, double number);   /* the same, of a number that is null below 0 */
void cmd_json_integer(const char *key, long long number);
void cmd_json_integers(const char *key, int count, const int numbers[]);
void cmd_json_flag(const char *key, bool flag);
void cmd_json_window(const char *key, const hdr_window *window);

/* text.c: a field of comma-separated values. */
void cmd_print_csv_text(const char *text);

/* What a colour plane is called: "R", "G", "B", or "Y" for the only one; plane 3 is "A". */
const char *cmd_plane_name(const hdr_picture *picture, int plane);

/* stats.c */
hdr_status cmd_stats(hdr_chain *chain, hdr_error *error);

/* error.c */
hdr_status cmd_error(hdr_chain *chain, hdr_error *error);

/* noise.c; noise_plot.c */
hdr_status cmd_noise(hdr_chain *chain, hdr_error *error);
hdr_status cmd_plot_noise(const hdr_noise *noise, hdr_output *output, hdr_error *error);

/* ocio.c: the names in the configuration of a clause of the verb ocio */
hdr_status cmd_ocio_list(hdr_chain *chain, int clause, hdr_error *error);

/* crosscheck.c */
hdr_status cmd_crosscheck(hdr_chain *chain, hdr_error *error);

/* bench.c: the chain behind `hdr bench` */
hdr_status cmd_bench(hdr_chain *chain, hdr_error *error);

#endif
