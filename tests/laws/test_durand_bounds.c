/* The bounds that are stated for the ways to compute a bilateral filter, against the exact sum: two hundred scenes made
 * at random, and those that a search found to be the worst.
 *
 *     test_durand_bounds                      the test
 *     test_durand_bounds search SECONDS SEED  looks for worse scenes, and prints the worst as they would stand below */
#include "check.h"
#include "durand_scenes.h"

#include "spatial/ranks.h"

#include <inttypes.h>
#include <string.h>
#include <time.h>

static const double grid_sizes[][2] = {{2, 2}, {2, 4}, {3, 4}, {4, 6}};
enum {
    GRIDS = sizeof grid_sizes / sizeof *grid_sizes,
    DIRECT = GRIDS, /* the sum that is cut */
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

static double cells_of(const question *q, int grid) {
    double across = q->filter.sigma_s / grid_sizes[grid][0], deep = q->filter.sigma_r / grid_sizes[grid][1];
    return (q->plane->width / across + 4) * (q->plane->height / across + 4) *
           ((q->filter.high - q->filter.low) / deep + 4);
}

static answer ask_grid(const question *q, int grid, double cells) {
    answer answer = {.bound = hdr_grid_bound(grid_sizes[grid][0], grid_sizes[grid][1])};
    if (cells_of(q, grid) > cells) return answer;
    hdr_error error = {0};
    hdr_plane *base = hdr_plane_new(q->plane->width, q->plane->height, false, &error);
    double *values = calloc((size_t)q->count, sizeof *values);
    hdr_bilateral_report report;
    if (!base || !values) abort();
    for (int y = 0; y < base->height; y++)
        memcpy(base->narrow + (size_t)y * base->stride, q->plane->narrow + (size_t)y * q->plane->stride,
               (size_t)base->width * sizeof(float));
    need(hdr_bilateral_grid(&q->filter, grid_sizes[grid][0], grid_sizes[grid][1], base, pool, &report, &error), &error);
    for (int i = 0; i < q->count; i++)
        values[i] = number_at(base, q->pixel[i].x, q->pixel[i].y);
    measure(q, values, &answer);
    hdr_plane_free(base);
    free(values);
    return answer;
}

/* The sum, cut as the choice for a tolerance has it. */
static answer ask_direct(const question *q, double tolerance) {
    hdr_error error = {0};
    hdr_bilateral_choice choice = hdr_bilateral_choose(&q->filter, q->plane, tolerance, false, true);
    answer answer = {.bound = choice.bound / q->filter.sigma_r};
    double *values = calloc((size_t)q->count, sizeof *values);
    if (!values) abort();
    CHECK(!choice.grid, "a grid is chosen where only sums may be");
    need(hdr_bilateral_exact_at(&q->filter, choice.reach, q->plane, q->count, q->pixel, values, pool, &error), &error);
    measure(q, values, &answer);
    free(values);
    return answer;
}

static answer ask_way(const question *q, int way, double cells) {
    static const double tolerances[] = {1e-2, 1e-3, 1e-5, 0.3};
    return way == DIRECT ? ask_direct(q, tolerances[q->scene->seed % 4]) : ask_grid(q, way, cells);
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

static void name_way(int way, char name[40]) {
    if (way == DIRECT)
        snprintf(name, 40, "sum, cut");
    else
        snprintf(name, 40, "grid %g x %g", grid_sizes[way][0], grid_sizes[way][1]);
}

static void print_scene(const scene *s) {
    printf("{SCENE_%s, %d, %d, %.6g, %.6g, %.6g, {%.6g, %.6g, %.6g, %.6g}, %" PRIu64 "}", scene_names[s->kind],
           s->width, s->height, s->sigma_s, s->sigma_r, s->range, s->turn[0], s->turn[1], s->turn[2], s->turn[3],
           s->seed);
}

static void print_worst(bool scenes) {
    printf("worst errors in units of sigma_r (times the bound was exceeded / scenes)\n");
    for (int way = 0; way < WAYS; way++) {
        char name[40];
        name_way(way, name);
        printf("%s, bound %g:\n", name, way == DIRECT ? NAN : hdr_grid_bound(grid_sizes[way][0], grid_sizes[way][1]));
        for (int k = 0; k < SCENES; k++) {
            const record *r = &worst[way][k];
            if (!r->any) continue;
            printf("  %-9s %.3g%s (%lu/%lu)", scene_names[k], r->answer.error,
                   r->answer.error <= r->answer.bound ? "" : " !", r->exceeded, r->asked);
            printf(" at (%d,%d) of ", r->answer.where.x, r->answer.where.y);
            if (scenes)
                print_scene(&r->scene);
            else
                printf("seed %" PRIu64 ", %dx%d, sigma_s %.3g, sigma_r %.3g", r->scene.seed, r->scene.width,
                       r->scene.height, r->scene.sigma_s, r->scene.sigma_r);
            printf("\n");
        }
    }
}

/* ---- The test ---- */

static void check_scene(const scene *s) {
    question q = ask(s, TAPS);
    for (int way = 0; way < WAYS; way++) {
        answer a = ask_way(&q, way, CELLS);
        char name[40];
        name_way(way, name);
        CHECK(a.error <= a.bound, "%s, seed %" PRIu64 ", %dx%d: %s is off by %.3g sigma_r at (%d,%d), bound %.3g",
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
    return fmin(fmax(value + by * gauss, low), high);
}

static scene perturbed(const scene *s, uint64_t *state) {
    scene t = *s;
    double by = scene_log(state, 0.003, 0.5);
    for (int i = 0; i < SCENE_TURNS; i++)
        t.turn[i] = nudge(t.turn[i], by, 0, 1, state);
    int larger = t.width > t.height ? t.width : t.height;
    t.sigma_s = fmax(0.5, fmin(0.5 * larger, t.sigma_s * exp(nudge(0, by, -1, 1, state))));
    t.sigma_r = nudge(t.sigma_r, by, 0.1, 1, state);
    t.range = nudge(t.range, 5 * by, 1, 12, state);
    if (scene_bits(state) % 4 == 0) t.seed = scene_bits(state) % 1000000;
    return t;
}

static void search(double duration, uint64_t seed) {
    double end = seconds() + duration;
    uint64_t state = seed;
    while (seconds() < end) {
        int way = (int)(scene_bits(&state) % GRIDS), kind = (int)(scene_bits(&state) % SCENES);
        record *r = &worst[way][kind];
        bool restart = !r->any || scene_bits(&state) % 4 == 0, big = scene_bits(&state) % 2 == 0;
        scene s = restart ? scene_random((scene_kind)kind, scene_bits(&state) % 1000000, big ? 2e6 : 4e4)
                          : perturbed(&r->scene, &state);
        question q = ask(&s, 2e7);
        answer a = ask_way(&q, way, 1.5e6);
        keep(r, &s, &a);
        forget(&q);
    }
    print_worst(true);
}

int main(int count, char **words) {
    hdr_error error = {0};
    pool = hdr_pool_new(2, &error);
    if (!pool) abort();
    if (count == 4 && !strcmp(words[1], "search")) {
        search(atof(words[2]), strtoull(words[3], NULL, 10));
        return 0;
    }
    for (int n = 0; n < SCENE_COUNT; n++) {
        scene s = scene_random((scene_kind)(n % SCENES), (uint64_t)n, n % 20 ? 3e4 : 2e6);
        check_scene(&s);
    }
    print_worst(false);
    hdr_pool_free(pool);
    return check_done("test_durand_bounds");
}
