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
    int count;
} measuring;

/* ---- Figures ---- */

static const struct figure {
    const char *name;
    size_t offset;
    const char *form;
} figures[] = {
    {"bias", offsetof(hdr_errors, bias), "mean of x - r"},
    {"mae", offsetof(hdr_errors, mae), "mean of |x - r|"},
    {"mse", offsetof(hdr_errors, mse), "mean of (x - r)^2"},
    {"rmse", offsetof(hdr_errors, rmse), "root of mse"},
    {"mrse", offsetof(hdr_errors, mrse), "mean of (x - r)^2 / (r^2 + E)"},
    {"mape", offsetof(hdr_errors, mape), "mean of |x - r| / (|r| + E)"},
    {"smape", offsetof(hdr_errors, smape), "mean of |x - r| / (|x| + |r| + E)"},
};
#define FIGURES (sizeof figures / sizeof *figures)

static double figure_of(const hdr_errors *errors, const struct figure *figure) {
    double value;
    memcpy(&value, (const char *)errors + figure->offset, sizeof value);
    return value;
}

static double named_figure(const hdr_errors *errors, const char *name, size_t length) {
    for (size_t i = 0; i < FIGURES; i++)
        if (strlen(figures[i].name) == length && !strncmp(figures[i].name, name, length))
            return figure_of(errors, &figures[i]);
    return 0;
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

/* Mean of the numbers, and its standard error as if they were independent. */
static void mean_of(const double *value, const double *less, int count, double *mean, double *error) {
    double squares = 0;
    *mean = 0;
    for (int i = 0; i < count; i++) {
        double number = value[i] - (less ? less[i] : 0), d = number - *mean;
        *mean += d / (i + 1);
        squares += d * (number - *mean);
    }
    *error = count > 1 ? sqrt(squares / (count - 1) / count) : 0;
}

/* Of figures other than mse and rmse the squares tell nothing. */
static void find_rank_error(tested *test, const char *rank) {
    double mean, error;
    mean_of(test->compared.tile_error, NULL, test->compared.tiles, &mean, &error);
    test->rank_error = !strcmp(rank, "mse")                      ? error
                       : !strcmp(rank, "rmse") && test->rank > 0 ? error / (2 * test->rank)
                                                                 : 0;
}

static int compare_tests(const void *a, const void *b) {
    const tested *x = a, *y = b;
    if (x->rank != y->rank) return x->rank < y->rank ? -1 : 1;
    return strcmp(x->name, y->name);
}

static void rank_tests(measuring *m) {
    for (int i = 0; i < m->count; i++) {
        m->tests[i].rank = named_figure(&m->tests[i].compared.all, m->rank, strlen(m->rank));
        find_rank_error(&m->tests[i], m->rank);
    }
    qsort(m->tests, (size_t)m->count, sizeof *m->tests, compare_tests);
    for (int i = 1; i < m->count; i++) {
        const hdr_comparison *better = &m->tests[i - 1].compared, *own = &m->tests[i].compared;
        double mean, error;
        mean_of(own->tile_error, better->tile_error, own->tiles, &mean, &error);
        m->tests[i].tied = fabs(mean) <= 1.96 * error;
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
    printf("%4s %-2s %-14s %-12s file\n", "rank", "", m->rank, "+-");
    for (int i = 0; i < m->count; i++) {
        const tested *test = &m->tests[i];
        printf("%4d %-2s %-14.9g %-12.3g ", i + 1, test->tied ? "=" : "", test->rank, test->rank_error);
        cmd_print_plain(stdout, test->name);
        putchar('\n');
    }
    for (int i = 1; i < m->count; i++)
        if (m->tests[i].tied) {
            printf("= cannot be told from the one above\n");
            break;
        }
}

/* ---- For programs ---- */

static void print_json_figures(const measuring *m, const tested *test, const hdr_errors *errors) {
    printf("\"numbers\": %llu", (unsigned long long)errors->numbers);
    for (size_t i = 0; i < FIGURES; i++) {
        printf(", \"%s\": ", figures[i].name);
        cmd_print_json_number(figure_of(errors, &figures[i]));
    }
    double peak = peak_of(m, &test->compared);
    if (peak <= 0) return;
    printf(", \"psnr\": ");
    if (errors->mse > 0)
        cmd_print_json_number(psnr_of(peak, errors->mse));
    else
        printf("null");
    printf(", \"peak\": ");
    cmd_print_json_number(peak);
}

static void print_json(const measuring *m, const tested *test) {
    const hdr_comparison *c = &test->compared;
    printf("{\"file\": ");
    cmd_print_json_text(test->name);
    printf(", \"against\": ");
    cmd_print_json_text(m->against);
    printf(", \"epsilon\": ");
    cmd_print_json_number(c->epsilon);
    printf(", ");
    print_json_figures(m, test, &c->all);
    if (wants_ssim(m)) {
        printf(", \"ssim\": ");
        cmd_print_json_number(test->ssim);
    }
    printf(", \"left_out\": %llu", (unsigned long long)c->left_out);
    if (c->worst_channel >= 0) {
        printf(", \"worst\": {\"error\": ");
        cmd_print_json_number(c->worst);
        printf(", \"x\": %d, \"y\": %d, \"channel\": \"%s\", \"test\": ", c->worst_x, c->worst_y,
               cmd_plane_name(&c->picture, c->worst_channel));
        cmd_print_json_number(c->worst_test);
        printf(", \"reference\": ");
        cmd_print_json_number(c->worst_reference);
        putchar('}');
    }
    for (int plane = 0; plane < 4 && hdr_chain_given(m->chain, 1, "by-channel"); plane++) {
        if (!c->present[plane]) continue;
        printf(", \"%s\": {", cmd_plane_name(&c->picture, plane));
        print_json_figures(m, test, &c->channel[plane]);
        putchar('}');
    }
    if (m->count > 1) {
        printf(", \"rank_error\": ");
        cmd_print_json_number(test->rank_error);
        printf(", \"tied\": %s", test->tied ? "true" : "false");
    }
    printf("}\n");
}

static void print_csv(const measuring *m) {
    printf("file");
    for (size_t i = 0; i < FIGURES; i++)
        printf(",%s", figures[i].name);
    printf(wants_ssim(m) ? ",left_out,ssim\n" : ",left_out\n");
    for (int t = 0; t < m->count; t++) {
        cmd_print_csv_text(m->tests[t].name);
        for (size_t i = 0; i < FIGURES; i++)
            printf(",%.17g", figure_of(&m->tests[t].compared.all, &figures[i]));
        printf(",%llu", (unsigned long long)m->tests[t].compared.left_out);
        if (wants_ssim(m)) printf(",%.17g", m->tests[t].ssim);
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
        else if (m->count == 1)
            print_test(m, &m->tests[i]);
    }
    if (!json && m->count > 1) print_ranking(m);
}

/* Says which figures are above --threshold. */
static hdr_status judge(const measuring *m) {
    const char *threshold = hdr_chain_given(m->chain, 1, "threshold");
    hdr_status status = HDR_OK;
    if (!threshold) return HDR_OK;
    size_t length = strcspn(threshold, "=");
    double limit = strtod(threshold + length + 1, NULL);
    for (int i = 0; i < m->count; i++) {
        double value = named_figure(&m->tests[i].compared.all, threshold, length);
        if (!(value > limit)) continue;
        fprintf(stderr, "hdr: %s: %.*s is %.9g, above %g\n", m->tests[i].name, (int)length, threshold, value, limit);
        status = HDR_DIFFERENT;
    }
    return status;
}

static hdr_status check(const hdr_chain *chain, hdr_error *error) {
    if (hdr_chain_clause(chain, 2)) return cmd_refuse(error, "error compares files: write what a chain makes first");
    if (!hdr_chain_given(chain, 1, "against"))
        return cmd_refuse(error, "error: --against FILE is missing: the reference");
    if (!hdr_chain_files(chain)[0])
        return cmd_refuse(error, "error: a file is missing: hdr error --against REFERENCE FILE...");
    if (hdr_chain_settings(chain)->json && hdr_chain_given(chain, 1, "csv"))
        return cmd_refuse(error, "error: either --csv or --json");
    return HDR_OK;
}

hdr_status cmd_error(hdr_chain *chain, hdr_error *error) {
    hdr_status status = check(chain, error);
    if (status != HDR_OK) return status;
    const char *const *files = hdr_chain_files(chain), *rank = hdr_chain_given(chain, 1, "rank");
    measuring m = {.chain = chain, .against = hdr_chain_given(chain, 1, "against"), .rank = rank ? rank : "rmse"};
    m.epsilon = cmd_given_number(chain, "epsilon", 0.01);
    m.peak = cmd_given_number(chain, "peak", 0);
    int count = 0;
    while (files[count])
        count++;
    m.tests = calloc((size_t)count, sizeof *m.tests);
    m.reference = m.tests ? hdr_input_open(m.against, error) : NULL;
    if (!m.tests) {
        snprintf(error->message, sizeof error->message, "out of memory");
        error->status = HDR_INTERNAL;
    }
    status = m.reference ? measure_files(&m, files, error) : error->status;
    rank_tests(&m);
    print_all(&m);
    hdr_status judged = judge(&m);
    for (int i = 0; i < m.count; i++)
        hdr_comparison_free(&m.tests[i].compared);
    hdr_input_free(m.reference);
    free(m.tests);
    return status != HDR_OK ? status : judged;
}
