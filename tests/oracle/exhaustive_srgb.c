/* Every float in [0,1], about 2^30 of them, through an encoding to codes, against thresholds found by bisecting the
 * floats with MPFR: the encoding is monotone, so that the least float of each code tells the codes of all. Two ways:
 * quantise to PFM, and PNG in three planes, whose orders are ascending, descending and mixed.
 *
 * Usage: exhaustive_srgb [--bits 8|16] [--curve 'gamma -g 2.2'] [--from BLOCK] [--to BLOCK]
 *
 * A block is 2^22 floats; there are 254. Progress, on stderr, tells from which block to go on after an interruption. */
#include "check.h"
#include "oracle_check.h"
#include "oracle_run.h"

#include <pthread.h>
#include <unistd.h>

enum { SIDE = 2048, BLOCK = SIDE * SIDE, MIXER = 40503 * 3 };

static const uint32_t bits_of_1 = 0x3f800000;

static struct {
    int bits;
    const char *curve;
    long first, last;             /* blocks */
    uint32_t least[65536 + 1];    /* bits of the least float of each code */
    uint32_t doubtful[2 * 65536]; /* bits of floats as good as on a boundary: either code will do */
    int doubtful_count;
    pthread_mutex_t lock;
    long next;
} job = {.bits = 8, .curve = "srgb", .lock = PTHREAD_MUTEX_INITIALIZER};

static float float_of_bits(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* ---- Thresholds ---- */

typedef struct one_pixel {
    float value;
    oracle_picture picture;
    oracle_chain chain;
} one_pixel;

static long exact_code_of(one_pixel *pixel, uint32_t bits, bool *excused) {
    pixel->value = float_of_bits(bits);
    oracle_codes codes = oracle_exact_codes(&pixel->chain, 0);
    *excused = codes.excused[0];
    return codes.code[0];
}

static void note_doubt(one_pixel *pixel, uint32_t bits) {
    bool excused;
    exact_code_of(pixel, bits, &excused);
    if (excused) job.doubtful[job.doubtful_count++] = bits;
}

static bool find_thresholds(void) {
    static one_pixel pixel;
    char text[ORACLE_LINE];
    pixel.picture = (oracle_picture){.width = 1,
                                     .height = 1,
                                     .pixels = 1,
                                     .planes = 1,
                                     .plane = {&pixel.value},
                                     .grey = true,
                                     .opaque = true,
                                     .primaries = oracle_rec709};
    snprintf(text, sizeof text, "%s then png --bits %d", job.curve, job.bits);
    if (!oracle_prepare(&pixel.chain, &pixel.picture, text)) return false;
    long codes = 1L << job.bits;
    for (long code = 1; code < codes; code++) {
        uint32_t below = job.least[code - 1], above = bits_of_1;
        while (above - below > 1) {
            uint32_t middle = below + (above - below) / 2;
            bool excused;
            *(exact_code_of(&pixel, middle, &excused) >= code ? &above : &below) = middle;
        }
        job.least[code] = above;
        note_doubt(&pixel, above);
        note_doubt(&pixel, above - 1);
    }
    job.least[codes] = UINT32_MAX;
    return true;
}

/* ---- Blocks ---- */

typedef struct worker {
    float *plane[3];
    uint16_t *expected; /* codes of the block's floats, ascending */
    unsigned long passed, failed;
    char why[700]; /* the first thing that is wrong */
} worker;

static void expect_block(worker *w, uint32_t first) {
    long code = 0;
    for (uint32_t i = 0; i < BLOCK; i++) {
        while (first + i >= job.least[code + 1])
            code++;
        w->expected[i] = (uint16_t)code;
    }
}

/* Which float of the block a plane has at a pixel. */
static uint32_t float_at(int plane, uint32_t pixel) {
    return plane == 0 ? pixel : plane == 1 ? BLOCK - 1 - pixel : (uint32_t)((uint64_t)pixel * MIXER % BLOCK);
}

static bool is_doubtful(uint32_t bits) {
    for (int i = 0; i < job.doubtful_count; i++)
        if (job.doubtful[i] == bits) return true;
    return false;
}

static void judge(worker *w, const char *way, uint32_t bits, long code, long right) {
    if (code == right || (labs(code - right) == 1 && is_doubtful(bits))) {
        w->passed++;
        return;
    }
    if (!w->failed++)
        snprintf(w->why, sizeof w->why, "%s: %a (bits 0x%08x) gives %ld, should be %ld", way,
                 (double)float_of_bits(bits), bits, code, right);
}

static void fail(worker *w, const char *way, const hdr_error *error) {
    if (!w->failed++) snprintf(w->why, sizeof w->why, "%s: %.250s", way, error->status ? error->message : "malformed");
}

static void check_pfm(worker *w, uint32_t first) {
    char text[ORACLE_LINE];
    hdr_error error = {0};
    size_t size = 0;
    int width = 0, height = 0, colours = 0;
    const float *const planes[3] = {w->plane[0], NULL, NULL};
    snprintf(text, sizeof text, "%s then quantise --bits %d then pfm -j 1", job.curve, job.bits);
    hdr_output *output = oracle_run(text, hdr_input_planes(SIDE, SIDE, 1, planes, NULL, &error), &error);
    const void *bytes = output ? hdr_output_bytes(output, &size) : NULL;
    float *pixels = output ? oracle_read_pfm(bytes, size, &width, &height, &colours) : NULL;
    if (!pixels || width != SIDE || height != SIDE || colours != 1)
        fail(w, text, &error);
    else
        for (uint32_t i = 0; i < BLOCK; i++) {
            double largest = (double)((1L << job.bits) - 1), code = rint(pixels[i] * largest);
            /* v' = code / (2^b - 1), as a float */
            bool whole = fabs(pixels[i] - code / largest) <= 0x1p-23 * pixels[i];
            judge(w, "quantise", first + i, whole ? (long)code : -1, w->expected[i]);
        }
    free(pixels);
    hdr_output_free(output);
}

static void check_png(worker *w, uint32_t first) {
    char text[ORACLE_LINE];
    hdr_error error = {0};
    size_t size = 0;
    oracle_png png = {0};
    const float *const planes[3] = {w->plane[0], w->plane[1], w->plane[2]};
    snprintf(text, sizeof text, "%s then png --bits %d -j 1", job.curve, job.bits);
    hdr_output *output = oracle_run(text, hdr_input_planes(SIDE, SIDE, 3, planes, NULL, &error), &error);
    const void *bytes = output ? hdr_output_bytes(output, &size) : NULL;
    if (!output || !oracle_read_png(bytes, size, &png) || png.width != SIDE || png.height != SIDE || png.colours != 3)
        fail(w, text, &error);
    else
        for (uint32_t i = 0; i < BLOCK; i++)
            for (int p = 0; p < 3; p++) {
                uint32_t at = float_at(p, i);
                judge(w, "png", first + at, png.samples[3 * i + (unsigned)p], w->expected[at]);
            }
    free(png.samples);
    hdr_output_free(output);
}

static void check_block(worker *w, long block) {
    uint32_t first = (uint32_t)block * BLOCK;
    expect_block(w, first);
    for (int p = 0; p < 3; p++)
        for (uint32_t i = 0; i < BLOCK; i++)
            w->plane[p][i] = float_of_bits(first + float_at(p, i));
    check_pfm(w, first);
    check_png(w, first);
}

/* ---- Workers ---- */

static bool take_block(long *block) {
    pthread_mutex_lock(&job.lock);
    *block = job.next;
    bool taken = job.next <= job.last;
    if (taken) job.next++;
    pthread_mutex_unlock(&job.lock);
    return taken;
}

static void report(const worker *w, long block) {
    pthread_mutex_lock(&job.lock);
    check_passed += w->passed;
    check_failed += w->failed;
    if (w->failed) fprintf(stderr, "block %ld: %lu wrong: %s\n", block, w->failed, w->why);
    if (block % 16 == 0) fprintf(stderr, "block %ld of %ld to %ld done\n", block, job.first, job.last);
    pthread_mutex_unlock(&job.lock);
}

static void *work(void *nothing) {
    worker w = {.expected = oracle_alloc(BLOCK, sizeof *w.expected)};
    for (int p = 0; p < 3; p++)
        w.plane[p] = oracle_alloc(BLOCK, sizeof *w.plane[p]);
    for (long block; take_block(&block);) {
        w.passed = w.failed = 0;
        check_block(&w, block);
        report(&w, block);
    }
    for (int p = 0; p < 3; p++)
        free(w.plane[p]);
    free(w.expected);
    return nothing;
}

static bool parse_arguments(int count, char **words) {
    job.last = bits_of_1 / BLOCK; /* this block begins with 1 and goes on beyond it */
    for (int i = 1; i < count; i += 2) {
        if (i + 1 == count) return false;
        if (!strcmp(words[i], "--bits"))
            job.bits = atoi(words[i + 1]);
        else if (!strcmp(words[i], "--curve"))
            job.curve = words[i + 1];
        else if (!strcmp(words[i], "--from"))
            job.first = atol(words[i + 1]);
        else if (!strcmp(words[i], "--to"))
            job.last = atol(words[i + 1]);
        else
            return false;
    }
    job.next = job.first;
    return (job.bits == 8 || job.bits == 16) && job.first >= 0 && job.last <= bits_of_1 / BLOCK;
}

int main(int count, char **words) {
    if (!parse_arguments(count, words) || !find_thresholds()) {
        fprintf(stderr, "usage: exhaustive_srgb [--bits 8|16] [--curve CLAUSE] [--from BLOCK] [--to BLOCK]\n");
        return 64;
    }
    pthread_t threads[64];
    long cores = sysconf(_SC_NPROCESSORS_ONLN), workers = 0;
    while (workers < cores && workers < 64 && !pthread_create(&threads[workers], NULL, work, NULL))
        workers++;
    for (long i = 0; i < workers; i++)
        pthread_join(threads[i], NULL);
    fprintf(stderr, "%d floats as good as on a boundary\n", job.doubtful_count);
    CHECK(workers > 0, "no thread can be started");
    return check_done("exhaustive_srgb");
}
