/* Checks src/kernel/real_float.h against the C library in long double. */
#include "check.h"
#include "kernel/real_float.h"

#include <math.h>
#include <string.h>

/* In units of the last place of the float next to the exact result. */
static double ulps_off(float x) {
    long double exact = expl(-(long double)x);
    int exponent;
    (void)frexpl(exact, &exponent);
    return (double)(fabsl((long double)hdr_exp_of_minus(x) - exact) / ldexpl(1, exponent - 24));
}

static void test_accuracy(void) {
    double worst = 0, at = 0;
    for (float x = 1e-9f; x < HDR_EXP_FLOAT_END; x = nextafterf(x * 1.000003f, INFINITY)) {
        double off = ulps_off(x);
        if (off > worst) worst = off, at = (double)x;
    }
    CHECK(worst > 0 && worst < 1.5, "%g ulp at %a", worst, at);
}

static void test_ends(void) {
    CHECK(hdr_exp_of_minus(0) == 1 && hdr_exp_of_minus(-0.0f) == 1, "of 0: %a", (double)hdr_exp_of_minus(0));
    CHECK(hdr_exp_of_minus(0x1p-149f) == 1, "of the smallest: %a", (double)hdr_exp_of_minus(0x1p-149f));
    CHECK(hdr_exp_of_minus(nextafterf(HDR_EXP_FLOAT_END, 0)) > 0, "in front of the end");
    CHECK(hdr_exp_of_minus(HDR_EXP_FLOAT_END) == 0 && hdr_exp_of_minus(0x1p127f) == 0 &&
              hdr_exp_of_minus(INFINITY) == 0,
          "from the end on");
}

int main(void) {
    test_accuracy();
    test_ends();
    return check_done("test_real_float");
}
