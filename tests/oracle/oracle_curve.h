/* For the oracle: SPEC's formulas, each written once. Included twice by oracle_chain.h, with REAL the kind of number
 * and OF(name) its operations: no guard. A step's facts are wide numbers in either case: they are 10^8 times closer to
 * the real ones than the 1e-9 of a code that SPEC excuses. */

/* Y = 0.2126 R + 0.7152 G + 0.0722 B, or the Y row of the file's own primaries. Over 10000, so that R = G = B = Y
 * exactly. */
static REAL OF(luminance)(const oracle_weights *weights, int planes, const REAL c[3]) {
    static const oracle_number rec709[3] = {{"2126", 2126}, {"7152", 7152}, {"722", 722}};
    if (planes == 1) return c[0];
    REAL sum = OF(from)(0);
    for (int i = 0; i < 3; i++) {
        REAL weight = weights->rec709 ? OF(number)(rec709[i]) : OF(from)(weights->row[i]);
        sum = OF(add)(sum, OF(multiply)(weight, c[i]));
    }
    return weights->rec709 ? OF(divide)(sum, OF(number)(NUMBER(10000.))) : sum;
}

static REAL OF(larger)(REAL a, REAL b) {
    return OF(compare)(a, b) >= 0 ? a : b;
}

static REAL OF(smaller)(REAL a, REAL b) {
    return OF(compare)(a, b) <= 0 ? a : b;
}

static bool OF(positive)(REAL a) {
    return OF(compare)(a, OF(from)(0)) > 0;
}

static REAL OF(within)(REAL value, long double low, long double high) {
    return OF(smaller)(OF(larger)(value, OF(from)(low)), OF(from)(high));
}

/* k as typed, or 1/Yavg. */
static REAL OF(factor)(const oracle_step *step) {
    if (step->k.text) return OF(number)(step->k);
    return OF(divide)(OF(from)(1), OF(from)(step->log_average));
}

/* log: Ld = ln(1 + kY) / ln(1 + k Ymax). */
static REAL OF(log_shifted)(const oracle_step *step, REAL y) {
    REAL k = OF(factor)(step);
    REAL whole = OF(ln_one_plus)(OF(multiply)(k, OF(from)(step->max_luminance)));
    return OF(divide)(OF(ln_one_plus)(OF(multiply)(k, y)), whole);
}

/* log --mode range: Ld = (log10 Y - lo) / (hi - lo), clamped to [0,1]; hi = lo: 1 where log10 Y >= lo, else 0. */
static REAL OF(log_range)(const oracle_step *step, REAL y) {
    REAL low_luminance = OF(from)(step->low_luminance);
    if (step->low_luminance == step->high_luminance) /* Y rounded as lo is: hdr-log(1) says so */
        return OF(from)((float)OF(to)(y) >= step->low_luminance);
    REAL low = OF(log10)(low_luminance), high = OF(log10)(OF(from)(step->high_luminance));
    return OF(within)(OF(divide)(OF(subtract)(OF(log10)(y), low), OF(subtract)(high, low)), 0, 1);
}

/* exp: Ld = 1 - exp(-kY). */
static REAL OF(exponential)(const oracle_step *step, REAL y) {
    REAL exponent = OF(subtract)(OF(from)(0), OF(multiply)(OF(factor)(step), y));
    return OF(subtract)(OF(from)(0), OF(exp_minus_one)(exponent));
}

/* reinhard's key: as typed, or estimated. */
static REAL OF(key)(const oracle_step *step) {
    return step->estimated_key > 0 ? OF(from)(step->estimated_key) : OF(number)(step->key);
}

/* L = key Y / Yavg. */
static REAL OF(scaled)(const oracle_step *step, REAL y) {
    return OF(divide)(OF(multiply)(OF(key)(step), y), OF(from)(step->log_average));
}

/* reinhard: Ld = L (1 + L / white^2) / (1 + L); white inf: L / (1 + L). */
static REAL OF(photographic)(const oracle_step *step, REAL y) {
    const REAL one = OF(from)(1), l = OF(scaled)(step, y), simple = OF(divide)(l, OF(add)(one, l));
    if (step->white_is == ORACLE_WHITE_NONE) return simple;
    REAL white = step->white_is == ORACLE_WHITE_LARGEST ? OF(scaled)(step, OF(from)(step->max_luminance))
                 : step->white_is == ORACLE_WHITE_TYPED ? OF(number)(step->white)
                                                        : OF(from)(step->estimated_white);
    return OF(multiply)(simple, OF(add)(one, OF(divide)(OF(divide)(l, white), white)));
}

/* reinhard --local: Ld = L / (1 + V_m). */
static REAL OF(dodged)(const oracle_step *step, size_t pixel, REAL y) {
    REAL surround = OF(scaled)(step, OF(from)(step->local->surround[pixel]));
    return OF(divide)(OF(scaled)(step, y), OF(add)(OF(from)(1), surround));
}

static REAL OF(tone_curve)(const oracle_step *step, size_t pixel, REAL y) {
    if (step->verb == ORACLE_EXP) return OF(exponential)(step, y);
    if (step->verb == ORACLE_REINHARD) return step->local ? OF(dodged)(step, pixel, y) : OF(photographic)(step, y);
    return step->mode == ORACLE_RANGE ? OF(log_range)(step, y) : OF(log_shifted)(step, y);
}

/* C' = C (Ld/Y), or max(C/Y, 0)^s Ld with 0^0 = 1 (which powl and mpfr_pow both say). */
static void OF(keep_chromaticity)(const oracle_step *step, int planes, size_t pixel, REAL y, REAL c[3]) {
    REAL display = OF(tone_curve)(step, pixel, y);
    for (int i = 0; i < planes; i++) {
        REAL ratio = OF(divide)(c[i], y);
        if (step->saturation.value != 1)
            ratio = OF(power)(OF(larger)(ratio, OF(from)(0)), OF(number)(step->saturation));
        c[i] = OF(multiply)(ratio, display);
    }
}

static void OF(tone_map)(const oracle_step *step, int planes, size_t pixel, REAL c[3]) {
    REAL zero = OF(from)(0);
    if (step->per_channel && step->any_lit) {
        for (int i = 0; i < planes; i++)
            c[i] = OF(positive)(c[i]) ? OF(tone_curve)(step, pixel, c[i]) : zero;
        return;
    }
    REAL y = OF(luminance)(&step->weights, planes, c);
    if (step->any_lit && OF(positive)(y)) {
        OF(keep_chromaticity)(step, planes, pixel, y, c);
        return;
    }
    for (int i = 0; i < planes; i++)
        c[i] = zero;
}

/* log --mode literal: ln C, C floored at the smallest positive component; no positive component: 0. */
static REAL OF(log_literal)(const oracle_step *step, REAL c) {
    if (!(step->smallest_positive > 0)) return OF(from)(0);
    return OF(ln)(OF(larger)(c, OF(from)(step->smallest_positive)));
}

/* expose: C 2^ev; --auto: ev = log2(0.18 / Yavg); nothing lit: as it is. */
static REAL OF(expose)(const oracle_step *step, REAL c) {
    if (!step->automatic) return OF(multiply)(c, OF(exp2)(OF(number)(step->ev)));
    if (!step->any_lit) return c;
    return OF(multiply)(c, OF(divide)(OF(number)(NUMBER(0.18)), OF(from)(step->log_average)));
}

/* gamma: max(C,0)^(1/g), --decode: max(C,0)^g. */
static REAL OF(gamma)(const oracle_step *step, REAL c) {
    REAL exponent = OF(number)(step->exponent);
    if (!step->decode) exponent = OF(divide)(OF(from)(1), exponent);
    return OF(power)(OF(larger)(c, OF(from)(0)), exponent);
}

/* IEC 61966-2-1: 12.92 C up to 0.0031308, 1.055 C^(1/2.4) - 0.055 above. */
static REAL OF(srgb_encode)(REAL c) {
    if (OF(compare)(c, OF(number)(NUMBER(0.0031308))) <= 0) return OF(multiply)(OF(number)(NUMBER(12.92)), c);
    REAL power = OF(power)(c, OF(divide)(OF(from)(1), OF(number)(NUMBER(2.4))));
    return OF(subtract)(OF(multiply)(OF(number)(NUMBER(1.055)), power), OF(number)(NUMBER(0.055)));
}

/* IEC 61966-2-1: C / 12.92 up to 0.04045, ((C + 0.055) / 1.055)^2.4 above. */
static REAL OF(srgb_decode)(REAL c) {
    if (OF(compare)(c, OF(number)(NUMBER(0.04045))) <= 0) return OF(divide)(c, OF(number)(NUMBER(12.92)));
    REAL base = OF(divide)(OF(add)(c, OF(number)(NUMBER(0.055))), OF(number)(NUMBER(1.055)));
    return OF(power)(base, OF(number)(NUMBER(2.4)));
}

/* BT.709: 4.5 C below 0.018, 1.099 C^0.45 - 0.099 from there on. */
static REAL OF(rec709_encode)(REAL c) {
    if (OF(compare)(c, OF(number)(NUMBER(0.018))) < 0) return OF(multiply)(OF(number)(NUMBER(4.5)), c);
    REAL power = OF(power)(c, OF(number)(NUMBER(0.45)));
    return OF(subtract)(OF(multiply)(OF(number)(NUMBER(1.099)), power), OF(number)(NUMBER(0.099)));
}

/* BT.709: C / 4.5 below 0.081, ((C + 0.099) / 1.099)^(1/0.45) from there on. */
static REAL OF(rec709_decode)(REAL c) {
    if (OF(compare)(c, OF(number)(NUMBER(0.081))) < 0) return OF(divide)(c, OF(number)(NUMBER(4.5)));
    REAL base = OF(divide)(OF(add)(c, OF(number)(NUMBER(0.099))), OF(number)(NUMBER(1.099)));
    return OF(power)(base, OF(divide)(OF(from)(1), OF(number)(NUMBER(0.45))));
}

/* ST 2084's m1, m2, c1, c2, c3: decimals that are exact. */
static const oracle_number OF(pq)[5] = {{"0.1593017578125", 0.1593017578125L},
                                        {"78.84375", 78.84375L},
                                        {"0.8359375", 0.8359375L},
                                        {"18.8515625", 18.8515625L},
                                        {"18.6875", 18.6875L}};

/* ST 2084: y = (C nits / 10000)^m1, V = ((c1 + c2 y) / (1 + c3 y))^m2; negative C: 0. */
static REAL OF(pq_encode)(const oracle_step *step, REAL c) {
    REAL light = OF(multiply)(OF(larger)(c, OF(from)(0)), OF(number)(step->nits));
    REAL y = OF(power)(OF(divide)(light, OF(from)(10000)), OF(number)(OF(pq)[0]));
    REAL above = OF(add)(OF(number)(OF(pq)[2]), OF(multiply)(OF(number)(OF(pq)[3]), y));
    REAL below = OF(add)(OF(from)(1), OF(multiply)(OF(number)(OF(pq)[4]), y));
    return OF(power)(OF(divide)(above, below), OF(number)(OF(pq)[1]));
}

/* ST 2084: 10000 (max(V^(1/m2) - c1, 0) / (c2 - c3 V^(1/m2)))^(1/m1) / nits, V clamped to [0,1]. */
static REAL OF(pq_decode)(const oracle_step *step, REAL v) {
    const REAL one = OF(from)(1);
    REAL root = OF(power)(OF(within)(v, 0, 1), OF(divide)(one, OF(number)(OF(pq)[1])));
    REAL above = OF(larger)(OF(subtract)(root, OF(number)(OF(pq)[2])), OF(from)(0));
    REAL below = OF(subtract)(OF(number)(OF(pq)[3]), OF(multiply)(OF(number)(OF(pq)[4]), root));
    REAL whole = OF(power)(OF(divide)(above, below), OF(divide)(one, OF(number)(OF(pq)[0])));
    return OF(divide)(OF(multiply)(whole, OF(from)(10000)), OF(number)(step->nits));
}

/* BT.2100: a, b = 1 - 4a, c = 0.5 - a ln(4a). */
static void OF(hlg_constants)(REAL *a, REAL *b, REAL *c) {
    *a = OF(number)(NUMBER(0.17883277));
    REAL four = OF(multiply)(OF(from)(4), *a);
    *b = OF(subtract)(OF(from)(1), four);
    *c = OF(subtract)(OF(from)(0.5L), OF(multiply)(*a, OF(ln)(four)));
}

/* HLG: sqrt(3C) up to 1/12, a ln(12C - b) + c above; negative C: 0. */
static REAL OF(hlg_encode)(REAL light) {
    REAL a, b, c, twelve = OF(multiply)(OF(from)(12), light);
    if (!OF(positive)(light)) return OF(from)(0);
    if (OF(compare)(twelve, OF(from)(1)) <= 0) return OF(power)(OF(multiply)(OF(from)(3), light), OF(from)(0.5L));
    OF(hlg_constants)(&a, &b, &c);
    return OF(add)(OF(multiply)(a, OF(ln)(OF(subtract)(twelve, b))), c);
}

/* HLG: V^2 / 3 up to 1/2, (exp((V - c) / a) + b) / 12 above; negative V: 0. */
static REAL OF(hlg_decode)(REAL v) {
    REAL a, b, c;
    if (!OF(positive)(v)) return OF(from)(0);
    if (OF(compare)(v, OF(from)(0.5L)) <= 0) return OF(divide)(OF(multiply)(v, v), OF(from)(3));
    OF(hlg_constants)(&a, &b, &c);
    REAL curved = OF(exp_minus_one)(OF(divide)(OF(subtract)(v, c), a));
    return OF(divide)(OF(add)(curved, OF(add)(OF(from)(1), b)), OF(from)(12));
}

/* The encoding verbs. */
static REAL OF(encoding)(const oracle_step *step, REAL c) {
    switch (step->verb) {
    case ORACLE_GAMMA:
        return OF(gamma)(step, c);
    case ORACLE_SRGB:
        return step->decode ? OF(srgb_decode)(c) : OF(srgb_encode)(c);
    case ORACLE_REC709:
        return step->decode ? OF(rec709_decode)(c) : OF(rec709_encode)(c);
    case ORACLE_PQ:
        return step->decode ? OF(pq_decode)(step, c) : OF(pq_encode)(step, c);
    default:
        return step->decode ? OF(hlg_decode)(c) : OF(hlg_encode)(c);
    }
}

/* quantise: code = floor(v (2^b - 1) + 1/2), v clamped to [0,1]. Tells how far v lies from the boundary between two
 * codes, in codes. */
static long OF(code)(REAL value, int bits, long double *distance) {
    REAL largest = OF(from)((long double)((1L << bits) - 1));
    REAL shifted = OF(add)(OF(multiply)(OF(within)(value, 0, 1), largest), OF(from)(0.5L));
    REAL floored = OF(floor)(shifted);
    long double above = OF(to)(OF(subtract)(shifted, floored));
    *distance = above < 0.5L ? above : 1 - above;
    return (long)OF(to)(floored);
}

static REAL OF(quantise)(REAL value, int bits, long double *distance) {
    long code = OF(code)(value, bits, distance);
    return OF(divide)(OF(from)((long double)code), OF(from)((long double)((1L << bits) - 1)));
}

static void OF(convert)(const oracle_step *step, REAL c[3]) {
    REAL from[3] = {c[0], c[1], c[2]};
    for (int i = 0; i < 3; i++) {
        c[i] = OF(from)(0);
        for (int j = 0; j < 3; j++)
            c[i] = OF(add)(c[i], OF(multiply)(OF(from)(step->matrix[i][j]), from[j]));
    }
}

/* Steps whose formula sees one component at a time. */
static REAL OF(component)(const oracle_step *step, REAL c, long double *distance) {
    switch (step->verb) {
    case ORACLE_DIVMAX:
        return step->maximum > 0 ? OF(divide)(c, OF(from)(step->maximum)) : c;
    case ORACLE_CLAMP:
        return OF(smaller)(OF(larger)(c, OF(number)(step->low)), OF(number)(step->high));
    case ORACLE_EXPOSE:
        return OF(expose)(step, c);
    case ORACLE_QUANTISE:
        return OF(quantise)(c, step->bits, distance);
    case ORACLE_LOG:
        return OF(log_literal)(step, c);
    default:
        return OF(encoding)(step, c);
    }
}

/* log --mode range with hi = lo jumps from 0 to 1 where Y = lo: there the last bit of a sum in double decides, so that
 * a colour within its reach is excused. Not a grey, whose Y is its value. */
static bool OF(at_jump)(const oracle_step *step, int planes, const REAL c[3]) {
    if (step->verb != ORACLE_LOG || step->mode != ORACLE_RANGE || step->low_luminance != step->high_luminance)
        return false;
    if (planes == 1 || (!OF(compare)(c[0], c[1]) && !OF(compare)(c[0], c[2]))) return false;
    long double low = step->low_luminance, edge = (low + nextafterf((float)low, 0)) / 2; /* where Y rounds to lo */
    REAL difference = OF(subtract)(OF(luminance)(&step->weights, planes, c), OF(from)(edge));
    return fabsl(OF(to)(difference)) <= 0x1p-51L * low;
}

/* Takes a pixel through steps. Lowers *nearest to the distance of the boundary that a quantise among them came nearest
 * to. */
static void OF(walk)(const oracle_step *steps, int count, int planes, size_t pixel, REAL c[3], long double *nearest) {
    for (int s = 0; s < count; s++) {
        const oracle_step *step = &steps[s];
        bool tone = step->verb == ORACLE_EXP || step->verb == ORACLE_REINHARD ||
                    (step->verb == ORACLE_LOG && step->mode != ORACLE_LITERAL);
        if (OF(at_jump)(step, planes, c)) *nearest = 0;
        if (tone)
            OF(tone_map)(step, planes, pixel, c);
        else if (step->verb == ORACLE_CONVERT)
            OF(convert)(step, c);
        for (int i = 0; i < planes; i++) {
            long double distance = 1;
            if (!tone && step->verb != ORACLE_CONVERT) c[i] = OF(component)(step, c[i], &distance);
            if (distance < *nearest && !(distance == 0 && step->no_excuse)) *nearest = distance;
            c[i] = OF(within)(c[i], -(long double)FLT_MAX, FLT_MAX); /* beyond float: held at the largest float */
        }
    }
}

/* A pixel as it is read: straight colour, divided by alpha where that is above 0. */
static void OF(read)(const oracle_picture *picture, size_t pixel, REAL c[3]) {
    float alpha = picture->plane[3] ? picture->plane[3][pixel] : 1;
    for (int i = 0; i < picture->planes; i++) {
        c[i] = OF(from)(picture->plane[i][pixel]);
        if (alpha > 0 && alpha != 1) c[i] = OF(divide)(c[i], OF(from)(alpha));
    }
}
