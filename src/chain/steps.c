#include "chain/steps.h"

#include "kernel/real.h"

#include <float.h>
#include <math.h>
#include <string.h>

void hdr_strip_luminance(hdr_strip *strip, const double weights[3]) {
    if (strip->planes == 1)
        memcpy(strip->y, strip->c[0], strip->count * sizeof(double));
    else
        hdr_luminance(strip->c[0], strip->c[1], strip->c[2], weights, strip->y, strip->count);
}

void hdr_strip_intensity(hdr_strip *strip, const double weights[3], const double lit[3]) {
    hdr_strip_luminance(strip, lit);
    if (strip->planes == 1) return; /* the weights add up to 1 */
    hdr_luminance(strip->c[0], strip->c[1], strip->c[2], weights, strip->ld, strip->count);
    for (size_t i = 0; i < strip->count; i++)
        strip->y[i] = strip->y[i] > 0 ? strip->ld[i] : 0;
}

/* ---- Surrounds ---- */

/* S of a pixel outside the data window, which has nothing around it but its like. */
static double surround_outside(const hdr_step *step, double y) {
    return y > 0 ? step->local->alone(y) : 0;
}

/* S of the strip's pixels into strip->beside. */
static void load_surround(hdr_strip *strip, const hdr_step *step) {
    const hdr_plane *plane = step->surround;
    if (strip->row < 0) {
        for (size_t i = 0; i < strip->count; i++)
            strip->beside[i] = surround_outside(step, strip->y[i]);
        return;
    }
    size_t at = (size_t)strip->row * plane->stride + (size_t)strip->x;
    if (plane->wide)
        memcpy(strip->beside, plane->wide + at, strip->count * sizeof(double));
    else
        hdr_float_to_real(plane->narrow + at, strip->beside, strip->count);
}

/* ---- Colours as a whole ---- */

/* One plane that stood for three becomes three: what comes may make them differ. */
static void spread(hdr_strip *strip) {
    for (; strip->planes < 3; strip->planes++)
        memcpy(strip->c[strip->planes], strip->c[0], strip->count * sizeof(double));
}

static void apply_mapper(hdr_strip *strip, const hdr_mapper *mapper) {
    strip->failed |= !mapper->map(mapper, (double *const[]){strip->c[0], strip->c[1], strip->c[2]}, strip->count);
    for (int p = 0; p < 3; p++) {
        for (size_t i = 0; i < strip->count; i++)
            strip->c[p][i] = isnan(strip->c[p][i]) ? 0 : strip->c[p][i];
        hdr_hold(strip->c[p], strip->count);
    }
}

/* ---- Palettes ---- */

/* Of three numbers the one that is farthest from 0, the first of several. */
static double farthest(double r, double g, double b) {
    double larger = fabs(g) > fabs(r) ? g : r;
    return fabs(b) > fabs(larger) ? b : larger;
}

/* The colour of a value's place in [0,1]; what lies outside has the first or the last. */
static uint32_t colour_at(const uint32_t *palette, double place) {
    double number = place * HDR_PALETTE_SIZE;
    return palette[!(number > 0) ? 0 : number < HDR_PALETTE_SIZE - 1 ? (int)number : HDR_PALETTE_SIZE - 1];
}

static double component_of(uint32_t colour, int plane) {
    return (colour >> (16 - 8 * plane) & 0xff) / 255.0;
}

static void apply_palette(hdr_strip *strip, const hdr_step *step) {
    if (step->of_largest)
        for (size_t i = 0; i < strip->count; i++)
            strip->y[i] = farthest(strip->c[0][i], strip->c[1][i], strip->c[2][i]);
    else
        hdr_strip_luminance(strip, step->luminance);
    step->curve->rows(&step->constants, strip->y, strip->count);
    for (size_t i = 0; i < strip->count; i++) {
        uint32_t colour = colour_at(step->palette, strip->y[i]);
        for (int p = 0; p < 3; p++)
            strip->c[p][i] = component_of(colour, p);
    }
}

/* ---- By rows ---- */

/* strip->ld has Ld: C' = (C/Y)^saturation Ld. */
static void colour_by_luminance(hdr_strip *strip, double saturation) {
    if (saturation == 1) {
        hdr_luminance_ratio(strip->y, strip->ld, strip->count);
        for (int p = 0; p < strip->planes; p++)
            hdr_multiply(strip->c[p], strip->ld, strip->count);
    } else {
        for (int p = 0; p < strip->planes; p++)
            hdr_saturate(strip->c[p], strip->y, strip->ld, saturation, strip->count);
    }
}

static void apply_rows(hdr_strip *strip, const hdr_step *step) {
    switch (step->form) {
    case HDR_FORM_CHANNEL:
        for (int p = 0; p < strip->planes; p++) {
            step->curve->rows(&step->constants, strip->c[p], strip->count);
            hdr_hold(strip->c[p], strip->count);
        }
        break;
    case HDR_FORM_LUMINANCE:
        hdr_strip_luminance(strip, step->luminance);
        memcpy(strip->ld, strip->y, strip->count * sizeof(double));
        step->curve->rows(&step->constants, strip->ld, strip->count);
        colour_by_luminance(strip, step->saturation);
        break;
    case HDR_FORM_LOCAL:
        if (step->own_weights)
            hdr_strip_intensity(strip, step->luminance, step->lit);
        else
            hdr_strip_luminance(strip, step->luminance);
        load_surround(strip, step);
        memcpy(strip->ld, strip->y, strip->count * sizeof(double));
        step->local->rows(&step->constants, strip->ld, strip->beside, strip->count);
        colour_by_luminance(strip, step->saturation);
        break;
    case HDR_FORM_PLACED:
        hdr_dither_thresholds(&step->dither, strip->place_x, strip->place_y, strip->beside, strip->count);
        for (int p = 0; p < strip->planes; p++) {
            step->local->rows(&step->constants, strip->c[p], strip->beside, strip->count);
            hdr_hold(strip->c[p], strip->count);
        }
        break;
    case HDR_FORM_MATRIX:
        hdr_matrix_rows(strip->c[0], strip->c[1], strip->c[2], step->matrix, strip->count);
        break;
    case HDR_FORM_MAPPED:
        apply_mapper(strip, step->mapper);
        break;
    case HDR_FORM_PALETTE:
        apply_palette(strip, step);
        break;
    }
}

/* ---- Value by value: SPEC's formulas and nothing else ---- */

/* S of the strip's pixel i, whose luminance is y. */
static double surround_of(const hdr_strip *strip, size_t i, const hdr_step *step, double y) {
    const hdr_plane *plane = step->surround;
    if (strip->row < 0) return surround_outside(step, y);
    size_t at = (size_t)strip->row * plane->stride + (size_t)strip->x + i;
    return plane->wide ? plane->wide[at] : (double)plane->narrow[at];
}

static void reference_pixel(const hdr_strip *strip, size_t i, const hdr_step *step, double *pixel[3]) {
    int planes = strip->planes;
    double r = *pixel[0], g = planes == 3 ? *pixel[1] : r, b = planes == 3 ? *pixel[2] : r;
    if (step->form == HDR_FORM_CHANNEL) {
        for (int p = 0; p < planes; p++)
            *pixel[p] = hdr_held(step->curve->exact(&step->constants, *pixel[p]));
    } else if (step->form == HDR_FORM_PLACED) {
        double threshold = hdr_dither_threshold(&step->dither, strip->place_x + (int)i, strip->place_y);
        for (int p = 0; p < planes; p++)
            *pixel[p] = hdr_held(step->local->exact(&step->constants, *pixel[p], threshold));
    } else if (step->form == HDR_FORM_PALETTE) {
        const double *w = step->luminance;
        double y = r == g && g == b ? r : w[0] * r + w[1] * g + w[2] * b;
        double value = step->of_largest ? farthest(r, g, b) : y;
        uint32_t colour = colour_at(step->palette, step->curve->exact(&step->constants, value));
        for (int p = 0; p < 3; p++)
            *pixel[p] = component_of(colour, p);
    } else if (step->form != HDR_FORM_MATRIX) {
        const double *w = step->luminance;
        double y = r == g && g == b ? r : w[0] * r + w[1] * g + w[2] * b;
        const double *lit = step->lit;
        if (step->own_weights && !(r == g && g == b) && !(lit[0] * r + lit[1] * g + lit[2] * b > 0)) y = 0;
        double ld = step->form == HDR_FORM_LOCAL
                        ? step->local->exact(&step->constants, y, surround_of(strip, i, step, y))
                        : step->curve->exact(&step->constants, y);
        for (int p = 0; p < planes; p++) {
            double c = *pixel[p];
            if (!(y > 0))
                c = 0;
            else if (step->saturation == 1)
                c = c * (ld / y);
            else
                c = hdr_pow(c / y > 0 ? c / y : 0, step->saturation) * ld;
            *pixel[p] = hdr_held(c);
        }
    } else {
        const double *m = step->matrix;
        *pixel[0] = hdr_held(m[0] * r + m[1] * g + m[2] * b);
        *pixel[1] = hdr_held(m[3] * r + m[4] * g + m[5] * b);
        *pixel[2] = hdr_held(m[6] * r + m[7] * g + m[8] * b);
    }
}

static void apply_reference(hdr_strip *strip, const hdr_step *step) {
    for (size_t i = 0; i < strip->count; i++)
        reference_pixel(strip, i, step, (double *[3]){&strip->c[0][i], &strip->c[1][i], &strip->c[2][i]});
}

void hdr_strip_apply(hdr_strip *strip, const hdr_step *steps, int first, int end, bool reference) {
    for (int s = first; s < end; s++) {
        bool mapped = steps[s].form == HDR_FORM_MAPPED;
        if (mapped || steps[s].form == HDR_FORM_MATRIX || steps[s].form == HDR_FORM_PALETTE) spread(strip);
        if (reference && !mapped)
            apply_reference(strip, &steps[s]);
        else
            apply_rows(strip, &steps[s]);
    }
}

/* ---- The tail as thresholds ---- */

int hdr_steps_tail(const hdr_step *steps, int count) {
    int tail = count;
    while (tail > 0 && steps[tail - 1].form == HDR_FORM_CHANNEL)
        tail--;
    return tail;
}

/* Codes of values, by rows. count <= HDR_STRIP. */
static void codes_of(const hdr_step *steps, int step_count, const double *values, uint8_t *codes, size_t count) {
    double work[HDR_STRIP];
    memcpy(work, values, count * sizeof(double));
    for (int s = 0; s < step_count; s++) {
        steps[s].curve->rows(&steps[s].constants, work, count);
        hdr_hold(work, count);
    }
    hdr_codes_u8(work, 255, codes, 1, count);
}

/* The smallest value, 0 or above, that the steps carry beyond a limit; +inf where none is. */
static double first_beyond(const hdr_step *steps, int count, double limit) {
    uint64_t low = 0, high = hdr_real_bits((double)FLT_MAX) + 1;
    while (low < high) {
        uint64_t middle = low + (high - low) / 2;
        double value = hdr_real_from_bits(middle);
        for (int s = 0; s < count; s++)
            value = hdr_held(steps[s].curve->exact(&steps[s].constants, value));
        if (value > limit)
            high = middle;
        else
            low = middle + 1;
    }
    return low > hdr_real_bits((double)FLT_MAX) ? (double)INFINITY : hdr_real_from_bits(low);
}

/* A curve whose two branches overlap falls where they meet. That is of no account unless a code changes there. */
static bool falls_at_joint(const hdr_step *steps, int count) {
    for (int s = 0; s < count; s++) {
        if (!steps[s].curve->has_joint) continue;
        double above = first_beyond(steps, s, steps[s].curve->joint);
        if (!(above > 0 && isfinite(above))) continue;
        double values[2] = {nextafter(above, 0), above};
        uint8_t codes[2];
        codes_of(steps, count, values, codes, 2);
        if (codes[0] > codes[1]) return true;
    }
    return false;
}

/* Whether codes change within what rounding makes of a curve that is monotone on the whole, but not to the bit: C^inf
 * behind L / (1 + L), which falls and rises by an ulp where it is almost 1. Thresholds that lie so close tell. */
static bool outruns_rounding(const hdr_step *steps, int count, const uint64_t *thresholds, unsigned codes) {
    enum { ULPS = 64 };
    bool wavers = false;
    for (int s = 0; s < count; s++)
        wavers |= !steps[s].curve->monotone_to_the_bit;
    for (unsigned k = 1; wavers && k < codes; k++)
        if (thresholds[k] - thresholds[k - 1] < ULPS) return true;
    return false;
}

/* All thresholds at once by bisection over the bits of positive doubles, which order as the doubles do. Exact: every
 * step is monotone, so the smallest value with a code of k or more is where the bisection ends. */
bool hdr_steps_tabulate(const hdr_step *steps, int count, hdr_code_table *table) {
    enum { TOP = 255 };
    double probe[TOP + 1] = {0, -(double)FLT_MAX, (double)FLT_MAX};
    uint8_t code[TOP + 1];
    codes_of(steps, count, probe, code, 3);
    if (code[1] != code[0] || falls_at_joint(steps, count)) return false;
    unsigned at_zero = code[0], at_largest = code[2];
    uint64_t low[TOP + 1], high[TOP + 1]; /* code(low) < k <= code(high) */
    for (unsigned k = 0; k <= TOP; k++) {
        low[k] = 0;
        high[k] = hdr_real_bits((double)FLT_MAX);
    }
    for (int halving = 0; halving < 63; halving++) {
        for (unsigned k = 0; k <= TOP; k++)
            probe[k] = hdr_real_from_bits(low[k] + (high[k] - low[k]) / 2);
        codes_of(steps, count, probe, code, TOP + 1);
        for (unsigned k = 0; k <= TOP; k++) {
            uint64_t middle = hdr_real_bits(probe[k]);
            if (code[k] >= k)
                high[k] = middle;
            else
                low[k] = middle;
        }
    }
    if (outruns_rounding(steps, count, high + at_zero + 1, at_largest - at_zero)) return false;
    for (unsigned k = 0; k <= TOP; k++)
        table->threshold[k] = k <= at_zero ? 0 : k > at_largest ? (double)INFINITY : hdr_real_from_bits(high[k]);
    hdr_code_table_index(table, TOP);
    return true;
}
