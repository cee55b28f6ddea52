/* For the oracle's tests: runs the library on a chain given as a line of words, from memory to memory. */
#ifndef HDR_TESTS_ORACLE_RUN_H
#define HDR_TESTS_ORACLE_RUN_H

#include "hdrpipe.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { ORACLE_LINE = 400, ORACLE_LINE_WORDS = 100 };

/* NULL, with the error filled, where the words make no chain. */
static inline hdr_chain *oracle_library_chain(const char *text, hdr_error *error) {
    char line[ORACLE_LINE];
    const char *words[ORACLE_LINE_WORDS];
    int count = 0;
    snprintf(line, sizeof line, "%s", text);
    for (char *rest, *word = strtok_r(line, " ", &rest); word && count < ORACLE_LINE_WORDS;
         word = strtok_r(NULL, " ", &rest))
        words[count++] = word;
    hdr_chain *chain = hdr_chain_new(error);
    if (chain && hdr_chain_parse(chain, count, words, error) != HDR_OK) {
        hdr_chain_free(chain);
        return NULL;
    }
    return chain;
}

/* The input is freed. NULL, with the error filled, where the run fails; else the caller frees the output. */
static inline hdr_output *oracle_run(const char *text, hdr_input *input, hdr_error *error) {
    hdr_chain *chain = oracle_library_chain(text, error);
    hdr_output *output = chain ? hdr_output_memory(error) : NULL;
    bool done = input && output && hdr_chain_run(chain, input, output, NULL, error) == HDR_OK;
    hdr_chain_free(chain);
    hdr_input_free(input);
    if (done) return output;
    hdr_output_free(output);
    return NULL;
}

#endif
