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
    hdr_flip flip;           /* with --flip */
    bool tied;               /* it cannot be told from the one above it */
} tested;

typedef struct measuring {
    hdr_chain *chain;
    const char *against, *rank;
    double epsilon, peak; /* peak 0: none */
    hdr_input *reference;
    hdr_structure *structure; /* of the reference, once they are asked for */
    hdr_flip_reference *flip;
    hdr_output *map; /* for FLIP's; or NULL */
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

/* FLIP is a figure of its own. */
static const struct figure flip_figure = {.name = "flip"};

static double figure_of(const hdr_errors *errors, const struct figure *figure) {
    double value;
    memcpy(&value, (const char *)errors + figure->offset, sizeof value);
    return value;
}

/* One of them, by the first letters of a text. */
static const struct figure *figure_named(const char *name, size_t length) {
    for (size_t i = 0; i < FIGURES; i++)
        if (strlen(figures[i].name) == length && !strncmp(figures[i].name, name, length)) return &figures[i];
    return &flip_figure;
}

static double value_of(const tested *test, const struct figure *figure) {
    return figure == &flip_figure ? test->flip.mean : figure_of(&test->compared.all, figure);
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

/* A square's part in the mean that a figure is, before a root is taken. */
typedef struct part {
    double sum, numbers;
} part;

static part part_in(const tested *test, int square, const struct figure *figure) {
    if (figure == &flip_figure) return (part){test->flip.tile[square].sum, test->flip.tile[square].pixels};
    const hdr_tile *tile = &test->compared.tile[square];
    part part = {.numbers = tile->numbers};
    memcpy(&part.sum, (const char *)tile + figure->tile, sizeof part.sum);
    return part;
}

static double mean_in(const tested *test, const struct figure *figure) {
    double sum = 0, numbers = 0;
    for (int i = 0; i < test->compared.tiles; i++) {
        part part = part_in(test, i, figure);
        sum += part.sum;
        numbers += part.numbers;
    }
    return numbers > 0 ? sum / numbers : 0;
}

/* The standard error of the difference of two such means, or of one, other being NULL: that of a ratio of sums over
 * squares which are independent (Cochran, Sampling Techniques, 3rd ed. 1977, 6.4). Below 0: there is one square. */
static double error_of_mean(const tested *test, const tested *other, const struct figure *figure) {
    double mean = mean_in(test, figure), others = other ? mean_in(other, figure) : 0, squares = 0, numbers = 0;
    int used = 0;
    for (int i = 0; i < test->compared.tiles; i++) {
        part own = part_in(test, i, figure), its = {0};
        if (other) its = part_in(other, i, figure);
        double rest = (own.sum - mean * own.numbers) - (its.sum - others * its.numbers);
        squares += rest * rest;
        numbers += own.numbers;
        used += own.numbers > 0;
    }
    return used > 1 ? sqrt(squares * used / (used - 1)) / numbers : -1;
}

/* Of the root of a mean: by the derivative. */
static void find_rank(tested *test, const struct figure *figure) {
    test->rank = value_of(test, figure);
    test->rank_error = error_of_mean(test, NULL, figure);
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
        const tested *better = &m->tests[i - 1], *own = &m->tests[i];
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

/* What takes FLIP for granted calls for it, too. */
static bool wants_flip(const hdr_chain *chain) {
    const char *rank = hdr_chain_given(chain, 1, "rank"), *threshold = hdr_chain_given(chain, 1, "threshold");
    const char *flip = hdr_chain_given(chain, 1, "flip");
    return (flip && strcmp(flip, "none") != 0) || hdr_chain_given(chain, 1, "flip-map") ||
           (rank && !strcmp(rank, "flip")) || (threshold && !strncmp(threshold, "flip=", 5));
}

/* Which it is: the same for all tests. */
static void print_flip_kind(const hdr_flip *flip) {
    bool hdr = flip->kind == HDR_FLIP_HDR;
    printf("%s-FLIP, %g pixels per degree", hdr ? "HDR" : "LDR", flip->pixels_per_degree);
    if (hdr) printf(", %d exposures from %.4f to %.4f, ACES", flip->exposures, flip->start, flip->stop);
    putchar('\n');
}

static void print_flip(const hdr_flip *flip) {
    printf("  %-8s %-14.9g mean of ", "flip", flip->mean);
    print_flip_kind(flip);
    printf("  %-8s min %.6g, max %.6g at %d,%d, weighted median %.6g, quartiles %.6g and %.6g\n", "", flip->min,
           flip->max, flip->max_x, flip->max_y, flip->quartile[1], flip->quartile[0], flip->quartile[2]);
}

static void print_test(const measuring *m, const tested *test) {
    const hdr_comparison *c = &test->compared;
    cmd_print_plain(stdout, test->name);
    printf(" against ");
    cmd_print_plain(stdout, m->against);
    printf("; E = %g\n", c->epsilon);
    print_figures(m, test, &c->all);
    if (wants_ssim(m)) printf("  %-8s %-14.9g of encoded luma\n", "ssim", test->ssim);
    if (m->flip) print_flip(&test->flip);
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
    printf("%4s %-2s %-14s %-12s ", "rank", "", m->rank, "+-");
    if (ssim) printf("%-12s ", "ssim");
    if (m->flip) printf("%-12s ", "flip");
    printf("%-10s file\n", "left out");
    for (int i = 0; i < m->count; i++) {
        const tested *test = &m->tests[i];
        printf("%4d %-2s %-14.9g ", i + 1, test->tied ? "=" : "", test->rank);
        if (test->rank_error >= 0)
            printf("%-12.3g ", test->rank_error);
        else
            printf("%-12s ", "");
        if (ssim) printf("%-12.9f ", test->ssim);
        if (m->flip) printf("%-12.9f ", test->flip.mean);
        printf("%-10llu ", (unsigned long long)test->compared.left_out);
        cmd_print_plain(stdout, test->name);
        putchar('\n');
        tied |= test->tied;
    }
    if (tied) printf("= cannot be told from the one above\n");
    if (!m->flip) return;
    printf("flip is the mean of ");
    print_flip_kind(&m->tests[0].flip);
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

static void print_json_flip(const hdr_flip *flip) {
    bool hdr = flip->kind == HDR_FLIP_HDR;
    cmd_json_open("flip", '{');
    cmd_json_text("kind", hdr ? "hdr" : "ldr");
    cmd_json_number("pixels_per_degree", flip->pixels_per_degree);
    if (hdr) {
        cmd_json_number("start", flip->start);
        cmd_json_number("stop", flip->stop);
        cmd_json_integer("exposures", flip->exposures);
        cmd_json_text("tone_mapper", "aces");
    }
    cmd_json_number("mean", flip->mean);
    cmd_json_number("weighted_quartile_1", flip->quartile[0]);
    cmd_json_number("weighted_median", flip->quartile[1]);
    cmd_json_number("weighted_quartile_3", flip->quartile[2]);
    cmd_json_number("min", flip->min);
    cmd_json_number("max", flip->max);
    cmd_json_integer("x", flip->max_x);
    cmd_json_integer("y", flip->max_y);
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
    if (m->flip) print_json_flip(&test->flip);
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

/* Exposures are empty where there are none. */
static void print_csv_flip(const hdr_flip *flip) {
    bool hdr = flip->kind == HDR_FLIP_HDR;
    printf(",%.17g,%.17g,%s,%.17g", flip->mean, flip->max, hdr ? "hdr" : "ldr", flip->pixels_per_degree);
    if (hdr)
        printf(",%.17g,%.17g,%d", flip->start, flip->stop, flip->exposures);
    else
        printf(",,,");
}

static void print_csv(const measuring *m) {
    printf("file");
    for (size_t i = 0; i < FIGURES; i++)
        printf(",%s", figures[i].name);
    printf(",left_out%s", wants_ssim(m) ? ",ssim" : "");
    if (m->flip) printf(",flip,flip_max,flip_kind,pixels_per_degree,start,stop,exposures");
    double peak = peak_of(m, &m->tests[0].compared); /* of all, since they are of one form */
    printf("%s\n", peak > 0 ? ",psnr" : "");
    for (int t = 0; t < m->count; t++) {
        cmd_print_csv_text(m->tests[t].name);
        for (size_t i = 0; i < FIGURES; i++)
            printf(",%.17g", figure_of(&m->tests[t].compared.all, &figures[i]));
        printf(",%llu", (unsigned long long)m->tests[t].compared.left_out);
        if (wants_ssim(m)) printf(",%.17g", m->tests[t].ssim);
        if (m->flip) print_csv_flip(&m->tests[t].flip);
        if (peak > 0) printf(",%.17g", psnr_of(peak, m->tests[t].compared.all.mse));
        putchar('\n');
    }
}

/* ---- hdr error ---- */

static hdr_status compare_structure(measuring *m, hdr_input *input, double *ssim, hdr_error *error) {
    if (!m->structure) m->structure = hdr_structure_new(m->chain, m->reference, error);
    return m->structure ? hdr_structure_compare(m->structure, input, ssim, error) : error->status;
}

static hdr_flip_kind kind_of(const char *word) {
    if (word && !strcmp(word, "ldr")) return HDR_FLIP_LDR;
    return word && !strcmp(word, "hdr") ? HDR_FLIP_HDR : HDR_FLIP_AUTO;
}

static hdr_status compare_flip(measuring *m, hdr_input *input, hdr_flip *flip, hdr_error *error) {
    if (!m->flip)
        m->flip = hdr_flip_prepare(m->chain, m->reference, kind_of(hdr_chain_given(m->chain, 1, "flip")),
                                   cmd_number(m->chain, 1, "pixels-per-degree", 0), m->named, error);
    hdr_status status = m->flip ? hdr_flip_compare(m->flip, input, m->map, flip, error) : error->status;
    if (status != HDR_OK || !m->map) return status;
    return cmd_write_plane(m->chain, flip->width, flip->height, flip->map, m->map, error);
}

static void free_test(tested *test) {
    hdr_comparison_free(&test->compared);
    hdr_flip_free(&test->flip);
}

static hdr_status measure_file(measuring *m, const char *name, hdr_error *error) {
    tested *test = &m->tests[m->count];
    hdr_input *input = hdr_input_open(name, error);
    hdr_status status =
        input ? hdr_compare(m->chain, input, m->reference, m->epsilon, &test->compared, error) : error->status;
    if (status == HDR_OK && wants_ssim(m)) status = compare_structure(m, input, &test->ssim, error);
    if (status == HDR_OK && wants_flip(m->chain)) status = compare_flip(m, input, &test->flip, error);
    hdr_input_free(input);
    test->name = name;
    if (status == HDR_OK)
        m->count++;
    else
        free_test(test);
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
        double value = value_of(&m->tests[i], figure_named(threshold, length));
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
    if (hdr_chain_given(chain, 1, "pixels-per-degree") && !wants_flip(chain))
        return cmd_refuse(error, "error: --pixels-per-degree is for --flip");
    if (hdr_chain_given(chain, 1, "flip-map") && hdr_chain_files(chain)[0] && hdr_chain_files(chain)[1])
        return cmd_refuse(error, "error: --flip-map is of one test");
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
    const char *map = hdr_chain_given(chain, 1, "flip-map");
    if (!m.tests) cmd_out_of_memory(error);
    if (m.tests && map) m.map = hdr_output_open(map, error);
    if (error->status == HDR_OK) m.reference = hdr_input_open(m.against, error);
    status = m.reference ? measure_files(&m, files, error) : error->status;
    if (m.count > 0) {
        rank_tests(&m);
        print_all(&m);
    }
    hdr_status judged = judge(&m);
    for (int i = 0; i < m.count; i++)
        free_test(&m.tests[i]);
    hdr_output_free(m.map);
    hdr_flip_reference_free(m.flip);
    hdr_structure_free(m.structure);
    hdr_input_free(m.reference);
    free(m.tests);
    return status != HDR_OK ? status : judged;
}
