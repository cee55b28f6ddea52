/* Non-local means by the sums themselves: for each pixel, each pixel of its window, and each of the patch. */
#include "spatial/nlmeans.h"

#include "kernel/real.h"
#include "kernel/strip.h"

#include <math.h>

typedef struct pixel {
    int x, y;
} pixel;

bool hdr_nlmeans_is_wanted(const hdr_nlmeans *filter, const hdr_nlmeans_rows *rows, size_t at) {
    double brightness = 0, largest = 0;
    for (int c = 0; c < rows->channels; c++) {
        double deviation = (double)rows->deviation[c][at];
        brightness += fabs((double)rows->colour[c][at]);
        largest = deviation > largest ? deviation : largest;
    }
    return hdr_nlmeans_sound(rows, at) && largest > filter->above * (brightness / rows->channels);
}

/* d2 of two pixels, summed over the channels. */
static double distance(const hdr_nlmeans *filter, const hdr_nlmeans_rows *rows, size_t a, size_t b) {
    const double infinite = 1e290;
    double sum = 0;
    for (int c = 0; c < rows->channels; c++) {
        double difference = (double)rows->colour[c][a] - (double)rows->colour[c][b];
        double deviation_a = (double)rows->deviation[c][a], deviation_b = (double)rows->deviation[c][b];
        double variance_a = deviation_a * deviation_a, variance_b = deviation_b * deviation_b;
        double left = difference * difference - (variance_a + (variance_b < variance_a ? variance_b : variance_a));
        double divisor = filter->k * filter->k * (variance_a + variance_b);
        double quotient = left / (divisor > DBL_MIN ? divisor : DBL_MIN);
        sum += quotient < infinite ? quotient : infinite;
    }
    return sum;
}

static bool inside(const hdr_nlmeans_rows *rows, int x, int y) {
    return x >= 0 && x < rows->width && y >= 0 && y < rows->height;
}

static double weight(const hdr_nlmeans *filter, const hdr_nlmeans_rows *rows, pixel p, pixel q) {
    double sum = 0;
    int pairs = 0, reach = filter->patch;
    for (int dy = -reach; dy <= reach; dy++)
        for (int dx = -reach; dx <= reach; dx++) {
            if (!inside(rows, p.x + dx, p.y + dy) || !inside(rows, q.x + dx, q.y + dy)) continue;
            size_t a = hdr_nlmeans_place(rows, p.x + dx, p.y + dy), b = hdr_nlmeans_place(rows, q.x + dx, q.y + dy);
            pairs++;
            if (hdr_nlmeans_sound(rows, a) && hdr_nlmeans_sound(rows, b)) sum += distance(filter, rows, a, b);
        }
    double mean = sum / ((double)pairs * rows->channels);
    return hdr_exp(mean > 0 ? -mean : 0);
}

/* The mean of differences from the pixel's own numbers, which loses no digits of these. */
static void filter_pixel(const hdr_nlmeans *filter, const hdr_nlmeans_rows *rows, pixel p, float out[3]) {
    size_t own = hdr_nlmeans_place(rows, p.x, p.y);
    double weights = 0, sums[3] = {0};
    for (int y = p.y - filter->radius; y <= p.y + filter->radius; y++)
        for (int x = p.x - filter->radius; x <= p.x + filter->radius; x++) {
            if (!inside(rows, x, y)) continue;
            size_t at = hdr_nlmeans_place(rows, x, y);
            if (!hdr_nlmeans_sound(rows, at)) continue;
            double w = weight(filter, rows, p, (pixel){x, y});
            weights += w;
            for (int c = 0; c < rows->channels; c++)
                sums[c] += w * ((double)rows->colour[c][at] - (double)rows->colour[c][own]);
        }
    for (int c = 0; c < rows->channels; c++) {
        double value = (double)rows->colour[c][own] + sums[c] / weights;
        hdr_real_to_float(&value, &out[c], 1);
    }
}

uint64_t hdr_nlmeans_exact(const hdr_nlmeans *filter, const hdr_nlmeans_rows *rows) {
    uint64_t left_alone = 0;
    size_t to = 0;
    for (int y = rows->wanted_first; y < rows->wanted_end; y++)
        for (int x = 0; x < rows->width; x++, to++) {
            size_t at = hdr_nlmeans_place(rows, x, y);
            float values[3] = {0};
            bool wanted = hdr_nlmeans_is_wanted(filter, rows, at);
            if (wanted) filter_pixel(filter, rows, (pixel){x, y}, values);
            for (int c = 0; c < rows->channels; c++)
                rows->out[c][to] = wanted ? values[c] : rows->colour[c][at];
            left_alone += !wanted;
        }
    return left_alone;
}
