/* Structural similarity. Wang, Bovik, Sheikh and Simoncelli, Image Quality Assessment: From Error Visibility to
 * Structural Similarity, IEEE Transactions on Image Processing 13(4), 2004: windows of 11 x 11 pixels, weighted by a
 * Gaussian of standard deviation 1.5, K1 = 0.01, K2 = 0.03, L = 1; the mean over all windows that lie in the picture.
 */
#include "base/pool.h"
#include "chain/chain.h"
#include "kernel/real.h"
#include "measure/view.h"

#include <stdlib.h>

enum { SIDE = 11, HALF = SIDE / 2 };

/* What of a picture is compared: its luma, Y' = 0.2126 R' + 0.7152 G' + 0.0722 B'. */
typedef struct luma {
    int width, height;
    double *value;
} luma;

struct hdr_structure {
    const hdr_chain *chain;
    hdr_input *reference;
    luma luma; /* the reference's */
};

static hdr_status make_luma(const hdr_chain *like, hdr_input *input, luma *to, hdr_error *err) {
    hdr_output *output = hdr_view_pixels(like, input, HDR_VIEW_ENCODED, err);
    if (!output) return err->status;
    const hdr_planes *pixels = hdr_output_pixels(output);
    size_t count = (size_t)pixels->width * (size_t)pixels->height;
    const float *const *c = pixels->plane;
    *to = (luma){pixels->width, pixels->height, hdr_alloc(count, sizeof *to->value)};
    for (size_t i = 0; to->value && i < count; i++)
        to->value[i] = pixels->planes == 1
                           ? c[0][i]
                           : 0.2126 * (double)c[0][i] + 0.7152 * (double)c[1][i] + 0.0722 * (double)c[2][i];
    hdr_output_free(output);
    return to->value ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
}

/* ---- Windows ---- */

typedef struct comparing {
    const luma *x, *y;
    double weight[SIDE];
    double *sums; /* of each row of windows */
} comparing;

/* Means over a window: of x, y, x^2, y^2 and xy. */
enum { OF_X, OF_Y, OF_XX, OF_YY, OF_XY, MEANS };

static double similarity(const double mean[MEANS]) {
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    double xx = mean[OF_X] * mean[OF_X], yy = mean[OF_Y] * mean[OF_Y], xy = mean[OF_X] * mean[OF_Y];
    return (2 * xy + c1) * (2 * (mean[OF_XY] - xy) + c2) /
           ((xx + yy + c1) * ((mean[OF_XX] - xx) + (mean[OF_YY] - yy) + c2));
}

/* A row of windows: first down each column of pixels, then across. */
static hdr_status compare_row(void *context, int row, int thread, hdr_error *err) {
    (void)thread;
    comparing *c = context;
    size_t width = (size_t)c->x->width;
    double(*column)[MEANS] = hdr_alloc(width, sizeof *column);
    if (!column) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int k = 0; k < SIDE; k++)
        for (size_t i = 0; i < width; i++) {
            double x = c->x->value[((size_t)row + (size_t)k) * width + i];
            double y = c->y->value[((size_t)row + (size_t)k) * width + i];
            column[i][OF_X] += c->weight[k] * x;
            column[i][OF_Y] += c->weight[k] * y;
            column[i][OF_XX] += c->weight[k] * (x * x);
            column[i][OF_YY] += c->weight[k] * (y * y);
            column[i][OF_XY] += c->weight[k] * (x * y);
        }
    for (size_t i = 0; i + SIDE <= width; i++) {
        double mean[MEANS] = {0};
        for (size_t k = 0; k < SIDE; k++)
            for (int m = 0; m < MEANS; m++)
                mean[m] += c->weight[k] * column[i + k][m];
        c->sums[row] += similarity(mean);
    }
    free(column);
    return HDR_OK;
}

/* Both have one form. */
static hdr_status compare(comparing *c, int threads, double *ssim, hdr_error *err) {
    double sum = 0;
    for (int k = 0; k < SIDE; k++)
        sum += c->weight[k] = hdr_exp(-0.5 * (k - HALF) * (k - HALF) / (1.5 * 1.5));
    for (int k = 0; k < SIDE; k++)
        c->weight[k] /= sum;
    int rows = c->x->height - SIDE + 1, columns = c->x->width - SIDE + 1;
    c->sums = hdr_alloc((size_t)rows, sizeof *c->sums);
    hdr_pool *pool = c->sums ? hdr_pool_new(threads, err) : NULL;
    if (!c->sums) hdr_fail(err, HDR_INTERNAL, "out of memory");
    hdr_status status = pool ? hdr_pool_run(pool, rows, compare_row, c, err) : HDR_INTERNAL;
    sum = 0;
    for (int row = 0; row < rows && status == HDR_OK; row++)
        sum += c->sums[row];
    *ssim = sum / ((double)rows * columns);
    hdr_pool_free(pool);
    free(c->sums);
    return status;
}

/* ---- In all ---- */

hdr_structure *hdr_structure_new(const hdr_chain *chain, hdr_input *reference, hdr_error *err) {
    hdr_error unheard = {0};
    if (!err) err = &unheard;
    hdr_structure *structure = hdr_alloc(1, sizeof *structure);
    if (!structure) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    *structure = (hdr_structure){.chain = chain, .reference = reference};
    hdr_status status = make_luma(chain, reference, &structure->luma, err);
    if (status == HDR_OK && (structure->luma.width < SIDE || structure->luma.height < SIDE))
        status = hdr_fail(err, HDR_BAD_DATA, "%s: structural similarity needs %d x %d pixels, and there are %d x %d",
                          hdr_input_name(reference), SIDE, SIDE, structure->luma.width, structure->luma.height);
    if (status == HDR_OK) return structure;
    hdr_structure_free(structure);
    return NULL;
}

hdr_status hdr_structure_compare(const hdr_structure *structure, hdr_input *test, double *ssim, hdr_error *err) {
    hdr_error unheard = {0};
    if (!err) err = &unheard;
    luma luma = {0};
    hdr_status status = hdr_check_alike(structure->chain, test, structure->reference, err);
    if (status == HDR_OK) status = make_luma(structure->chain, test, &luma, err);
    comparing c = {.x = &luma, .y = &structure->luma};
    if (status == HDR_OK) status = compare(&c, hdr_chain_settings(structure->chain)->threads, ssim, err);
    free(luma.value);
    return status;
}

void hdr_structure_free(hdr_structure *structure) {
    if (!structure) return;
    free(structure->luma.value);
    free(structure);
}
