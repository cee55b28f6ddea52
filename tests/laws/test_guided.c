/* The laws of SPEC.md for verbs that filter by a second picture: every one of the registry, with every sort of value
 * that its option table allows. The second picture is made for each first one: the same form, a part of each number's
 * size, and here and there 0 or no number at all. Nothing here knows a verb by name: the first option that is a text
 * names the second picture. */
#include "laws.h"

#include <unistd.h>

static char folder[] = "/tmp/hdr-laws-XXXXXX";
static char guide_file[64];

/* ---- The second picture ---- */

static float part_of(float value) {
    float size = fabsf(value);
    switch (law_random() % 16) {
    case 0:
    case 1:
        return 0;
    case 2:
        return NAN;
    case 3:
        return INFINITY;
    default:
        return isfinite(size) ? size * (float)law_random_log(1e-3, 2) : size;
    }
}

static law_picture make_guide(const law_picture *picture) {
    law_picture guide = law_new_picture("guide", picture->width, picture->height, picture->planes, false);
    for (int c = 0; c < picture->planes; c++)
        for (size_t i = 0; i < law_pixels(picture); i++)
            guide.plane[c][i] = part_of(picture->plane[c][i]);
    return guide;
}

/* As PFM, whose rows begin with the last. */
static void write_guide(const law_picture *guide) {
    FILE *file = fopen(guide_file, "wb");
    if (!file) abort();
    fprintf(file, "%s\n%d %d\n-1\n", guide->planes == 3 ? "PF" : "Pf", guide->width, guide->height);
    for (size_t i = 0; i < law_pixels(guide); i++) {
        size_t width = (size_t)guide->width, row = (size_t)guide->height - 1 - i / width;
        for (int c = 0; c < guide->planes; c++)
            fwrite(&guide->plane[c][row * width + i % width], sizeof(float), 1, file);
    }
    if (fclose(file) != 0) abort();
}

/* ---- Variants ---- */

static void make_guided_variants(void) {
    const hdr_verb *verb;
    for (int v = 0; (verb = hdr_verb_number(v)) != NULL; v++) {
        if (verb->about.kind != HDR_GUIDED) continue;
        law_value list[MAX_VALUES], guide[1];
        const hdr_option *named = verb->about.options;
        int count = 0;
        while (named->type != HDR_OPTION_TEXT)
            named++;
        law_add_value(guide, 0, named, "%s", guide_file);
        for (const hdr_option *option = verb->about.options; option->name; option++)
            count = law_add_values(list, count, option);
        law_add_variant(verb, guide, NULL, NULL);
        for (int i = 0; i < count; i++)
            law_add_variant(verb, guide, &list[i], NULL);
    }
}

/* ---- Laws 2, 3, 4 and 6 ---- */

static void check_same(const law_picture *picture, const law_variant *variant, const char *format, const char *setting,
                       const law_result *expected) {
    law_result other = law_run(picture, "%s then %s %s", variant->words, format, setting);
    CHECK(law_same(expected, &other), "%s then %s %s on %s: other bytes (status %d, %d; %s)", variant->words, format,
          setting, picture->name, (int)expected->status, (int)other.status, other.message);
    free(other.bytes);
}

static void check_settings(const law_picture *picture, const law_variant *variant) {
    static const char *const settings[] = {"-j 2", "-j 5 --memory 1M", "-j 1 --no-skip"};
    static const char *const formats[] = {"png", "pfm", "log then png"};
    for (int f = 0; f < 3; f++) {
        law_result base = law_run(picture, "%s then %s -j 1", variant->words, formats[f]);
        CHECK(base.status == HDR_OK, "%s on %s: %s", variant->words, picture->name, base.message);
        for (int s = 0; s < 3 && base.status == HDR_OK; s++)
            check_same(picture, variant, formats[f], settings[s], &base);
        size_t count = 0, bad = 0;
        float *values = f == 1 ? law_read_pfm(&base, &count) : NULL;
        for (size_t i = 0; i < count; i++)
            bad += !isfinite(values[i]);
        CHECK(f != 1 || (values && bad == 0), "law 6: %s on %s: %zu floats", variant->words, picture->name, bad);
        free(values);
        free(base.bytes);
    }
}

/* Of pictures within float's usual range: at its ends the largest difference of a window is all that there is. */
static void check_reference(const law_picture *picture, const law_variant *variant) {
    law_result fast = law_run(picture, "%s then log then png -j 2", variant->words);
    law_result exact = law_run(picture, "%s then log then png -j 2 --reference", variant->words);
    int farthest = law_code_distance(&fast, &exact);
    CHECK(farthest <= 1, "law 4: %s on %s: %d codes from the reference", variant->words, picture->name, farthest);
    free(fast.bytes);
    free(exact.bytes);
}

/* ---- Law 5, to the bit: pictures and deviations of another unit ---- */

static void scale(law_picture *picture, int stops) {
    for (int c = 0; c < picture->planes; c++)
        for (size_t i = 0; i < law_pixels(picture); i++)
            picture->plane[c][i] = ldexpf(picture->plane[c][i], stops);
}

static void check_unit(law_picture *picture, law_picture *guide, const law_variant *variant) {
    const int stops[] = {-20, 20};
    law_result base = law_run(picture, "%s then pfm -j 2", variant->words);
    size_t count = 0, scaled_count = 0, different = 0;
    float *values = law_read_pfm(&base, &count);
    for (int s = 0; s < 2; s++) {
        scale(picture, stops[s]);
        scale(guide, stops[s]);
        write_guide(guide);
        law_result other = law_run(picture, "%s then pfm -j 2", variant->words);
        float *scaled = law_read_pfm(&other, &scaled_count);
        for (size_t i = 0; values && scaled && count == scaled_count && i < count; i++)
            different += ldexpf(values[i], stops[s]) != scaled[i];
        CHECK(values && scaled && count == scaled_count && different == 0, "%s on %s times 2^%d: %zu other floats",
              variant->words, picture->name, stops[s], different);
        free(scaled);
        free(other.bytes);
        scale(picture, -stops[s]);
        scale(guide, -stops[s]);
    }
    write_guide(guide);
    free(values);
    free(base.bytes);
}

/* ---- In front of what ---- */

/* Behind a filter it is refused; in front of any it is what a file of its result is. */
static void check_place(const law_picture *picture, const law_variant *variant) {
    for (int v = 0; hdr_verb_number(v); v++) {
        const hdr_verb_about *about = &hdr_verb_number(v)->about;
        if (about->kind != HDR_FILTER) continue;
        law_result behind = law_run(picture, "%s then %s then png", about->name, variant->words);
        CHECK(behind.status == HDR_USAGE, "%s behind %s: status %d", variant->words, about->name, (int)behind.status);
        law_result once = law_run(picture, "%s then %s then pfm", variant->words, about->name);
        law_result first = law_run(picture, "%s then exr", variant->words);
        law_picture none = *picture;
        char path[100];
        snprintf(path, sizeof path, "%s/first.exr", folder);
        FILE *file = fopen(path, "wb");
        if (!file) abort();
        fwrite(first.bytes, 1, first.size, file);
        fclose(file);
        none.path = path;
        law_result second = law_run(&none, "%s then pfm", about->name);
        CHECK(once.status == HDR_OK && law_same(&once, &second), "%s then %s: not what it is by way of a file",
              variant->words, about->name);
        unlink(path);
        free(behind.bytes);
        free(once.bytes);
        free(first.bytes);
        free(second.bytes);
    }
}

/* ---- All of it ---- */

/* Windows of a hundred pixels are for small pictures. */
static bool is_slow(const law_variant *variant) {
    for (int i = 0; i < variant->values; i++)
        if (variant->value[i].option->type == HDR_OPTION_INTEGER && strtod(variant->value[i].text, NULL) > 5)
            return true;
    return false;
}

int main(void) {
    if (!mkdtemp(folder)) abort();
    snprintf(guide_file, sizeof guide_file, "%s/guide.pfm", folder);
    make_guided_variants();
    law_make_synthetic();
    CHECK(law_variant_count > 5, "only %d variants", law_variant_count);
    for (int p = 0; p < law_picture_count; p++) {
        law_picture *picture = &law_pictures[p];
        law_picture guide = make_guide(picture);
        write_guide(&guide);
        for (int v = 0; v < law_variant_count && !picture->few; v++) {
            const law_variant *variant = &law_variants[v];
            bool small = law_pixels(picture) < 400;
            if ((is_slow(variant) && !small) || (variant->values > 1 && (v + p) % 3)) continue;
            check_settings(picture, variant);
            if (picture->moderate) check_unit(picture, &guide, variant);
            if (picture->moderate && (small || (variant->values > 1 && (v + p) % 5 == 0)))
                check_reference(picture, variant);
            if (variant->values == 1 && !strcmp(picture->name, "ordinary")) check_place(picture, variant);
        }
        law_free_picture(&guide);
    }
    for (int p = 0; p < law_picture_count; p++)
        law_free_picture(&law_pictures[p]);
    unlink(guide_file);
    rmdir(folder);
    return check_done("test_guided");
}
