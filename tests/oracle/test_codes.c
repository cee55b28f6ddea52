/* Every code of every PNG, every float of every EXR and PFM, and every fact, against an evaluation of SPEC's formulas
 * that shares nothing with src/: chains x pictures (testdata, pictures made in memory, and the corpus where there is
 * one).
 *
 * Of pictures above 40,000 pixels every 7th pixel is compared, and above 100,000 every picture goes through every 10th
 * chain; HDRPIPE_ORACLE=all compares everything (7 minutes). HDRPIPE_ORACLE_CHAIN=TEXT takes that chain alone. */
#include "check.h"
#include "oracle_check.h"
#include "oracle_run.h"
#include "oracle_scenes.h"

#include <glob.h>
#include <unistd.h>

static const char *const chains[] = {
    "png",
    "png --bits 16",
    "divmax then png",
    "divmax --of luminance then png --bits 16",
    "divmax --percentile 99.9 then png --bits 16",
    "divmax --percentile 0 then png",
    "divmax --of luminance --percentile 50 then png",
    "clamp then png --bits 16",
    "clamp --min 0.1 --max 0.5 then png --bits 16",
    "clamp --min -2 --max 3 then quantise --bits 16 then png",
    "expose --ev -1.5 then png",
    "expose --ev 3 then quantise --bits 8 then png",
    "expose --auto then png --bits 16",
    "log then png",
    "log then png --bits 16",
    "log --k 3 then png --bits 16",
    "log --k 1e-6 then png",
    "log --mode range then png",
    "log --mode range then quantise --bits 16 then png",
    "log --mode range --percentile 1 then png --bits 16",
    "log --mode range --percentile 0 then png",
    "log --mode range --percentile 50 then png",
    "log --mode range --per-channel then png",
    "log --mode literal then png",
    "log --mode literal then clamp --min -3 --max 3 then divmax then png --bits 16",
    "log --per-channel then png --bits 16",
    "log --saturation 0.6 then png --bits 16",
    "log --saturation 0 then png",
    "log --mode range --saturation 1.7 then png --bits 16",
    "exp then png",
    "exp then png --bits 16",
    "exp --k 3 then png --bits 16",
    "exp --per-channel then png --bits 16",
    "exp --saturation 0.6 then png",
    "reinhard then png",
    "reinhard then png --bits 16",
    "reinhard --white inf then png",
    "reinhard --white inf then png --bits 16",
    "reinhard --white 2.5 then png --bits 16",
    "reinhard --key 0.72 --white auto then png --bits 16",
    "reinhard --key 0.045 --white 0.3 then png",
    "reinhard --key estimate then png",
    "reinhard --key estimate then png --bits 16",
    "reinhard --key estimate --white auto then png --bits 16",
    "reinhard --key estimate --white 7 then quantise --bits 16 then png",
    "reinhard --delta 0.01 then png --bits 16",
    "reinhard --delta 1e-6 --key estimate then png",
    "reinhard --per-channel then png --bits 16",
    "reinhard --per-channel --white inf then png",
    "reinhard --per-channel --key estimate then png",
    "reinhard --saturation 0.6 then png --bits 16",
    "reinhard --saturation 0 --white 3 then png",
    "reinhard --saturation 1.7 then png",
    "expose --ev -2 then reinhard --white 1.5 then quantise --bits 16 then png",
    "exp then reinhard --key estimate then png --bits 16",
    "gamma then png",
    "gamma --exponent 1.8 then png --bits 16",
    "gamma -g 1 then png --bits 16",
    "gamma -g 0.45 then png",
    "gamma --decode then png",
    "gamma --decode then quantise --bits 16 then png",
    "srgb then png",
    "srgb then png --bits 16",
    "srgb --decode then png",
    "srgb --decode then quantise --bits 16 then png",
    "rec709 then png",
    "rec709 then png --bits 16",
    "rec709 --decode then png --bits 16",
    "pq then png",
    "pq --nits 1.5 then png --bits 16",
    "pq --decode --nits 203 then png --bits 16",
    "pq --decode then quantise --bits 16 then png",
    "hlg then png",
    "hlg then png --bits 16",
    "hlg --decode then quantise --bits 16 then png",
    "expose --auto then rec709 then quantise --bits 10 then png",
    "expose --auto then pq --nits 40 --primaries keep then quantise --bits 12 then png",
    "divmax then hlg --primaries keep then png",
    "quantise then png",
    "quantise --bits 1 then png",
    "srgb then quantise --bits 1 then png",
    "srgb then quantise --bits 5 then png",
    "srgb then quantise --bits 6 then png --bits 16",
    "srgb then quantise --bits 8 then png",
    "gamma then quantise --bits 10 then png",
    "quantise --bits 16 then png",
    "quantise --bits 5 then srgb then png",
    "srgb then quantise --bits 4 then srgb --decode then exp then png",
    "expose --auto then log then srgb then quantise --bits 6 then png",
    "expose --auto then divmax --percentile 99 then clamp then png --bits 16",
    "clamp then gamma then png --bits 16",
    "exp then log then divmax --of luminance then gamma -g 1.8 then quantise --bits 12 then png",
    "log --k 2 then expose --ev 0.5 then log --mode range then png --bits 16",
    "gamma --decode -g 1.8 then gamma then png",
    "log then png --window data",
    "log then png --primaries keep",
    "gamma --adapt none then png --bits 16",
    /* floats */
    "exr",
    "exr --window data",
    "exr --type half",
    "expose --ev 1.25 then exr",
    "log then exr",
    "log --mode literal then exr",
    "log --mode literal then exr --type half",
    "log --mode range then exr --type half",
    "exp --saturation 0.6 then exr",
    "reinhard then exr",
    "reinhard --key estimate --per-channel then pfm",
    "reinhard --white inf then exr --type half",
    "srgb then exr",
    "gamma then exr --type half",
    "gamma --decode then exr",
    "gamma -g 0.05 then exr",
    "srgb --decode then pfm",
    "rec709 then exr",
    "rec709 --decode then pfm",
    "pq then exr --type half",
    "pq --nits 1000 then exr",
    "pq --decode then pfm",
    "hlg then pfm",
    "hlg --decode then exr",
    "quantise --bits 3 then pfm",
    "pfm",
    "divmax then pfm",
    "expose --auto then srgb then pfm",
    /* facts */
    "",
    "expose --ev 2",
    "log",
    "divmax --percentile 75",
    "exp then srgb",
    "reinhard",
};

enum {
    CHAINS = sizeof chains / sizeof chains[0],
    SAMPLED_ABOVE = 40000,
    SAMPLED_EVERY = 7,
    FEW_CHAINS_ABOVE = 100000,
    CHAIN_EVERY = 10
};

static bool everything;
static unsigned long codes_compared, codes_excused;

/* Runs the library on a chain that ends in facts. */
static bool take_stats(const char *text, hdr_input *input, hdr_stats *stats, hdr_error *error) {
    hdr_chain *chain = oracle_library_chain(text[0] ? text : "stats", error);
    bool done = chain && input && hdr_chain_stats(chain, input, stats, NULL, error) == HDR_OK;
    hdr_chain_free(chain);
    hdr_input_free(input);
    return done;
}

static void compare(const oracle_chain *chain, const char *text, const file_bytes *file, oracle_verdict *verdict) {
    hdr_error error = {0};
    hdr_stats stats;
    size_t size = 0;
    int every = !everything && chain->picture->pixels > SAMPLED_ABOVE ? SAMPLED_EVERY : 1;
    hdr_input *input = hdr_input_memory(file->data, file->size, "picture", &error);
    if (chain->format == ORACLE_NO_FORMAT) {
        if (oracle_agree(verdict, take_stats(text, input, &stats, &error), "%s", error.message))
            oracle_compare_stats(chain, &stats, verdict);
        return;
    }
    hdr_output *output = oracle_run(text, input, &error);
    const void *bytes = output ? hdr_output_bytes(output, &size) : NULL;
    if (!oracle_agree(verdict, output != NULL, "%s", error.message)) return;
    if (chain->format == ORACLE_PNG)
        oracle_compare_png(chain, bytes, size, every, verdict);
    else if (chain->format == ORACLE_EXR)
        oracle_compare_exr(chain, bytes, size, every, verdict);
    else
        oracle_compare_pfm(chain, bytes, size, every, verdict);
    hdr_output_free(output);
}

static void check_chain(const char *name, const file_bytes *file, const oracle_picture *picture, const char *text) {
    oracle_chain chain;
    oracle_verdict verdict = {0};
    if (!oracle_prepare(&chain, picture, text)) {
        CHECK(false, "the oracle does not know the chain: %s", text);
        return;
    }
    compare(&chain, text, file, &verdict);
    CHECK(!verdict.wrong, "%s: %s: %s", name, text, verdict.why);
    oracle_release(&chain);
    codes_compared += verdict.compared;
    codes_excused += verdict.excused;
}

/* number: makes other big pictures go through other chains. */
static void check_picture(const char *name, file_bytes *file, int number) {
    oracle_picture picture;
    const char *only = getenv("HDRPIPE_ORACLE_CHAIN");
    bool readable = oracle_read(file, &picture);
    CHECK(readable, "%s: OpenEXRCore does not read it", name);
    if (readable && only) check_chain(name, file, &picture, only);
    for (int c = 0; readable && !only && c < CHAINS; c++)
        if (everything || picture.pixels <= FEW_CHAINS_ABOVE || (c + number) % CHAIN_EVERY == 0)
            check_chain(name, file, &picture, chains[c]);
    oracle_picture_free(&picture);
}

static void check_file(const char *path, int number) {
    file_bytes file;
    bool loaded = oracle_load(path, &file);
    CHECK(loaded, "%s: cannot be read", path);
    if (loaded) check_picture(path, &file, number);
    free(file.data);
}

/* All files of a pattern; returns how many there are. */
static int check_files(const char *pattern) {
    glob_t found;
    int count = 0;
    if (!glob(pattern, 0, NULL, &found)) {
        count = (int)found.gl_pathc;
        for (int i = 0; i < count; i++)
            check_file(found.gl_pathv[i], i);
    }
    globfree(&found);
    return count;
}

static void check_corpus(void) {
    static const char *const folders[] = {"photo", "render", "windows", "torture"};
    const char *corpus = getenv("HDRPIPE_CORPUS");
    if (!corpus) corpus = "../shared/corpus";
    if (access(corpus, R_OK)) {
        CHECK_SKIP("no corpus at %s", corpus);
        return;
    }
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
        char pattern[1000];
        snprintf(pattern, sizeof pattern, "%s/%s/*.exr", corpus, folders[i]);
        CHECK(check_files(pattern) > 0, "%s: no pictures", pattern);
    }
}

int main(void) {
    const char *depth = getenv("HDRPIPE_ORACLE");
    everything = depth && !strcmp(depth, "all");
    CHECK(check_files("testdata/tiny/*.exr") == 12, "testdata/tiny does not hold 12 pictures");
    for (size_t i = 0; i < sizeof oracle_scenes / sizeof oracle_scenes[0]; i++) {
        file_bytes file;
        bool made = scene_make(&oracle_scenes[i], &file);
        CHECK(made, "%s: cannot be made", oracle_scenes[i].name);
        if (made) check_picture(oracle_scenes[i].name, &file, (int)i);
        free(file.data);
    }
    check_file("testdata/interior_float.exr", 0);
    check_file("testdata/glossy.exr", 0);
    check_file("testdata/object.exr", 0);
    check_corpus();
    if (!getenv("HDRPIPE_ORACLE_CHAIN")) {
        CHECK(codes_compared > 1000000, "only %lu values were compared", codes_compared);
        /* the most are pixels of exactly 0.5 in chains whose real formula is the identity */
        CHECK(codes_excused * 200 <= codes_compared, "%lu of %lu are excused: too many", codes_excused, codes_compared);
    }
    fprintf(stderr, "%lu values compared, %lu excused\n", codes_compared, codes_excused);
    return check_done("test_codes");
}
