/* The bounds that are stated for the ways to compute a bilateral filter, against the exact sum: two hundred scenes made
 * at random, and those that a search found to be the worst.
 *
 *     test_durand_bounds                      the test
 *     test_durand_bounds search SECONDS SEED  looks for worse scenes
 *     test_durand_bounds scene NUMBER...      one scene: its numbers as they are printed, the kind as 0 to 11 */
#include "check.h"
#include "durand_scenes.h"

#include "spatial/ranks.h"

#include <inttypes.h>
#include <string.h>
#include <time.h>

static const double grid_sizes[][2] = {{2, 2}, {2, 4}, {3, 4}, {4, 6}, {2, 3}, {7, 4}, {16, 2}};
enum {
    GRIDS = sizeof grid_sizes / sizeof *grid_sizes,
    DIRECT = GRIDS, /* the sum that is cut */
    CHOSEN,         /* what a tolerance leads to */
    WAYS,
    SCENE_COUNT = 200,
    SAMPLES = 300
};
static const double TAPS = 4e7;    /* of all sums of a scene, about */
static const double CELLS = 1.5e6; /* of a grid: finer ones are left to machines with time */

static hdr_pool *pool;

static void need(hdr_status status, const hdr_error *error) {
    if (status == HDR_OK) return;
    fprintf(stderr, "%s\n", error->message);
    abort();
}

/* ---- A scene and its exact base ---- */

typedef struct question {
    const scene *scene;
    hdr_plane *plane;
    hdr_bilateral filter;
    int count;
    hdr_pixel *pixel;
    double *exact;
} question;

static double number_at(const hdr_plane *plane, int x, int y) {
    return (double)plane->narrow[(size_t)y * plane->stride + (size_t)x];
}

/* No neighbour is as high, or none as low. */
static bool is_extreme(const hdr_plane *plane, int x, int y) {
    int above = 0, below = 0;
    double number = number_at(plane, x, y);
    for (int j = y - 1; j <= y + 1; j++)
        for (int i = x - 1; i <= x + 1; i++) {
            if ((i == x && j == y) || i < 0 || j < 0 || i >= plane->width || j >= plane->height) continue;
            above += number_at(plane, i, j) >= number;
            below += number_at(plane, i, j) <= number;
        }
    return above == 0 || below == 0;
}

/* All pixels where that is cheap, else the marked ones, local extremes, and others at random. */
static void choose_pixels(question *q, const scene_marks *marks, double taps) {
    const hdr_plane *plane = q->plane;
    double pixels = (double)plane->width * plane->height, side = 16 * q->filter.sigma_s + 1;
    double window = fmin(side, plane->width) * fmin(side, plane->height);
    bool all = pixels * window <= taps;
    int wanted = all ? (int)pixels : (int)fmin(SAMPLES, fmax(4, taps / window));
    q->pixel = calloc((size_t)wanted + SCENE_MARKS, sizeof *q->pixel);
    q->exact = calloc((size_t)wanted + SCENE_MARKS, sizeof *q->exact);
    if (!q->pixel || !q->exact) abort();
    uint64_t state = q->scene->seed;
    for (int i = 0; all && i < wanted; i++)
        q->pixel[q->count++] = (hdr_pixel){i % plane->width, i / plane->width};
    for (int i = 0; !all && i < marks->count && q->count < (wanted + 1) / 2; i++)
        q->pixel[q->count++] = marks->pixel[i];
    for (int tries = 0; q->count < wanted; tries++) {
        hdr_pixel p = {(int)(scene_unit(&state) * plane->width), (int)(scene_unit(&state) * plane->height)};
        if (q->count % 2 || tries > 20 * wanted || is_extreme(plane, p.x, p.y)) q->pixel[q->count++] = p;
    }
}

static question ask(const scene *s, double taps) {
    hdr_error error = {0};
    scene_marks marks;
    question q = {
        .scene = s, .plane = scene_plane(s, &marks), .filter = {.sigma_s = s->sigma_s, .sigma_r = s->sigma_r}};
    need(hdr_plane_range(q.plane, &q.filter.low, &q.filter.high, pool, &error), &error);
    choose_pixels(&q, &marks, taps);
    need(hdr_bilateral_exact_at(&q.filter, HDR_EXACT_REACH, q.plane, q.count, q.pixel, q.exact, pool, &error), &error);
    return q;
}

static void forget(question *q) {
    hdr_plane_free(q->plane);
    free(q->pixel);
    free(q->exact);
}

/* ---- Answers ---- */

typedef struct answer {
    bool given;
    double error, bound; /* in units of sigma_r */
    hdr_pixel where;
} answer;

static void measure(const question *q, const double *values, answer *answer) {
    answer->given = true;
    for (int i = 0; i < q->count; i++) {
        double error = fabs(values[i] - q->exact[i]) / q->filter.sigma_r;
        if (error <= answer->error) continue; /* NaN is an error */
        answer->error = error;
        answer->where = q->pixel[i];
    }
}

static double cells_of(const question *q, double across, double deep) {
    across = q->filter.sigma_s / across;
    deep = q->filter.sigma_r / deep;
    return (q->plane->width / across + 4) * (q->plane->height / across + 4) *
           ((q->filter.high - q->filter.low) / deep + 4);
}

static answer ask_grid(const question *q, double across, double deep, double bound, double cells) {
    answer answer = {.bound = bound};
    if (cells_of(q, across, deep) > cells) return answer;
    hdr_error error = {0};
    hdr_plane *base = hdr_plane_new(q->plane->width, q->plane->height, false, &error);
    double *values = calloc((size_t)q->count, sizeof *values);
    hdr_bilateral_report report;
    if (!base || !values) abort();
    for (int y = 0; y < base->height; y++)
        memcpy(base->narrow + (size_t)y * base->stride, q->plane->narrow + (size_t)y * q->plane->stride,
               (size_t)base->width * sizeof(float));
    need(hdr_bilateral_grid(&q->filter, across, deep, base, pool, &report, &error), &error);
    for (int i = 0; i < q->count; i++)
        values[i] = number_at(base, q->pixel[i].x, q->pixel[i].y);
    measure(q, values, &answer);
    hdr_plane_free(base);
    free(values);
    return answer;
}

/* The sum, cut as a choice has it. */
static answer ask_sum(const question *q, const hdr_bilateral_choice *choice) {
    hdr_error error = {0};
    answer answer = {.bound = choice->bound / q->filter.sigma_r};
    double *values = calloc((size_t)q->count, sizeof *values);
    if (!values) abort();
    need(hdr_bilateral_exact_at(&q->filter, choice->reach, q->plane, q->count, q->pixel, values, pool, &error), &error);
    measure(q, values, &answer);
    free(values);
    return answer;
}

/* The best sum for a tolerance, or the best way of any kind. */
static answer ask_choice(const question *q, bool only_direct, double cells) {
    static const double tolerances[] = {1e-3, 1e-2, 1e-4, 0.1};
    double tolerance = tolerances[q->scene->seed % 4];
    hdr_bilateral_choice choice = hdr_bilateral_choose(&q->filter, q->plane, tolerance, false, only_direct);
    CHECK(!(choice.grid && only_direct), "a grid is chosen where only sums may be");
    CHECK(choice.bound <= tolerance, "seed %" PRIu64 ": what is chosen for %g is within %g", q->scene->seed, tolerance,
          choice.bound);
    if (!choice.grid) return ask_sum(q, &choice);
    return ask_grid(q, choice.across, choice.deep, choice.bound / q->filter.sigma_r, cells);
}

static answer ask_way(const question *q, int way, double cells) {
    if (way >= GRIDS) return ask_choice(q, way == DIRECT, cells);
    const double *size = grid_sizes[way];
    double bound =
        hdr_grid_bound(&q->filter, (double)q->plane->width * q->plane->height, size[0], size[1]) / q->filter.sigma_r;
    return ask_grid(q, size[0], size[1], bound, cells);
}

/* ---- The worst ---- */

typedef struct record {
    bool any;
    scene scene;
    answer answer;
    unsigned long asked, exceeded;
} record;

static record worst[WAYS][SCENES];

static void keep(record *r, const scene *s, const answer *a) {
    if (!a->given) return;
    bool worse = !(a->error <= a->bound);
    r->asked++;
    r->exceeded += worse;
    if (r->any && a->error <= r->answer.error) return;
    *r = (record){true, *s, *a, r->asked, r->exceeded};
}

static void name_way(int way, char name[80]) {
    if (way < GRIDS)
        snprintf(name, 80, "grid %g x %g", grid_sizes[way][0], grid_sizes[way][1]);
    else
        snprintf(name, 80, "%s", way == DIRECT ? "sum, cut for a tolerance" : "what a tolerance leads to");
}

static void print_scene(const scene *s) {
    printf("{%d, %d, %d, %.5g, %.5g, %.5g, {%.5g, %.5g, %.5g, %.5g}, %" PRIu64 "}", (int)s->kind, s->width, s->height,
           s->sigma_s, s->sigma_r, s->range, s->turn[0], s->turn[1], s->turn[2], s->turn[3], s->seed);
}

static void print_worst(void) {
    printf("worst errors in units of sigma_r; how often the bound was exceeded, of how many scenes; the worst scene\n");
    for (int way = 0; way < WAYS; way++) {
        char name[80];
        name_way(way, name);
        printf("%s:\n", name);
        for (int k = 0; k < SCENES; k++) {
            const record *r = &worst[way][k];
            if (!r->any) continue;
            printf("  %-9s %-9.3g %lu/%lu at (%d,%d) of ", scene_names[k], r->answer.error, r->exceeded, r->asked,
                   r->answer.where.x, r->answer.where.y);
            print_scene(&r->scene);
            printf("\n");
        }
    }
}

/* ---- The test ---- */

/* What searches have found, for one grid or another. */
static const scene hard_scenes[] = {
    {SCENE_FIREFLIES, 239, 144, 35.156, 1, 1.1245, {0.03847, 0.8269, 0.74935, 0.32131}, 497348},
    {SCENE_FIREFLIES, 1225, 664, 327.29, 0.58974, 4.5039, {0.20763, 0.96571, 0.99067, 0.24856}, 68886},
    {SCENE_HALFWAY, 400, 242, 31.619, 0.17992, 1.2678, {0.64438, 0.63844, 0.85842, 0.00086}, 257563},
    {SCENE_HALFWAY, 1656, 895, 460.54, 0.17234, 4.3496, {0.78896, 0.00054261, 0.24252, 0.97582}, 501116},
    {SCENE_CROWD, 2000, 1000, 516.87, 0.2585, 5, {0.45496, 0.88283, 0.0036246, 0.98056}, 419769},
    {SCENE_CROWD, 385, 385, 77, 0.3, 5, {0.278, 0.9, 0, 1}, 109},
    {SCENE_CROWD, 770, 770, 154, 0.3, 5, {0.416, 0.9, 0, 1}, 113},
    {SCENE_CROWD, 2000, 1000, 520.63, 0.33641, 5, {0.42258, 0.90123, 0.031481, 0.99939}, 47769},
    {SCENE_CROWD, 2000, 1000, 543.44, 0.70318, 5, {0.44936, 0.81204, 0.12096, 0.98487}, 65755},
    {SCENE_CROWD, 2000, 1000, 480.16, 0.24767, 5, {0.42753, 0.88553, 0.012641, 1}, 873899},
    {SCENE_ISLAND, 490, 284, 157.41, 0.21341, 7.1245, {0.80328, 0.009, 0.59005, 0.99839}, 129885},
    {SCENE_ISLAND, 785, 738, 82.708, 0.21711, 6.4661, {0.37824, 0.81447, 0.76795, 0.29244}, 692868},
    {SCENE_TUG, 240, 120, 30, 0.3, 5, {0.51678, 0.08348, 0.18364, 0.61209}, 107035},
    {SCENE_TUG, 1600, 800, 190.1, 0.33165, 5, {0.19907, 0.79621, 0.59816, 0.29876}, 409949},
    {SCENE_TUG, 616, 308, 77, 0.3, 5, {0.54399, 0.29865, 0.11813, 0.74079}, 927335},
    {SCENE_TUG, 1600, 800, 200, 0.3, 5, {0.492, 0.61399, 0.72072, 0}, 987609},
    {SCENE_TUG, 1600, 800, 200, 0.3, 5, {0.13556, 0.80269, 0.63652, 0.26247}, 87615},
    {SCENE_TUG, 1600, 800, 200, 0.3, 5, {0.71533, 0, 0.66197, 0.98187}, 118166},
    /* ranges that are no larger than sigma_r, and cells that are much finer one way than the other */
    {SCENE_FLAT, 154, 8, 0.66662, 1, 1.2178, {0.070522, 0.69022, 0.89772, 0.93901}, 507938},
    {SCENE_FLAT, 12, 8, 0.66709, 0.88847, 1.1715, {0.99314, 0.21734, 0.36922, 0.42013}, 27754},
    {SCENE_NOISE, 26, 16, 2.3345, 1, 1.0093, {0.66307, 0.61759, 0.62967, 0.0053524}, 527200},
    {SCENE_MARGINS, 4, 2, 1.2021, 11.271, 9.0535, {0.32999, 0.5654, 0.07053, 0.85258}, 247206},
    {SCENE_FLAT, 345, 223, 98.47, 0.68423, 3.1998, {0.67899, 0.86575, 0.55504, 0.18007}, 121661},
};
enum { HARD_SCENES = sizeof hard_scenes / sizeof *hard_scenes };

static void check_scene(const scene *s) {
    question q = ask(s, TAPS);
    for (int way = 0; way < WAYS; way++) {
        answer a = ask_way(&q, way, CELLS);
        char name[80];
        name_way(way, name);
        CHECK(a.error <= a.bound, "%s, seed %" PRIu64 ", %dx%d: %s: off by %.3g sigma_r at (%d,%d), bound %.3g",
              scene_names[s->kind], s->seed, s->width, s->height, name, a.error, a.where.x, a.where.y, a.bound);
        keep(&worst[way][s->kind], s, &a);
    }
    forget(&q);
}

/* ---- The search ---- */

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double nudge(double value, double by, double low, double high, uint64_t *state) {
    double gauss = scene_unit(state) + scene_unit(state) + scene_unit(state) - 1.5;
    return scene_round(fmin(fmax(value + by * gauss, low), high));
}

static scene perturbed(const scene *s, uint64_t *state) {
    scene t = *s;
    double by = scene_log(state, 0.003, 0.5);
    for (int i = 0; i < SCENE_TURNS; i++)
        t.turn[i] = nudge(t.turn[i], by, 0, 1, state);
    int larger = t.width > t.height ? t.width : t.height;
    t.sigma_s = nudge(t.sigma_s, by * t.sigma_s, 0.5, fmax(0.5, 0.5 * larger), state);
    t.sigma_r = nudge(t.sigma_r, by * fmax(1, t.sigma_r), 0.1, 15, state);
    t.range = nudge(t.range, 5 * by, 0.5, 12, state);
    if (scene_bits(state) % 4 == 0) t.seed = scene_bits(state) % 1000000;
    return t;
}

static void search(double duration, uint64_t state) {
    double end = seconds() + duration;
    for (int n = 0; n < HARD_SCENES; n++)
        check_scene(&hard_scenes[n]);
    while (seconds() < end) {
        int way = (int)(scene_bits(&state) % GRIDS), kind = (int)(scene_bits(&state) % SCENES);
        record *r = &worst[way][kind];
        bool restart = !r->any || scene_bits(&state) % 4 == 0, big = scene_bits(&state) % 2 == 0;
        scene s = restart ? scene_random((scene_kind)kind, scene_bits(&state) % 1000000, big ? 2e6 : 4e4)
                          : perturbed(&r->scene, &state);
        question q = ask(&s, TAPS / 2);
        answer a = ask_way(&q, way, CELLS);
        keep(r, &s, &a);
        forget(&q);
    }
}

static scene scene_of_words(char **words) {
    scene s = {
        .kind = (scene_kind)(strtoul(words[0], NULL, 10) % SCENES), .width = atoi(words[1]), .height = atoi(words[2])};
    s.sigma_s = strtod(words[3], NULL);
    s.sigma_r = strtod(words[4], NULL);
    s.range = strtod(words[5], NULL);
    for (int i = 0; i < SCENE_TURNS; i++)
        s.turn[i] = strtod(words[6 + i], NULL);
    s.seed = strtoull(words[6 + SCENE_TURNS], NULL, 10);
    return s;
}

int main(int count, char **words) {
    hdr_error error = {0};
    pool = hdr_pool_new(2, &error);
    if (!pool) abort();
    if (count == 4 && !strcmp(words[1], "search")) {
        search(strtod(words[2], NULL), strtoull(words[3], NULL, 10));
    } else if (count == 9 + SCENE_TURNS && !strcmp(words[1], "scene")) {
        scene s = scene_of_words(words + 2);
        check_scene(&s);
    } else {
        for (int n = 0; n < SCENE_COUNT; n++) {
            scene s = scene_random((scene_kind)(n % SCENES), (uint64_t)n, n % 4 ? 2e5 : 2e6);
            check_scene(&s);
        }
        for (int n = 0; n < HARD_SCENES; n++)
            check_scene(&hard_scenes[n]);
    }
    print_worst();
    hdr_pool_free(pool);
    return check_done("test_durand_bounds");
}
