/* The inner loops at every instruction set that this processor has, against plain C that is right at a glance. Each
 * level runs in a child of its own, because the level is chosen once a process. Lengths run over everything that a
 * vector loop and its remainder may meet, places over everything that an aligned load could stumble on, and what lies
 * beside the output has to stay as it was. */
#include "check.h"
#include "kernels.h"
#include "levels.h"
#include "kernel/codes.h"
#include "kernel/pngfilter.h"
#include "kernel/predict_encode.h"
#include "kernel/predictor.h"
#include "kernel/real.h"
#include "kernel/strip.h"

#include <float.h>
#include <stdlib.h>

/* ---- Stored types ---- */

static double plain_half(uint16_t half) {
    int exponent = half >> 10 & 31, fraction = half & 1023;
    double magnitude = exponent == 31  ? (fraction ? (double)NAN : (double)INFINITY)
                       : exponent == 0 ? ldexp(fraction, -24)
                                       : ldexp(1024 + fraction, exponent - 25);
    return half & 0x8000 ? -magnitude : magnitude;
}

static void test_half_to_real(void) {
    static uint16_t half[65536];
    static double real[65536];
    for (unsigned i = 0; i < 65536; i++) {
        double expected = plain_half((uint16_t)i), value = hdr_half_value((uint16_t)i);
        CHECK(isnan(expected) ? isnan(value) : same_bits(&expected, &value, 8), "half value %04x is %a", i, value);
        half[i] = isfinite(expected) ? (uint16_t)i : 0;
    }
    hdr_half_to_real(half, real, 65536);
    for (unsigned i = 0; i < 65536; i++) {
        double expected = plain_half(half[i]);
        CHECK(same_bits(&expected, &real[i], 8), "half %04x becomes %a", half[i], real[i]);
    }
    for (int l = 0; l < LENGTHS; l++)
        for (size_t offset = 0; offset < OFFSETS; offset++) {
            size_t count = length_number(l);
            double *out = guard(&room, offset * sizeof(double));
            hdr_half_to_real(half + 0x3c00 + offset, out, count);
            bool same = same_bits(out, real + 0x3c00 + offset, count * sizeof(double));
            CHECK(same && guards_stand(&room, count * sizeof(double)), "half to real, %zu at %zu", count, offset);
        }
}

/* The half nearest to a finite number of halves in ascending order: the last that is not above, or its neighbour. */
static uint16_t plain_half_nearest(double value) {
    uint16_t sign = signbit(value) ? 0x8000 : 0;
    double magnitude = fabs(value);
    if (magnitude >= 65504) return sign | 0x7bff;
    unsigned low = 0, high = 0x7bff;
    while (high - low > 1) {
        unsigned middle = (low + high) / 2;
        if (plain_half((uint16_t)middle) <= magnitude)
            low = middle;
        else
            high = middle;
    }
    double between = (plain_half((uint16_t)low) + plain_half((uint16_t)high)) / 2; /* exact */
    bool up = magnitude > between || (magnitude == between && (low & 1));
    return (uint16_t)(sign | (up ? high : low));
}

static void check_half_nearest(const double *values, size_t count) {
    static uint16_t half[4096];
    hdr_real_to_half(values, half, count);
    for (size_t i = 0; i < count; i++) {
        uint16_t expected = plain_half_nearest(values[i]);
        CHECK(half[i] == expected, "%a becomes half %04x, not %04x", values[i], half[i], expected);
        CHECK(hdr_half_nearest(values[i]) == expected, "hdr_half_nearest(%a) is not %04x", values[i], expected);
    }
}

static void test_real_to_half(void) {
    double values[8];
    for (unsigned h = 0; h < 0x7bff; h++) {
        double low = plain_half((uint16_t)h), between = (low + plain_half((uint16_t)(h + 1))) / 2;
        values[0] = low;
        values[1] = between;
        values[2] = nextafter(between, -1);
        values[3] = nextafter(between, 1e9);
        for (int i = 0; i < 4; i++)
            values[4 + i] = -values[i];
        check_half_nearest(values, 8);
    }
    static const double extremes[] = {65504,   65505,   65519.999, 65520,   65536,  1e9,
                                      FLT_MAX, DBL_MAX, 0x1p-1074, 0x1p-25, 0x1p-14};
    check_half_nearest(extremes, sizeof extremes / sizeof *extremes);
    static double random[4096];
    for (int round = 0; round < 1000000 / 4096 + 1; round++) {
        fill(random, 4096, round % 8 ? -30 : -300, round % 8 ? 18 : 300);
        check_half_nearest(random, 4096);
    }
}

static void test_floats(void) {
    static double real[LONGEST + OFFSETS];
    static float values[LONGEST + OFFSETS], expected[LONGEST];
    for (int l = 0; l < LENGTHS; l++)
        for (size_t offset = 0; offset < OFFSETS; offset++) {
            size_t count = length_number(l);
            fill(real, LONGEST + OFFSETS, -160, 135);
            real[offset] = l % 3 ? nextafter((double)FLT_MAX, 1e300) : -(double)INFINITY;
            for (size_t i = 0; i < count; i++)
                expected[i] = (float)plain_hold(real[offset + i]);
            float *out = guard(&room, offset * sizeof(float));
            hdr_real_to_float(real + offset, out, count);
            CHECK(same_bits(out, expected, count * sizeof(float)) && guards_stand(&room, count * sizeof(float)),
                  "real to float, %zu at %zu", count, offset);
            for (size_t i = 0; i < LONGEST + OFFSETS; i++)
                values[i] = (float)plain_hold(real[i]);
            double *back = guard(&other_room, offset * sizeof(double));
            hdr_float_to_real(values + offset, back, count);
            bool same = guards_stand(&other_room, count * sizeof(double));
            for (size_t i = 0; i < count; i++) {
                double one = (double)values[offset + i];
                same &= same_bits(&one, &back[i], sizeof one);
            }
            CHECK(same, "float to real, %zu at %zu", count, offset);
            double *held = guard(&third_room, offset * sizeof(double));
            memcpy(held, real + offset, count * sizeof(double));
            hdr_hold(held, count);
            same = guards_stand(&third_room, count * sizeof(double));
            for (size_t i = 0; i < count; i++)
                same &= held[i] == plain_hold(real[offset + i]);
            CHECK(same, "hold, %zu at %zu", count, offset);
        }
}

/* One bad value at each place in turn; those on either side of the piece do not count. */
static void test_half_largest(void) {
    static uint16_t half[LONGEST + OFFSETS];
    for (int l = 0; l < LENGTHS; l++)
        for (size_t offset = 0; offset < OFFSETS; offset++) {
            size_t count = length_number(l);
            double largest = 0;
            for (size_t i = 0; i < LONGEST + OFFSETS; i++)
                half[i] = (uint16_t)(random_bits() % 0x7c00 | (offset % 3 == 1 || random_bits() % 2 ? 0x8000 : 0));
            for (size_t i = 0; i < count; i++)
                largest = fmax(largest, plain_half(half[offset + i]));
            CHECK(hdr_half_value(hdr_half_largest(half + offset, count)) == largest, "largest half of %zu at %zu",
                  count, offset);
        }
}

static void test_all_finite(void) {
    static const uint16_t bad_half[] = {0x7c00, 0xfc00, 0x7c01, 0xffff};
    static const float bad_float[] = {INFINITY, -INFINITY, NAN, -NAN};
    uint16_t half[160];
    float values[160];
    for (size_t count = 0; count <= 130; count++)
        for (size_t offset = 1; offset <= OFFSETS; offset++)
            for (size_t bad = 0; bad <= count; bad++) { /* bad == count: none */
                for (size_t i = 0; i < 160; i++) {
                    bool inside = i >= offset && i < offset + count;
                    half[i] = inside ? (i & 1 ? 0x7bff : 0xfbff) : 0x7e00;
                    values[i] = inside ? (i & 1 ? FLT_MAX : -FLT_MAX) : INFINITY;
                }
                if (bad < count) half[offset + bad] = bad_half[bad & 3], values[offset + bad] = bad_float[bad & 3];
                CHECK(hdr_half_all_finite(half + offset, count) == (bad == count), "half finite, %zu of %zu", bad,
                      count);
                CHECK(hdr_float_all_finite(values + offset, count) == (bad == count), "float finite, %zu of %zu", bad,
                      count);
                if (count > 70 && bad + 1 < count) bad += 7;
            }
}

/* ---- Colour ---- */

/* A kernel under test, in place on the guarded rooms a, b and c; and the same, pixel by pixel. */
typedef struct colour_case {
    const char *name;
    void (*kernel)(double *a, double *b, double *c, size_t count);
    void (*plain)(double *a, double *b, double *c);
} colour_case;

static const double weights[3] = {0.2126, 0.7152, 0.0722};
static const double matrix[9] = {1.2, -0.3, 0.1, 0.05, 0.9, 0.05, -0.01, 1e30, 1};
static double saturation;

static void luminance(double *a, double *b, double *c, size_t count) {
    double y[LONGEST];
    hdr_luminance(a, b, c, weights, y, count);
    memcpy(a, y, count * sizeof *a);
}
static void plain_luminance(double *a, double *b, double *c) {
    if (*a == *b && *b == *c) return;
    *a = weights[0] * *a + weights[1] * *b + weights[2] * *c;
}
static void ratio(double *a, double *b, double *c, size_t count) {
    (void)c;
    hdr_luminance_ratio(b, a, count);
}
static void plain_ratio(double *a, double *b, double *c) {
    (void)c;
    *a = *b > 0 ? *a / *b : 0;
}
static void multiply(double *a, double *b, double *c, size_t count) {
    (void)c;
    hdr_multiply(a, b, count);
}
static void plain_multiply(double *a, double *b, double *c) {
    (void)c;
    *a = *b == 0 ? 0 : plain_hold(*a * *b);
}
static void saturate(double *a, double *b, double *c, size_t count) {
    hdr_saturate(a, b, c, saturation, count);
}
static void plain_saturate(double *a, double *b, double *c) {
    *a = *b > 0 ? plain_hold(hdr_pow(*a / *b > 0 ? *a / *b : 0, saturation) * *c) : 0;
}
static void matrix_rows(double *a, double *b, double *c, size_t count) {
    hdr_matrix_rows(a, b, c, matrix, count);
}
static void plain_matrix(double *a, double *b, double *c) {
    double x = *a, y = *b, z = *c;
    *a = plain_hold(matrix[0] * x + matrix[1] * y + matrix[2] * z);
    *b = plain_hold(matrix[3] * x + matrix[4] * y + matrix[5] * z);
    *c = plain_hold(matrix[6] * x + matrix[7] * y + matrix[8] * z);
}
static void unassociate(double *a, double *b, double *c, size_t count) {
    (void)c;
    hdr_unassociate(a, b, count);
}
static void plain_unassociate(double *a, double *b, double *c) {
    (void)c;
    if (*b > 0) *a = *a / *b;
    *a = plain_hold(*a);
}
static void associate(double *a, double *b, double *c, size_t count) {
    (void)c;
    hdr_associate(a, b, count);
}
static void plain_associate(double *a, double *b, double *c) {
    (void)c;
    if (*b > 0) *a = *a * *b;
    *a = plain_hold(*a);
}
static void lay_over(double *a, double *b, double *c, size_t count) {
    (void)c;
    hdr_lay_over(a, b, 0.3, count);
}
static void plain_lay_over(double *a, double *b, double *c) {
    (void)c;
    *a = plain_hold(*a + (1 - *b) * 0.3);
}

static const colour_case colour_cases[] = {
    {"luminance", luminance, plain_luminance}, {"luminance ratio", ratio, plain_ratio},
    {"multiply", multiply, plain_multiply},    {"saturate", saturate, plain_saturate},
    {"matrix", matrix_rows, plain_matrix},     {"unassociate", unassociate, plain_unassociate},
    {"associate", associate, plain_associate}, {"lay over", lay_over, plain_lay_over},
};

static void test_colour_case(const colour_case *test, size_t count, size_t offset) {
    static double plain[3][LONGEST];
    guarded *rooms[3] = {&room, &other_room, &third_room};
    double *plane[3];
    for (int p = 0; p < 3; p++) {
        plane[p] = guard(rooms[p], ((offset + (size_t)p) % OFFSETS) * sizeof(double));
        fill(plane[p], count, -149, 128);
    }
    for (size_t i = 0; i < count; i += 3)
        plane[1][i] = plane[2][i] = plane[0][i]; /* grey now and then */
    for (int p = 0; p < 3; p++)
        memcpy(plain[p], plane[p], count * sizeof(double));
    for (size_t i = 0; i < count; i++)
        test->plain(&plain[0][i], &plain[1][i], &plain[2][i]);
    test->kernel(plane[0], plane[1], plane[2], count);
    bool same = true;
    for (int p = 0; p < 3; p++)
        same &= same_bits(plane[p], plain[p], count * sizeof(double)) && guards_stand(rooms[p], count * sizeof(double));
    CHECK(same, "%s, %zu at %zu", test->name, count, offset);
}

static void test_colour(void) {
    static const double saturations[] = {0, 0.5, 1, 2};
    for (size_t t = 0; t < sizeof colour_cases / sizeof *colour_cases; t++)
        for (int l = 0; l < LENGTHS; l++)
            for (size_t offset = 0; offset < OFFSETS; offset++) {
                saturation = saturations[(size_t)l % 4];
                test_colour_case(&colour_cases[t], length_number(l), offset);
            }
}

/* ---- Codes ---- */

static unsigned plain_code(double value, double top) {
    double held = value < 0 ? 0 : value > 1 ? 1 : value;
    return (unsigned)floor(held * top + 0.5);
}

static void test_codes(void) {
    static double values[LONGEST + OFFSETS];
    static const double tops[] = {1, 3, 31, 255, 1023, 65535};
    for (int l = 0; l < LENGTHS; l++)
        for (size_t stride = 1; stride <= 4; stride++) {
            size_t count = length_number(l), offset = (size_t)l % OFFSETS;
            double top = tops[(size_t)l % 6], small_top = top > 255 ? 255 : top;
            for (size_t i = 0; i < LONGEST + OFFSETS; i++) {
                /* boundaries between codes, their neighbours, what is outside, and anything */
                double boundary = floor(random_unit() * top) / top + 0.5 / top;
                uint64_t kind = random_bits() % 6;
                values[i] = kind == 0   ? boundary
                            : kind == 1 ? nextafter(boundary, 0)
                            : kind == 2 ? nextafter(boundary, 2)
                            : kind == 3 ? random_signed(-140, 127)
                                        : random_unit();
            }
            unsigned char *bytes = guard(&room, offset);
            uint16_t *words = guard(&other_room, offset * 2);
            hdr_codes_u8(values + offset, small_top, bytes, stride, count);
            hdr_codes_u16(values + offset, top, words, stride, count);
            bool same = true;
            for (size_t i = 0; i < count; i++) {
                same &= bytes[i * stride] == plain_code(values[offset + i], small_top);
                same &= words[i * stride] == plain_code(values[offset + i], top);
                for (size_t beside = 1; beside < stride; beside++) /* samples of other channels */
                    same &= bytes[i * stride + beside] == 0xa5 && words[i * stride + beside] == 0xa5a5;
            }
            CHECK(same, "codes to %g, %zu with stride %zu", top, count, stride);
            CHECK(guards_stand(&room, count * stride) && guards_stand(&other_room, 2 * count * stride),
                  "codes write outside, %zu with stride %zu", count, stride);
        }
}

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Ascending thresholds of one of several kinds: spread, in clusters of neighbouring doubles, many times the same, with
 * zeros in front and infinities behind, and over all of double's range. */
static void random_thresholds(double *threshold, int top, unsigned kind) {
    double cluster = 0;
    for (int k = 0; k <= top; k++) {
        double wide = ldexp(1 + random_unit(), (int)(random_bits() % 270) - 140);
        switch (kind % 7) {
        case 0:
            threshold[k] = random_unit();
            break;
        case 1:
            threshold[k] = wide;
            break;
        case 2: /* clusters */
            cluster = random_bits() % 12 ? nextafter(cluster, 1e300) : wide;
            threshold[k] = cluster;
            break;
        case 3: /* the same */
            cluster = random_bits() % 5 ? cluster : wide;
            threshold[k] = cluster;
            break;
        case 6: /* where buckets begin */
            threshold[k] = ldexp((double)(1 + random_bits() % 4), (int)(random_bits() % 12) - 10);
            break;
        case 4: /* as an encoding has them */
            threshold[k] = pow((k + 0.5) / (top + 1), 2.2);
            break;
        default: /* over all of double, subnormals too */
            threshold[k] = ldexp(1 + random_unit(), (int)(random_bits() % 2090) - 1070);
        }
    }
    qsort(threshold, (size_t)top + 1, sizeof *threshold, compare_doubles);
    int zeros = kind % 3 == 1 ? (int)(random_bits() % (unsigned)(top + 2)) : 1;
    int infinities = kind % 5 == 2 ? (int)(random_bits() % (unsigned)(top + 2)) : 0;
    for (int k = 0; k < zeros; k++)
        threshold[k] = 0;
    for (int k = 0; k < infinities; k++)
        threshold[top - k] = (double)INFINITY;
    threshold[0] = 0;
}

static unsigned plain_lookup(const double *threshold, int top, double value) {
    double raised = value > 0 ? value : 0;
    unsigned code = 0;
    for (int k = 1; k <= top; k++)
        code += raised >= threshold[k];
    return code;
}

static void test_lookup_table(unsigned round) {
    static hdr_code_table table;
    static double values[LONGEST];
    static const int tops[] = {255, 1, 2, 7, 63, 254};
    int top = tops[round % 5 == 0 ? round / 5 % 6 : 0];
    random_thresholds(table.threshold, top, round);
    double plain[256];
    memcpy(plain, table.threshold, sizeof plain);
    hdr_code_table_index(&table, top);
    static const double extremes[] = {0, -0.0, -1, -1e300, 0x1p-1074, -0x1p-1074, 1, FLT_MAX, -FLT_MAX, DBL_MAX};
    size_t count = 0;
    for (; count < sizeof extremes / sizeof *extremes; count++)
        values[count] = extremes[count];
    for (int k = 0; k <= top && count + 3 < LONGEST; k++) {
        double at = isfinite(plain[k]) ? plain[k] : 1;
        values[count++] = at;
        values[count++] = nextafter(at, -1);
        values[count++] = at < DBL_MAX ? nextafter(at, 1e308) : at;
    }
    while (count < LONGEST)
        values[count] = plain[random_bits() % (unsigned)(top + 1)] * (1 + random_unit()), count++;
    for (size_t i = 0; i < LONGEST; i++)
        if (!isfinite(values[i])) values[i] = random_signed(-149, 128);
    size_t stride = round % 4 + 1;
    unsigned char *out = guard(&room, round % OFFSETS);
    hdr_code_lookup(&table, values, out, stride, LONGEST);
    for (size_t i = 0; i < LONGEST; i++) {
        unsigned expected = plain_lookup(plain, top, values[i]);
        CHECK(out[i * stride] == expected, "table %u: %a has code %d, not %u", round, values[i], out[i * stride],
              expected);
    }
    CHECK(guards_stand(&room, LONGEST * stride), "table %u writes outside", round);
}

static void test_lookup(void) {
    for (unsigned round = 0; round < 300; round++)
        test_lookup_table(round);
    static hdr_code_table table;
    for (int k = 0; k < 256; k++)
        table.threshold[k] = k ? (k - 0.5) / 255 : 0;
    hdr_code_table_index(&table, 255);
    double values[70];
    for (size_t i = 0; i < 70; i++)
        values[i] = random_unit();
    for (size_t count = 0; count <= 70; count++) {
        unsigned char *out = guard(&room, count % OFFSETS);
        hdr_code_lookup(&table, values, out, 1, count);
        bool same = guards_stand(&room, count);
        for (size_t i = 0; i < count; i++)
            same &= out[i] == plain_code(values[i], 255);
        CHECK(same, "lookup of %zu", count);
    }
    static uint8_t codes[65536];
    static uint16_t half[3][LONGEST];
    for (unsigned i = 0; i < 65536; i++)
        codes[i] = (uint8_t)(i * 40503u >> 8);
    for (size_t i = 0; i < 3 * LONGEST; i++)
        half[i / LONGEST][i % LONGEST] = (uint16_t)random_bits();
    for (int l = 0; l < LENGTHS; l++)
        for (int planes = 1; planes <= 3; planes += 2) {
            size_t count = length_number(l), offset = count < 70 ? count % OFFSETS : 0;
            const uint16_t *plane[3] = {half[0] + offset, half[1] + offset, half[2] + offset};
            unsigned char *out = guard(&room, offset);
            hdr_code_half(codes, plane, planes, out, count);
            bool same = guards_stand(&room, count * (size_t)planes);
            for (size_t i = 0; i < count * (size_t)planes; i++)
                same &= out[i] == codes[plane[i % (size_t)planes][i / (size_t)planes]];
            CHECK(same, "codes of %zu halves in %d planes", count, planes);
        }
}

/* ---- Facts ---- */

static void test_facts(void) {
    static double values[LONGEST + OFFSETS];
    for (int l = 0; l < LENGTHS; l++)
        for (size_t offset = 0; offset < OFFSETS; offset++) {
            size_t count = length_number(l);
            fill(values, LONGEST + OFFSETS, -149, 128);
            for (size_t i = 0; offset % 3 == 1 && i < LONGEST + OFFSETS; i++)
                values[i] = -fabs(values[i]);
            hdr_range range = HDR_RANGE_EMPTY, plain = HDR_RANGE_EMPTY;
            if (offset & 1) range = plain = (hdr_range){-0x1p-100, 0x1p-100, 0x1p-120};
            double lanes[8] = {0}, plain_lanes[8] = {0};
            uint64_t lit = 5, plain_lit = 5;
            double largest = 0;
            for (size_t i = 0; i < count; i++) {
                double v = values[offset + i];
                largest = v > largest ? v : largest;
                plain.min = v < plain.min ? v : plain.min;
                plain.max = v > plain.max ? v : plain.max;
                if (v > 0 && v < plain.min_positive) plain.min_positive = v;
                if (v > 0) plain_lanes[i % 8] += hdr_log(v), plain_lit++;
            }
            hdr_range_add(&range, values + offset, count);
            CHECK(range.min == plain.min && range.max == plain.max && range.min_positive == plain.min_positive,
                  "range of %zu at %zu", count, offset);
            CHECK(hdr_largest(values + offset, count) == largest, "largest of %zu at %zu", count, offset);
            hdr_sum_logs(values + offset, lanes, &lit, count);
            CHECK(same_bits(lanes, plain_lanes, sizeof lanes) && lit == plain_lit, "logs of %zu at %zu", count, offset);
        }
    CHECK(hdr_sum_lanes((const double[]){1, 20, 300, 4000, 5e4, 6e5, 7e6, 8e7}) == 87654321, "sum of lanes");
    float before = -INFINITY;
    for (int64_t key = 0; key <= UINT32_MAX; key += 65521) {
        float value = hdr_float_of_key((uint32_t)key);
        if (isnan(value)) continue;
        CHECK(hdr_float_key(value) == (uint32_t)key && value >= before, "key %08x", (unsigned)key);
        before = value;
    }
}

/* ---- Bytes ---- */

static void test_png_filters(void) {
    static uint8_t in[8 * LONGEST + OFFSETS];
    static uint16_t wide[4 * LONGEST + OFFSETS];
    for (size_t i = 0; i < sizeof in; i++)
        in[i] = (uint8_t)random_bits();
    for (size_t i = 0; i < sizeof wide / 2; i++)
        wide[i] = (uint16_t)random_bits();
    for (int l = 1; l < LENGTHS; l++)
        for (size_t step = 1; step <= 8; step++) {
            size_t bytes = length_number(l) * step, offset = (size_t)l % OFFSETS;
            uint8_t *out = guard(&room, step % OFFSETS);
            hdr_png_sub_8(out, in + offset, bytes, step);
            bool same = guards_stand(&room, bytes);
            for (size_t i = 0; i < bytes; i++)
                same &= out[i] == (uint8_t)(in[offset + i] - (i < step ? 0 : in[offset + i - step]));
            CHECK(same, "sub, %zu bytes by %zu", bytes, step);
            if (step > 4) continue;
            out = guard(&room, step % OFFSETS);
            hdr_png_sub_16(out, wide + offset, bytes, step);
            same = guards_stand(&room, 2 * bytes);
            for (size_t i = 0; i < bytes; i++) {
                unsigned here = wide[offset + i], left = i < step ? 0 : wide[offset + i - step];
                same &= out[2 * i] == (uint8_t)((here >> 8) - (left >> 8)) && out[2 * i + 1] == (uint8_t)(here - left);
            }
            CHECK(same, "sub 16, %zu samples by %zu", bytes, step);
        }
}

/* As OpenEXR describes it: differences undone, then the halves interleaved. */
static void plain_undo(const unsigned char *in, size_t size, unsigned char *out) {
    static unsigned char sum[2 * LONGEST + 2];
    for (size_t i = 0; i < size; i++)
        sum[i] = (unsigned char)(i ? sum[i - 1] + in[i] - 128 : in[0]);
    for (size_t i = 0; i < size; i++)
        out[i] = sum[i / 2 + (i & 1 ? (size + 1) / 2 : 0)];
}

static void test_predictors(void) {
    static unsigned char in[2 * LONGEST + OFFSETS], plain[2 * LONGEST + 2];
    for (size_t i = 0; i < sizeof in; i++)
        in[i] = (unsigned char)random_bits();
    for (size_t size = 0; size <= 2 * LONGEST; size += size < 300 ? 1 : 211) {
        size_t offset = size / 3 % OFFSETS;
        plain_undo(in + offset, size, plain);
        for (int level = -1; level <= (int)hdr_cpu(); level++) { /* -1: the one that is chosen */
            unsigned char *out = guard(&room, size % 17);
            if (level < 0)
                hdr_predictor_undo(in + offset, size, out);
            else
                hdr_predictor_at((hdr_cpu_level)level)(in + offset, size, out);
            CHECK(same_bits(out, plain, size) && guards_stand(&room, size), "predictor undone, %zu bytes at level %d",
                  size, level);
        }
        /* split at some place into two calls, as a chunk of many rows is */
        size_t pairs = size / 2, first = pairs / 3, whole = 2 * pairs;
        plain_undo(in + offset, whole, plain);
        uint8_t *even = guard(&room, size % 17), *odd = guard(&other_room, size % 13);
        uint8_t start[2] = {128, whole ? plain[2 * (pairs - 1)] : 0}, middle[2] = {0, 0};
        if (first) memcpy(middle, plain + 2 * first - 2, 2);
        hdr_predict_split(even, odd, plain, first, start);
        hdr_predict_split(even + first, odd + first, plain + 2 * first, pairs - first, first ? middle : start);
        CHECK(same_bits(even, in + offset, pairs) && same_bits(odd, in + offset + pairs, pairs) &&
                  guards_stand(&room, pairs) && guards_stand(&other_room, pairs),
              "predictor made, %zu pairs", pairs);
    }
}

/* ---- Levels ---- */

static uint64_t test_level(void) {
    random_state = 20021;
    test_half_to_real();
    test_real_to_half();
    test_floats();
    test_all_finite();
    test_half_largest();
    test_colour();
    test_codes();
    test_lookup();
    test_facts();
    test_png_filters();
    test_predictors();
    return 0; /* each result is checked by itself */
}

int main(void) {
    check_at_levels(test_level);
    return check_done("test_kernels");
}
