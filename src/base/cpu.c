/* The choice of instruction set: what the processor and the system have, held down by HDR_CPU. */
#include "base/cpu.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#if defined(HDR_X86)
#include <cpuid.h>
#endif

static const char *const level_names[] = {"c", "sse2", "avx2", "avx512"};

const char *hdr_cpu_name(hdr_cpu_level level) {
    return level_names[level];
}

#if defined(HDR_X86)
/* Not every compiler knows "f16c" by name. */
static bool has_f16c(void) {
    unsigned a, b, c, d;
    return __get_cpuid(1, &a, &b, &c, &d) && (c & bit_F16C) != 0;
}

/* The compiler's own question also asks whether the system saves the wide registers. */
static hdr_cpu_level processor_level(void) {
    __builtin_cpu_init();
    bool avx2 =
        __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2") && has_f16c();
    if (!avx2) return HDR_CPU_SSE2;
    bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
    return avx512 ? HDR_CPU_AVX512 : HDR_CPU_AVX2;
}
#else
static hdr_cpu_level processor_level(void) {
    return HDR_CPU_C;
}
#endif

static hdr_cpu_level decide(void) {
    hdr_cpu_level level = processor_level();
    const char *held = getenv("HDR_CPU");
    if (held)
        for (int i = HDR_CPU_C; i < (int)level; i++)
            if (strcmp(held, level_names[i]) == 0) return (hdr_cpu_level)i;
    return level;
}

hdr_cpu_level hdr_cpu(void) {
    /* Two threads that ask first come to the same answer, so it does not matter whose is kept. 0: not yet decided. */
    static atomic_int decided;
    int level = atomic_load_explicit(&decided, memory_order_relaxed);
    if (level == 0) {
        level = (int)decide() + 1;
        atomic_store_explicit(&decided, level, memory_order_relaxed);
    }
    return (hdr_cpu_level)(level - 1);
}
