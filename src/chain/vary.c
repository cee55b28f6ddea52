/* Chains made of others. */
#include "chain/chain.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char *hdr_chain_text(const hdr_chain *chain, hdr_error *err) {
    hdr_bytes text = {0};
    hdr_status status = hdr_chain_print(chain, &text, err);
    if (!status) status = hdr_bytes_add(&text, "", 1, err);
    if (!status) return (char *)text.data;
    free(text.data);
    return NULL;
}

/* Options that say what is written around and behind the pixels, which those that are looked at have otherwise. */
static bool is_of_output(const hdr_chain *chain, const hdr_option *option) {
    bool alpha = !strcmp(option->name, "alpha") && chain->common.alpha.how != HDR_ALPHA_OVER;
    return alpha || !strcmp(option->name, "window");
}

/* The options that travel, one by one, into a chain that has none yet. */
static hdr_status add_reading(hdr_chain *chain, const hdr_chain *other, bool viewing, hdr_error *err) {
    const hdr_options *given = &other->common_given;
    hdr_status status = HDR_OK;
    for (int i = 0; i < given->count && !status; i++) {
        const hdr_option *option = given->given[i].option;
        char name[80];
        const char *const words[] = {name, given->given[i].text};
        snprintf(name, sizeof name, "--%s", option->name);
        if (option->travels && !(viewing && is_of_output(other, option)))
            status = hdr_chain_add_reading(chain, words, words[1] ? 2 : 1, err);
    }
    return status;
}

static hdr_chain *new_like(const hdr_chain *other, bool viewing, hdr_error *err) {
    hdr_chain *chain = hdr_chain_new(err);
    if (chain && !add_reading(chain, other, viewing, err) && !hdr_chain_add_local(chain, other, err)) return chain;
    hdr_chain_free(chain);
    return NULL;
}

hdr_chain *hdr_chain_new_like(const hdr_chain *other, hdr_error *err) {
    return new_like(other, false, err);
}

hdr_chain *hdr_chain_new_viewing(const hdr_chain *other, hdr_error *err) {
    static const char *const words[] = {"--window", "data", "--alpha", "drop"};
    hdr_chain *chain = new_like(other, true, err);
    int count = other->common.alpha.how == HDR_ALPHA_OVER ? 2 : 4;
    if (chain && !hdr_chain_add_reading(chain, words, count, err)) return chain;
    hdr_chain_free(chain);
    return NULL;
}

/* The words of a clause, its options as --name=value, then the further ones. */
static hdr_status add_words(hdr_chain *chain, const hdr_clause *clause, char **own, const char *const further[],
                            int count, hdr_error *err) {
    int given = clause->given.count, total = 1 + given + count;
    const char **words = hdr_alloc((size_t)total, sizeof *words);
    if (!words) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    words[0] = clause->verb->about.name;
    for (int i = 0; i < given; i++)
        words[1 + i] = own[i];
    for (int i = 0; i < count; i++)
        words[1 + given + i] = further[i];
    hdr_status status = hdr_chain_add(chain, words, total, err);
    free(words);
    return status;
}

static char *option_word(const hdr_given *given) {
    size_t size = strlen(given->option->name) + (given->text ? strlen(given->text) : 0) + 4;
    char *word = hdr_alloc(size, 1);
    if (word)
        snprintf(word, size, "--%s%s%s", given->option->name, given->text ? "=" : "", given->text ? given->text : "");
    return word;
}

hdr_status hdr_chain_add_again(hdr_chain *chain, const hdr_chain *other, int number, const char *const words[],
                               int count, hdr_error *err) {
    if (!hdr_chain_clause(other, number)) return hdr_fail(err, HDR_USAGE, "there is no clause %d", number);
    const hdr_clause *clause = &other->clauses[number - 1];
    char **own = hdr_alloc((size_t)clause->given.count, sizeof *own);
    bool made = own != NULL;
    for (int i = 0; made && i < clause->given.count; i++)
        made = (own[i] = option_word(&clause->given.given[i])) != NULL;
    hdr_status status =
        made ? add_words(chain, clause, own, words, count, err) : hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int i = 0; own && i < clause->given.count; i++)
        free(own[i]);
    free(own);
    return status;
}

/* A clause: words, parted by spaces, and the value of the option that stands for them. */
static hdr_status add_spelt_out(hdr_chain *chain, const char *words, const char *value, hdr_error *err) {
    char text[100];
    const char *word[8];
    int count = 0;
    snprintf(text, sizeof text, "%s", words);
    for (char *rest = NULL, *w = strtok_r(text, " ", &rest); w && count < 7; w = strtok_r(NULL, " ", &rest))
        word[count++] = w;
    word[count++] = value;
    return hdr_chain_add_clause(chain, word, count, err);
}

hdr_status hdr_chain_spell_out(hdr_chain *chain, hdr_error *err) {
    int number = chain->count - 1;
    hdr_status status = HDR_OK;
    for (int i = 0; number >= 0 && !status && i < chain->clauses[number].given.count;) {
        hdr_options *given = &chain->clauses[number].given;
        const hdr_given taken = given->given[i];
        if (!taken.option->clause) {
            i++;
            continue;
        }
        memmove(given->given + i, given->given + i + 1, (size_t)(--given->count - i) * sizeof taken);
        if (strcmp(taken.text, taken.option->default_value) != 0)
            status = add_spelt_out(chain, taken.option->clause, taken.text, err);
        free(taken.text);
    }
    return status;
}
