#include "kernel/errors.h"

#include "base/cpu.h"
#include "kernel/strip.h"

#include <math.h>

enum { LANES = 8 };

HDR_INLINE void add_pair(double x, double r, double epsilon, double lane[HDR_ERROR_SUMS][LANES], size_t l) {
    bool finite = x - x == 0 && r - r == 0;
    double test = finite ? x : 0, reference = finite ? r : 0;
    double d = test - reference, size = fabs(d), square = d * d, of = fabs(reference);
    lane[HDR_SUM_COUNT][l] += finite ? 1 : 0;
    lane[HDR_SUM_SIGNED][l] += d;
    lane[HDR_SUM_ABSOLUTE][l] += size;
    lane[HDR_SUM_SQUARED][l] += square;
    lane[HDR_SUM_RELATIVE_SQUARE][l] += square / (reference * reference + epsilon);
    lane[HDR_SUM_RELATIVE][l] += size / (of + epsilon);
    lane[HDR_SUM_SYMMETRIC][l] += size / (fabs(test) + of + epsilon);
}

HDR_INLINE void add_lanes_body(const double *x, const double *r, size_t count, double epsilon,
                               double lane[HDR_ERROR_SUMS][LANES]) {
    size_t whole = count / LANES * LANES;
    for (size_t i = 0; i < whole; i += LANES)
        for (size_t l = 0; l < LANES; l++)
            add_pair(x[i + l], r[i + l], epsilon, lane, l);
    for (size_t i = whole; i < count; i++)
        add_pair(x[i], r[i], epsilon, lane, i - whole);
}
HDR_VERSIONS_IN(static, add_lanes,
                (const double *x, const double *r, size_t count, double epsilon, double lane[HDR_ERROR_SUMS][LANES]),
                (x, r, count, epsilon, lane))

HDR_INLINE void find_worst_body(const double *x, const double *r, size_t count, double *worst) {
    double most = *worst;
    for (size_t i = 0; i < count; i++) {
        double d = fabs(x[i] - r[i]);
        most = d - d == 0 && d > most ? d : most;
    }
    *worst = most;
}
HDR_VERSIONS_IN(static, find_worst, (const double *x, const double *r, size_t count, double *worst),
                (x, r, count, worst))

void hdr_error_sums(const double *x, const double *r, size_t count, double epsilon, double sums[HDR_ERROR_SUMS]) {
    double lane[HDR_ERROR_SUMS][LANES] = {{0}};
    add_lanes(x, r, count, epsilon, lane);
    for (int s = 0; s < HDR_ERROR_SUMS; s++)
        sums[s] += hdr_sum_lanes(lane[s]);
}

size_t hdr_error_worst(const double *x, const double *r, size_t count, double *worst) {
    double before = *worst;
    size_t at = 0;
    find_worst(x, r, count, worst);
    if (!(*worst > before)) return count;
    while (fabs(x[at] - r[at]) != *worst)
        at++;
    return at;
}
