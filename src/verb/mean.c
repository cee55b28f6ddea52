/* The mean of independent renders, and how far they scatter. */
#include "base/cpu.h"
#include "verb/verb.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_GROUPS = 31 };

typedef struct mean_params {
    int show, robust;
    hdr_number groups;
    const char *weights;
} mean_params;

enum { SHOW_MEAN, SHOW_VARIANCE, SHOW_DEVIATION, SHOW_MEAN_VARIANCE, SHOW_MEAN_DEVIATION };
static const char *const shows[] = {"mean", "variance", "deviation", "mean-variance", "mean-deviation", NULL};
enum { ROBUST_NONE, ROBUST_MEDIAN_OF_MEANS };
static const char *const robusts[] = {"none", "median-of-means", NULL};

static const hdr_option options[] = {
    {.name = "show",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(mean_params, show),
     .metavar = "WHAT",
     .words = shows,
     .default_value = "mean",
     .help = "the mean; variance or standard deviation of one render; or those of the mean"},
    {.name = "weights",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(mean_params, weights),
     .metavar = "WEIGHTS",
     .default_value = "equal",
     .help = "W,W,...: a number above 0 for each file; from:ATTRIBUTE: that of its header; equal: all count alike"},
    {.name = "robust",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(mean_params, robust),
     .metavar = "HOW",
     .words = robusts,
     .default_value = "none",
     .help = "against fireflies, biased: the median of the means of --groups groups of renders"},
    {.name = "groups",
     .type = HDR_OPTION_INTEGER,
     .offset = offsetof(mean_params, groups),
     .metavar = "G",
     .min = 2,
     .max = MOST_GROUPS,
     .default_value = "5",
     .help = "of --robust: render number i belongs to group i modulo G"},
    {0}};

/* The number in front of *text, which is moved behind it and the comma. False: there is none above 0. */
static bool take_weight(const char **text, double *weight) {
    char digits[64];
    size_t length = strcspn(*text, ",");
    if (length >= sizeof digits) return false;
    memcpy(digits, *text, length);
    digits[length] = '\0';
    const char *end = hdr_read_number(digits, weight);
    if (!end || *end || !(*weight > 0 && *weight <= HDR_MOST_WEIGHT)) return false;
    *text += length;
    return true;
}

/* How many weights a text has, of which the first `room` are kept; -1: it is no list of them. */
static int read_weights(const char *text, double *weights, int room) {
    for (int count = 1;; count++, text++) {
        double weight;
        if (!take_weight(&text, &weight)) return -1;
        if (count <= room) weights[count - 1] = weight;
        if (!*text) return count;
    }
}

/* The attribute that tells the weights, or NULL. */
static const char *attribute_of(const mean_params *p) {
    static const char from[] = "from:";
    return strncmp(p->weights, from, strlen(from)) == 0 ? p->weights + strlen(from) : NULL;
}

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const mean_params *p = params;
    const char *attribute = attribute_of(p);
    bool equal = strcmp(p->weights, "equal") == 0;
    for (int i = 0; i < given->count; i++)
        if (!strcmp(given->given[i].option->name, "groups") && p->robust == ROBUST_NONE)
            return hdr_fail(err, HDR_USAGE, "--groups has no meaning without --robust median-of-means");
    if (attribute ? !*attribute : !equal && read_weights(p->weights, NULL, 0) < 0)
        return hdr_refuse_text(options, "weights", p->weights,
                               attribute ? "names no attribute" : "is no list of numbers above 0", err);
    if (!equal && (p->robust != ROBUST_NONE || p->show != SHOW_MEAN))
        return hdr_fail(err, HDR_USAGE, "--weights are for the plain mean alone");
    if (p->robust != ROBUST_NONE && p->show != SHOW_MEAN)
        return hdr_fail(err, HDR_USAGE, "--robust has a mean only, no %s", shows[p->show]);
    return HDR_OK;
}

/* ---- Moments ----
 * state: how many numbers there were, or the sum W of their weights, and their mean m; with a variance the sum M2 of
 * (x - m)^2, too. Welford, Note on a Method for Calculating Corrected Sums of Squares and Products, Technometrics 4(3),
 * 1962, and for numbers that count w times West, Updating Mean and Variance Estimates, Communications of the ACM 22(9),
 * 1979: with d = x - m,
 *     W := W + w    m := m + d w / W    M2 := M2 + d (x - m)    (M2: w is 1)
 * whose error does not grow with the mean, as that of the sum of squares does. */
enum { WEIGHT, MEAN, SQUARES, MEAN_SLOTS = 2, MOMENT_SLOTS };

/* squares: NULL where no variance is wanted. */
HDR_INLINE void add_body(const double *values, double weight, double *sum, double *mean, double *squares,
                         size_t count) {
    for (size_t i = 0; i < count; i++) {
        bool finite = values[i] - values[i] == 0;
        double difference = finite ? values[i] - mean[i] : 0;
        double more = finite ? sum[i] + weight : sum[i];
        double next = mean[i] + difference * weight / (more > 0 ? more : 1);
        if (squares) squares[i] += difference * (finite ? values[i] - next : 0);
        mean[i] = next;
        sum[i] = more;
    }
}

HDR_INLINE void add_to_mean_body(const double *values, double weight, double *state, size_t count) {
    add_body(values, weight, state + WEIGHT * HDR_STRIP, state + MEAN * HDR_STRIP, NULL, count);
}
HDR_VERSIONS_IN(static, add_to_mean, (const double *values, double weight, double *state, size_t count),
                (values, weight, state, count))

HDR_INLINE void add_to_moments_body(const double *values, double *state, size_t count) {
    add_body(values, 1, state + WEIGHT * HDR_STRIP, state + MEAN * HDR_STRIP, state + SQUARES * HDR_STRIP, count);
}
HDR_VERSIONS_IN(static, add_to_moments, (const double *values, double *state, size_t count), (values, state, count))

static void add_moments(const hdr_joining *joining, int picture, const double *values, double *state, size_t count) {
    (void)joining, (void)picture;
    add_to_moments(values, state, count);
}

/* Of what a number is made that no render has: NaN, which reading repairs and counts. */
static double show_moments(int show, double n, double squares) {
    if (n < 1) return NAN;
    double variance = n > 1 ? squares / (n - 1) : NAN;
    switch (show) {
    case SHOW_DEVIATION:
        return sqrt(variance);
    case SHOW_MEAN_VARIANCE:
        return variance / n;
    case SHOW_MEAN_DEVIATION:
        return sqrt(variance / n);
    default:
        return variance;
    }
}

static void end_moments(const hdr_joining *joining, const double *state, double *out, size_t count) {
    const mean_params *p = joining->params;
    for (size_t i = 0; i < count; i++)
        out[i] = show_moments(p->show, state[WEIGHT * HDR_STRIP + i], state[SQUARES * HDR_STRIP + i]);
}

/* ---- Means, and their median ----
 * state: weight and mean of each group; the plain mean is that of one group. Jerrum, Valiant and Vazirani, Theoretical
 * Computer Science 43, 1986; for renders Jung, Meyer and DeCoro, Robust Estimation of the Mean, 2015. */

static int groups_of(const hdr_joining *joining) {
    return joining->slots / MEAN_SLOTS;
}

static void add_to_group(const hdr_joining *joining, int picture, const double *values, double *state, size_t count) {
    size_t group = (size_t)(picture % groups_of(joining));
    add_to_mean(values, joining->weights ? joining->weights[picture] : 1, state + group * MEAN_SLOTS * HDR_STRIP,
                count);
}

/* Of at most MOST_GROUPS numbers, which are put in order; of an even number the mean of the two in the middle. */
static double median(double *value, int count) {
    for (int i = 1; i < count; i++)
        for (int j = i; j > 0 && value[j] < value[j - 1]; j--) {
            double larger = value[j - 1];
            value[j - 1] = value[j];
            value[j] = larger;
        }
    if (count == 0) return NAN;
    return count % 2 ? value[count / 2] : (value[count / 2 - 1] + value[count / 2]) / 2;
}

static void end_groups(const hdr_joining *joining, const double *state, double *out, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double means[MOST_GROUPS];
        int groups = 0;
        for (int g = 0; g < groups_of(joining); g++) {
            const double *group = state + (size_t)(g * MEAN_SLOTS) * HDR_STRIP;
            if (group[WEIGHT * HDR_STRIP + i] > 0) means[groups++] = group[MEAN * HDR_STRIP + i];
        }
        out[i] = median(means, groups);
    }
}

/* ---- The verb ---- */

/* One for each file. */
static hdr_status take_weights(const char *text, hdr_joining *joining, hdr_error *err) {
    joining->weights = hdr_alloc((size_t)joining->pictures, sizeof *joining->weights);
    if (!joining->weights) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    int count = read_weights(text, joining->weights, joining->pictures);
    if (count == joining->pictures) return HDR_OK;
    return hdr_fail(err, HDR_USAGE, "--weights has %d numbers, and there are %d files", count, joining->pictures);
}

/* What the result is: it is told in it. */
static void describe(const mean_params *p, int renders, int groups, char *text, size_t size) {
    static const char *const of[] = {"mean of", "variance of one of", "standard deviation of one of",
                                     "variance of the mean of", "standard deviation of the mean of"};
    char robust[60] = "";
    const char *weighted = strcmp(p->weights, "equal") != 0 ? "weighted " : "";
    if (p->robust != ROBUST_NONE)
        snprintf(robust, sizeof robust, ": the median of the means of %d groups, biased", groups);
    snprintf(text, size, "%s%s %d render%s%s", weighted, of[p->show], renders, renders == 1 ? "" : "s", robust);
}

static hdr_status join(const void *params, hdr_joining *joining, hdr_error *err) {
    const mean_params *p = params;
    bool plain = p->show == SHOW_MEAN;
    int groups = (int)p->groups.value < joining->pictures ? (int)p->groups.value : joining->pictures;
    if (!plain && joining->pictures < 2)
        return hdr_fail(err, HDR_USAGE, "one render has no %s: name several", shows[p->show]);
    joining->alpha = plain; /* how it scatters is no cover */
    joining->slots = !plain ? MOMENT_SLOTS : p->robust == ROBUST_NONE ? MEAN_SLOTS : groups * MEAN_SLOTS;
    joining->add = plain ? add_to_group : add_moments;
    joining->end = plain ? end_groups : end_moments;
    describe(p, joining->pictures, groups, joining->meaning, sizeof joining->meaning);
    joining->weights_from = attribute_of(p);
    bool listed = !joining->weights_from && strcmp(p->weights, "equal") != 0;
    return listed ? take_weights(p->weights, joining, err) : HDR_OK;
}

static const char *const examples[] = {"hdr mean -o OUT.exr IN.exr IN.exr",
                                       "hdr mean --weights 16,64 -o OUT.exr IN.exr IN.exr",
                                       "hdr mean --show mean-deviation -o OUT.exr IN.exr IN.exr IN.exr",
                                       "hdr mean then reinhard then png -o OUT.png IN.exr IN.exr", NULL};

const hdr_verb hdr_verb_mean = {
    .about =
        {.name = "mean",
         .summary = "average independent renders, or tell how they scatter",
         .details =
             "Begins a chain: makes one float picture of several renders of the same scene, which have to be "
             "independent: made with other random numbers each. They must agree in data window, channels and "
             "primaries; all else, such as the header's attributes, is the first one's.\n\n"
             "Each component is averaged as it is stored (colour associated with alpha), by Welford's method in "
             "double, in the order of the files, and rounded to float once. Of numbers of one sign, "
             "another order of the files changes no more than the last bit. Components that are NaN or infinite "
             "are left out, and counted on "
             "standard error. All files are read once, together, block by block: memory does not grow with "
             "their number, nor with their size but for the chunks that they are stored in: large tiles take more.\n\n"
             "--weights 16,64,64 is for renders of different length: each component is the sum of weight times "
             "number, divided by "
             "the weights' sum. --weights from:samplesPerPixel takes them from that attribute of each file's header, "
             "an "
             "int, a float, a double or a text. Several renderers write their number of samples there (pbrt under this "
             "name, Blender as cycles.ViewLayer.samples); 'hdr info' lists what a file has. Each must have it. In the "
             "header of the mean it becomes the sum, so that means can be averaged again.\n\n"
             "EXR that is written tells in its attribute hdrpipeMeaning what its numbers are: mean of 8 renders.\n\n"
             "--show variance is that of one render, M2 / (n - 1), and deviation its root, the standard "
             "deviation; mean-variance and mean-deviation are those of the mean of all n: variance / n, and its "
             "root. They need two renders (a component that only one has becomes 0), have no alpha, and hold no matter "
             "how bright a pixel is (sums of squares would lose "
             "1e6 +- 1e-3).\n\n"
             "--robust median-of-means parts the renders in --groups groups, averages each and takes the median: "
             "a firefly in one render touches one group alone. It is biased: where light comes in rare bright "
             "samples, as caustics do, it is too dark.",
         .examples = examples,
         .options = options,
         .kind = HDR_JOIN,
         .stays = true},
    .params_size = sizeof(mean_params),
    .check = check,
    .join = join,
};
