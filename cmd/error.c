/* hdr error: figures of pictures against a reference. */
#include "cmd.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One test. */
typedef struct tested {
    const char *name;
    hdr_comparison compared;
    double rank, rank_error; /* the figure that it is ranked by, and its standard error */
    double ssim;             /* with --ssim */
    bool tied;               /* it cannot be told from the one above it */
} tested;

typedef struct measuring {
    hdr_chain *chain;
    const char *against, *rank;
    double epsilon, peak; /* peak 0: none */
    hdr_input *reference;
    tested *tests;
    int count, named; /* those that could be compared, and all */
} measuring;

/* ---- Figures ---- */

static const struct figure {
    const char *name;
    size_t offset, tile; /* in hdr_errors; of the sum that it is made of in hdr_tile */
    const char *form;
} figures[] = {
    {"bias", offsetof(hdr_errors, bias), offsetof(hdr_tile, signed_sum), "mean of x - r"},
    {"mae", offsetof(hdr_errors, mae), offsetof(hdr_tile, absolute), "mean of |x - r|"},
    {"mse", offsetof(hdr_errors, mse), offsetof(hdr_tile, squared), "mean of (x - r)^2"},
    {"rmse", offsetof(hdr_errors, rmse), offsetof(hdr_tile, squared), "root of mse"},
    {"mrse", offsetof(hdr_errors, mrse), offsetof(hdr_tile, relative_square), "mean of (x - r)^2 / (r^2 + E)"},
    {"mape", offsetof(hdr_errors, mape), offsetof(hdr_tile, relative), "mean of |x - r| / (|r| + E)"},
    {"smape", offsetof(hdr_errors, smape), offsetof(hdr_tile, symmetric), "mean of |x - r| / (|x| + |r| + E)"},
};
#define FIGURES (sizeof figures / sizeof *figures)

static double figure_of(const hdr_errors *errors, const struct figure *figure) {
    double value;
    memcpy(&value, (const char *)errors + figure->offset, sizeof value);
    return value;
}

/* One of them, by the first letters of a text. */
static const struct figure *figure_named(const char *name, size_t length) {
    for (size_t i = 0; i < FIGURES; i++)
        if (strlen(figures[i].name) == length && !strncmp(figures[i].name, name, length)) return &figures[i];
    return NULL;
}

/* The peak that PSNR is told for; 0: none. */
static double peak_of(const measuring *m, const hdr_comparison *compared) {
    if (m->peak > 0) return m->peak;
    return strcmp(compared->picture.state, "linear") != 0 ? 1 : 0;
}

static double psnr_of(double peak, double mse) {
    return 10 * log10(peak * peak / mse);
}

/* ---- Ranking ---- */

static double sum_in(const hdr_tile *tile, const struct figure *figure) {
    double value;
    memcpy(&value, (const char *)tile + figure->tile, sizeof value);
    return value;
}

/* The mean that a figure is, before a root is taken. */
static double mean_in(const hdr_comparison *c, const struct figure *figure) {
    double sum = 0, numbers = 0;
    for (int i = 0; i < c->tiles; i++) {
        sum += sum_in(&c->tile[i], figure);
        numbers += c->tile[i].numbers;
    }
    return numbers > 0 ? sum / numbers : 0;
}

/* The standard error of the difference of two such means, or of one, other being NULL: that of a ratio of sums over
 * squares which are independent (Cochran, Sampling Techniques, 3rd ed. 1977, 6.4). Below 0: there is one square. */
static double error_of_mean(const hdr_comparison *c, const hdr_comparison *other, const struct figure *figure) {
    double mean = mean_in(c, figure), others = other ? mean_in(other, figure) : 0, squares = 0, numbers = 0;
    int used = 0;
    for (int i = 0; i < c->tiles; i++) {
        double n = c->tile[i].numbers, rest = sum_in(&c->tile[i], figure) - mean * n;
        if (other) rest -= sum_in(&other->tile[i], figure) - others * other->tile[i].numbers;
        squares += rest * rest;
        numbers += n;
        used += n > 0;
    }
    return used > 1 ? sqrt(squares * used / (used - 1)) / numbers : -1;
}

/* Of the root of a mean: by the derivative. */
static void find_rank(tested *test, const struct figure *figure) {
    test->rank = figure_of(&test->compared.all, figure);
    test->rank_error = error_of_mean(&test->compared, NULL, figure);
    if (!strcmp(figure->name, "rmse") && test->rank_error > 0) test->rank_error /= 2 * test->rank;
}

static int compare_tests(const void *a, const void *b) {
    const tested *x = a, *y = b;
    if (x->rank != y->rank) return x->rank < y->rank ? -1 : 1;
    return strcmp(x->name, y->name);
}

static void rank_tests(measuring *m) {
    const struct figure *figure = figure_named(m->rank, strlen(m->rank));
    for (int i = 0; i < m->count; i++)
        find_rank(&m->tests[i], figure);
    qsort(m->tests, (size_t)m->count, sizeof *m->tests, compare_tests);
    for (int i = 1; i < m->count; i++) {
        const hdr_comparison *better = &m->tests[i - 1].compared, *own = &m->tests[i].compared;
        double difference = mean_in(own, figure) - mean_in(better, figure);
        double error = error_of_mean(own, better, figure);
        m->tests[i].tied = error < 0 || difference <= 1.96 * error;
    }
}

/* ---- For people ---- */

static void print_figures(const measuring *m, const tested *test, const hdr_errors *errors) {
    for (size_t i = 0; i < FIGURES; i++)
        printf("  %-8s %-14.9g %s\n", figures[i].name, figure_of(errors, &figures[i]), figures[i].form);
    double peak = peak_of(m, &test->compared);
    if (peak > 0) printf("  %-8s %-14.6g dB, for a peak of %g\n", "psnr", psnr_of(peak, errors->mse), peak);
}

static bool wants_ssim(const measuring *m) {
    return hdr_chain_given(m->chain, 1, "ssim") != NULL;
}

static void print_test(const measuring *m, const tested *test) {
    const hdr_comparison *c = &test->compared;
    cmd_print_plain(stdout, test->name);
    printf(" against ");
    cmd_print_plain(stdout, m->against);
    printf("; E = %g\n", c->epsilon);
    print_figures(m, test, &c->all);
    if (wants_ssim(m)) printf("  %-8s %-14.9g of encoded luma\n", "ssim", test->ssim);
    for (int plane = 0; plane < 4 && hdr_chain_given(m->chain, 1, "by-channel"); plane++) {
        if (!c->present[plane]) continue;
        printf("  channel %s\n", cmd_plane_name(&c->picture, plane));
        print_figures(m, test, &c->channel[plane]);
    }
    if (c->worst_channel >= 0)
        printf("  worst    %.9g at %d,%d in %s: %.9g, reference %.9g\n", c->worst, c->worst_x, c->worst_y,
               cmd_plane_name(&c->picture, c->worst_channel), c->worst_test, c->worst_reference);
    printf("  left out %llu (NaN or infinite)\n", (unsigned long long)c->left_out);
}

static void print_ranking(const measuring *m) {
    bool ssim = wants_ssim(m), tied = false;
    printf("%4s %-2s %-14s %-12s %s%-10s file\n", "rank", "", m->rank, "+-", ssim ? "ssim         " : "", "left out");
    for (int i = 0; i < m->count; i++) {
        const tested *test = &m->tests[i];
        printf("%4d %-2s %-14.9g ", i + 1, test->tied ? "=" : "", test->rank);
        if (test->rank_error >= 0)
            printf("%-12.3g ", test->rank_error);
        else
            printf("%-12s ", "");
        if (ssim) printf("%-12.9f ", test->ssim);
        printf("%-10llu ", (unsigned long long)test->compared.left_out);
        cmd_print_plain(stdout, test->name);
        putchar('\n');
        tied |= test->tied;
    }
    if (tied) printf("= cannot be told from the one above\n");
}

/* ---- For programs ---- */

static void print_json_figures(const measuring *m, const tested *test, const hdr_errors *errors) {
    cmd_json_integer("numbers", (long long)errors->numbers);
    for (size_t i = 0; i < FIGURES; i++)
        cmd_json_number(figures[i].name, figure_of(errors, &figures[i]));
    double peak = peak_of(m, &test->compared);
    if (peak <= 0) return;
    cmd_json_number("psnr", psnr_of(peak, errors->mse));
    cmd_json_number("peak", peak);
}

static void print_json_worst(const hdr_comparison *c) {
    cmd_json_open("worst", '{');
    cmd_json_number("error", c->worst);
    cmd_json_integer("x", c->worst_x);
    cmd_json_integer("y", c->worst_y);
    cmd_json_text("channel", cmd_plane_name(&c->picture, c->worst_channel));
    cmd_json_number("test", c->worst_test);
    cmd_json_number("reference", c->worst_reference);
    cmd_json_close('}');
}

static void print_json(const measuring *m, const tested *test) {
    const hdr_comparison *c = &test->compared;
    cmd_json_open(NULL, '{');
    cmd_json_text("file", test->name);
    cmd_json_text("against", m->against);
    cmd_json_number("epsilon", c->epsilon);
    print_json_figures(m, test, &c->all);
    if (wants_ssim(m)) cmd_json_number("ssim", test->ssim);
    cmd_json_integer("left_out", (long long)c->left_out);
    if (c->worst_channel >= 0) print_json_worst(c);
    for (int plane = 0; plane < 4 && hdr_chain_given(m->chain, 1, "by-channel"); plane++) {
        if (!c->present[plane]) continue;
        cmd_json_open(cmd_plane_name(&c->picture, plane), '{');
        print_json_figures(m, test, &c->channel[plane]);
        cmd_json_close('}');
    }
    if (m->named > 1) {
        cmd_json_known("rank_error", test->rank_error);
        cmd_json_flag("tied", test->tied);
    }
    cmd_json_end();
}

static void print_csv(const measuring *m) {
    printf("file");
    for (size_t i = 0; i < FIGURES; i++)
        printf(",%s", figures[i].name);
    printf(",left_out%s%s\n", wants_ssim(m) ? ",ssim" : "", m->peak > 0 ? ",psnr" : "");
    for (int t = 0; t < m->count; t++) {
        cmd_print_csv_text(m->tests[t].name);
        for (size_t i = 0; i < FIGURES; i++)
            printf(",%.17g", figure_of(&m->tests[t].compared.all, &figures[i]));
        printf(",%llu", (unsigned long long)m->tests[t].compared.left_out);
        if (wants_ssim(m)) printf(",%.17g", m->tests[t].ssim);
        if (m->peak > 0) printf(",%.17g", psnr_of(m->peak, m->tests[t].compared.all.mse));
        putchar('\n');
    }
}

/* ---- hdr error ---- */

static hdr_status measure_file(measuring *m, const char *name, hdr_error *error) {
    tested *test = &m->tests[m->count];
    hdr_input *input = hdr_input_open(name, error);
    hdr_status status =
        input ? hdr_compare(m->chain, input, m->reference, m->epsilon, &test->compared, error) : error->status;
    if (status == HDR_OK && wants_ssim(m))
        status = hdr_compare_structure(m->chain, input, m->reference, &test->ssim, error);
    hdr_input_free(input);
    test->name = name;
    if (status == HDR_OK)
        m->count++;
    else
        hdr_comparison_free(&test->compared);
    return status;
}

/* Faults of single tests are reported, and the rest goes on. */
static hdr_status measure_files(measuring *m, const char *const *files, hdr_error *error) {
    if (!files[1]) return measure_file(m, files[0], error);
    hdr_status status = HDR_OK;
    for (int i = 0; files[i]; i++) {
        hdr_error fault = {0};
        if (measure_file(m, files[i], &fault) == HDR_OK) continue;
        cmd_report(&fault);
        status = HDR_DIFFERENT;
    }
    return status;
}

static void print_all(const measuring *m) {
    bool json = hdr_chain_settings(m->chain)->json;
    if (!json && hdr_chain_given(m->chain, 1, "csv")) {
        print_csv(m);
        return;
    }
    for (int i = 0; i < m->count; i++) {
        if (json)
            print_json(m, &m->tests[i]);
        else if (m->named == 1)
            print_test(m, &m->tests[i]);
    }
    if (!json && m->named > 1) print_ranking(m);
}

/* Says which figures are above --threshold. */
static hdr_status judge(const measuring *m) {
    const char *threshold = hdr_chain_given(m->chain, 1, "threshold");
    hdr_status status = HDR_OK;
    if (!threshold) return HDR_OK;
    size_t length = strcspn(threshold, "=");
    double limit = strtod(threshold + length + 1, NULL);
    for (int i = 0; i < m->count; i++) {
        const hdr_comparison *compared = &m->tests[i].compared;
        double value = figure_of(&compared->all, figure_named(threshold, length));
        if (value <= limit && compared->left_out == 0) continue;
        fprintf(stderr, "hdr: ");
        cmd_print_plain(stderr, m->tests[i].name);
        if (value > limit)
            fprintf(stderr, ": %.*s is %.9g, above %g\n", (int)length, threshold, value, limit);
        else
            fprintf(stderr, ": %llu components are NaN or infinite\n", (unsigned long long)compared->left_out);
        status = HDR_DIFFERENT;
    }
    return status;
}

static hdr_status check(const hdr_chain *chain, hdr_error *error) {
    if (hdr_chain_clause(chain, 2)) return cmd_refuse(error, "error compares files: write what a chain makes first");
    if (!hdr_chain_given(chain, 1, "against"))
        return cmd_refuse(error, "error: --against FILE is missing: the reference");
    if (hdr_chain_settings(chain)->json && hdr_chain_given(chain, 1, "csv"))
        return cmd_refuse(error, "error: either --csv or --json");
    if (hdr_chain_given(chain, 1, "by-channel") && hdr_chain_given(chain, 1, "csv"))
        return cmd_refuse(error, "error: --by-channel is for --json and for words");
    return cmd_check_standard_input(hdr_chain_files(chain), hdr_chain_given(chain, 1, "against"), error);
}

hdr_status cmd_error(hdr_chain *chain, hdr_error *error) {
    hdr_status status = check(chain, error);
    if (status != HDR_OK) return status;
    static const char *const standard_input[] = {"-", NULL};
    const char *const *files = hdr_chain_files(chain)[0] ? hdr_chain_files(chain) : standard_input;
    const char *rank = hdr_chain_given(chain, 1, "rank");
    measuring m = {.chain = chain, .against = hdr_chain_given(chain, 1, "against"), .rank = rank ? rank : "rmse"};
    m.epsilon = cmd_number(chain, 1, "epsilon", 0);
    m.peak = cmd_number(chain, 1, "peak", 0);
    while (files[m.named])
        m.named++;
    m.tests = calloc((size_t)m.named, sizeof *m.tests);
    m.reference = m.tests ? hdr_input_open(m.against, error) : NULL;
    if (!m.tests) cmd_out_of_memory(error);
    status = m.reference ? measure_files(&m, files, error) : error->status;
    rank_tests(&m);
    if (m.count > 0) print_all(&m);
    hdr_status judged = judge(&m);
    for (int i = 0; i < m.count; i++)
        hdr_comparison_free(&m.tests[i].compared);
    hdr_input_free(m.reference);
    free(m.tests);
    return status != HDR_OK ? status : judged;
}
