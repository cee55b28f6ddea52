/* For tests: the same test at every instruction set that this processor has. The level is chosen once a process, so
 * each runs in a child of its own, before anything has asked for it here. */
#ifndef HDR_TESTS_LEVELS_H
#define HDR_TESTS_LEVELS_H

#include "base/cpu.h"
#include "check.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct level_outcome {
    unsigned long passed, failed;
    bool missing; /* the processor has no such level */
    uint64_t digest;
} level_outcome;

static inline level_outcome run_at_level(hdr_cpu_level level, uint64_t (*test)(void)) {
    int ends[2], status = -1;
    level_outcome one = {.failed = 1};
    pid_t child = pipe(ends) == 0 ? fork() : -1;
    if (child == 0) {
        setenv("HDR_CPU", hdr_cpu_name(level), 1);
        check_passed = check_failed = 0; /* what the parent has counted so far */
        one = (level_outcome){.missing = hdr_cpu() != level};
        if (!one.missing) one.digest = test();
        one.passed = check_passed;
        one.failed = check_failed;
        _exit(write(ends[1], &one, sizeof one) != sizeof one);
    }
    if (child < 0) return one;
    close(ends[1]);
    if (read(ends[0], &one, sizeof one) != sizeof one) one = (level_outcome){.failed = 1};
    waitpid(child, &status, 0);
    close(ends[0]);
    one.failed += status != 0;
    return one;
}

/* test: checks, and returns a digest of what came out, which is to be the same at every level. */
static inline void check_at_levels(uint64_t (*test)(void)) {
    uint64_t first = 0;
    for (int l = HDR_CPU_C; l <= HDR_CPU_AVX512; l++) {
        const char *name = hdr_cpu_name((hdr_cpu_level)l);
        level_outcome one = run_at_level((hdr_cpu_level)l, test);
        check_passed += one.passed;
        check_failed += one.failed;
        if (one.failed) fprintf(stderr, "%lu failed at level %s\n", one.failed, name);
        if (l == HDR_CPU_C) first = one.digest;
        if (one.missing)
            CHECK_SKIP("this processor has no %s", name);
        else
            CHECK(one.digest == first, "%s gives something else than plain C", name);
    }
}

#endif
