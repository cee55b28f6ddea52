/* Counts checks. CHECK(condition, format, ...) goes on after a failure, so one run shows them all (up to a limit, so
 * that a broken function does not flood the log); check_done prints the one line the test runner reads. */
#ifndef HDR_TESTS_CHECK_H
#define HDR_TESTS_CHECK_H

#include <stdio.h>

enum { CHECK_FAILURES_SHOWN = 20 };

static unsigned long check_passed, check_failed, check_skipped;

#define CHECK(condition, ...)                                                                                          \
    do {                                                                                                               \
        if (condition) {                                                                                               \
            check_passed++;                                                                                            \
        } else if (check_failed++ < CHECK_FAILURES_SHOWN) {                                                            \
            fprintf(stderr, "%s:%d: ", __FILE__, __LINE__);                                                            \
            fprintf(stderr, __VA_ARGS__);                                                                              \
            fputc('\n', stderr);                                                                                       \
        }                                                                                                              \
    } while (0)

/* What cannot be checked here, and why: counted, so that nobody takes it for passed. */
#define CHECK_SKIP(...)                                                                                                \
    do {                                                                                                               \
        check_skipped++;                                                                                               \
        fprintf(stderr, "skipped: ");                                                                                  \
        fprintf(stderr, __VA_ARGS__);                                                                                  \
        fputc('\n', stderr);                                                                                           \
    } while (0)

static inline int check_done(const char *program) {
    printf("%s: %lu passed, %lu failed", program, check_passed, check_failed);
    if (check_skipped) printf(", %lu skipped", check_skipped);
    putchar('\n');
    return check_failed != 0;
}

#endif
