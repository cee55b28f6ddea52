/* Structural similarity. Wang, Bovik, Sheikh and Simoncelli, Image Quality Assessment: From Error Visibility to
 * Structural Similarity, IEEE Transactions on Image Processing 13(4), 2004: windows of 11 x 11 pixels, weighted by a
 * Gaussian of standard deviation 1.5, K1 = 0.01, K2 = 0.03, L = 1; the mean over all windows that lie in the picture.
 */
#include "base/pool.h"
#include "chain/chain.h"
#include "io/forms.h"
#include "kernel/real.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 11, HALF = SIDE / 2 };

/* What of a picture is compared: its luma, Y' = 0.2126 R' + 0.7152 G' + 0.0722 B', rows from below. */
typedef struct luma {
    int width, height;
    double *value;
} luma;

/* ---- Luma ---- */

/* The chain that makes codes of the picture before they are rounded: what is linear is encoded by sRGB. */
static hdr_chain *encoding_chain(const hdr_chain *like, const hdr_picture *picture, hdr_error *err) {
    static const char *const clamp[] = {"clamp"}, *const srgb[] = {"srgb"}, *const pfm[] = {"pfm", "-q"};
    hdr_chain *chain = hdr_chain_new_like(like, err);
    bool linear = strcmp(picture->state, "linear") == 0;
    hdr_status status = chain ? hdr_chain_add(chain, clamp, 1, err) : HDR_INTERNAL;
    if (status == HDR_OK && linear) status = hdr_chain_add(chain, srgb, 1, err);
    if (status == HDR_OK) status = hdr_chain_add(chain, pfm, hdr_chain_settings(like)->quiet ? 1 : 2, err);
    if (status == HDR_OK) chain->common.window = HDR_WINDOW_DATA;
    if (status == HDR_OK) return chain;
    hdr_chain_free(chain);
    return NULL;
}

/* Of a PFM that the library has written. */
static hdr_status read_luma(const unsigned char *bytes, size_t size, luma *to, hdr_error *err) {
    char kind = 0, head[64] = "";
    memcpy(head, bytes, size < sizeof head - 1 ? size : sizeof head - 1);
    if (sscanf(head, "P%c %d %d", &kind, &to->width, &to->height) != 3)
        return hdr_fail(err, HDR_INTERNAL, "the encoded picture cannot be read back");
    size_t pixels = (size_t)to->width * (size_t)to->height, planes = kind == 'F' ? 3 : 1;
    const unsigned char *numbers = bytes + size - pixels * planes * sizeof(float);
    to->value = hdr_alloc(pixels, sizeof *to->value);
    if (!to->value) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (size_t i = 0; i < pixels; i++) {
        float c[3];
        memcpy(c, numbers + i * planes * sizeof(float), planes * sizeof(float));
        to->value[i] = planes == 1 ? c[0] : 0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2];
    }
    return HDR_OK;
}

static hdr_status make_luma(const hdr_chain *like, hdr_input *input, luma *to, hdr_error *err) {
    hdr_picture picture;
    hdr_status status = hdr_input_picture(input, like, &picture, err);
    hdr_chain *chain = status == HDR_OK ? encoding_chain(like, &picture, err) : NULL;
    hdr_output *output = chain ? hdr_output_memory(err) : NULL;
    if (status == HDR_OK) status = output ? hdr_chain_run(chain, input, output, NULL, err) : HDR_INTERNAL;
    size_t size = 0;
    const unsigned char *bytes = status == HDR_OK ? hdr_output_bytes(output, &size) : NULL;
    if (status == HDR_OK) status = read_luma(bytes, size, to, err);
    hdr_output_free(output);
    hdr_chain_free(chain);
    return status;
}

/* ---- Windows ---- */

typedef struct comparing {
    luma x, y;
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
    size_t width = (size_t)c->x.width;
    double(*column)[MEANS] = hdr_alloc(width, sizeof *column);
    if (!column) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int k = 0; k < SIDE; k++)
        for (size_t i = 0; i < width; i++) {
            double x = c->x.value[((size_t)row + (size_t)k) * width + i];
            double y = c->y.value[((size_t)row + (size_t)k) * width + i];
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

static hdr_status compare(comparing *c, int threads, double *ssim, hdr_error *err) {
    if (c->x.width != c->y.width || c->x.height != c->y.height)
        return hdr_fail(err, HDR_BAD_DATA, "the pictures differ in size");
    if (c->x.width < SIDE || c->x.height < SIDE)
        return hdr_fail(err, HDR_BAD_DATA, "structural similarity needs %d x %d pixels", SIDE, SIDE);
    double sum = 0;
    for (int k = 0; k < SIDE; k++)
        sum += c->weight[k] = hdr_exp(-0.5 * (k - HALF) * (k - HALF) / (1.5 * 1.5));
    for (int k = 0; k < SIDE; k++)
        c->weight[k] /= sum;
    int rows = c->x.height - SIDE + 1, columns = c->x.width - SIDE + 1;
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

hdr_status hdr_compare_structure(const hdr_chain *chain, hdr_input *test, hdr_input *reference, double *ssim,
                                 hdr_error *err) {
    hdr_error unheard = {0};
    if (!err) err = &unheard;
    comparing c = {.x = {.width = 0}};
    hdr_reading reading = hdr_chain_reading(chain);
    hdr_source **alike = hdr_open_alike(2, (hdr_input *const[]){test, reference}, &reading, false, err);
    if (!alike) return err->status;
    hdr_close_alike(2, alike);
    hdr_status status = make_luma(chain, test, &c.x, err);
    if (status == HDR_OK) status = make_luma(chain, reference, &c.y, err);
    if (status == HDR_OK) status = compare(&c, hdr_chain_settings(chain)->threads, ssim, err);
    free(c.x.value);
    free(c.y.value);
    return status;
}
