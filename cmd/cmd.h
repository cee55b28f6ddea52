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

/* The number that an option of the first clause was given as; of a word, 0. */
double cmd_given_number(const hdr_chain *chain, const char *name, double otherwise);

/* help.c: words after `hdr help`. */
hdr_status cmd_help(int count, const char *const words[], hdr_error *error);
void cmd_print_usage(FILE *to);
void cmd_print_version(void);
void cmd_print_overview(FILE *to);
void cmd_print_verb_help(FILE *to, const hdr_verb_about *verb);

/* info.c: what a picture is. */
hdr_status cmd_info(hdr_chain *chain, hdr_error *error);
void cmd_print_picture(const hdr_picture *picture);
void cmd_print_picture_json(const hdr_picture *picture); /* members of an object, without the braces around them */

/* info.c: one file after another, standard input when there is none. Faults of single files are reported, and the rest
 * goes on: HDR_DIFFERENT when some of several failed. */
typedef hdr_status (*cmd_file_job)(hdr_chain *chain, hdr_input *input, const char *name, hdr_error *error);
hdr_status cmd_each_file(hdr_chain *chain, cmd_file_job job, hdr_error *error);

/* What windows and types look like; width: of the label's column. */
void cmd_print_window(const char *label, const hdr_window *window, int width);
void cmd_print_json_window(const char *key, const hdr_window *window); /* ", key: [...]" */
const char *cmd_type_name(hdr_type type);

/* contents.c: all that a file holds. */
void cmd_print_contents(const hdr_contents *contents);
void cmd_print_contents_json(const hdr_contents *contents); /* one member of an object */

/* info.c: text for people. Names in a file may hold any byte; what is no character that can be shown becomes '?'. */
void cmd_print_plain(FILE *to, const char *text);

/* info.c: JSON values, to standard output. */
void cmd_print_json_text(const char *text);
void cmd_print_json_number(double number); /* the shortest decimal that reads back as the same double */

/* info.c: a field of comma-separated values. */
void cmd_print_csv_text(const char *text);

/* What a colour plane is called: "R", "G", "B", or "Y" for the only one; plane 3 is "A". */
const char *cmd_plane_name(const hdr_picture *picture, int plane);

/* stats.c */
hdr_status cmd_stats(hdr_chain *chain, hdr_error *error);

/* error.c */
hdr_status cmd_error(hdr_chain *chain, hdr_error *error);

/* noise.c */
hdr_status cmd_noise(hdr_chain *chain, hdr_error *error);

/* ocio.c: the names in the configuration of a clause of the verb ocio */
hdr_status cmd_ocio_list(hdr_chain *chain, int clause, hdr_error *error);

/* crosscheck.c */
hdr_status cmd_crosscheck(hdr_chain *chain, hdr_error *error);

/* bench.c: the chain behind `hdr bench` */
hdr_status cmd_bench(hdr_chain *chain, hdr_error *error);

#endif
