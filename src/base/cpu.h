/* Which instruction set the kernels may use, and how one C source becomes one version for each of them. */
#ifndef HDR_CPU_H
#define HDR_CPU_H

/* The rungs of the ladder. HDR_CPU_C is the plain C as the compiler's baseline has it, with no intrinsics. */
typedef enum hdr_cpu_level { HDR_CPU_C, HDR_CPU_SSE2, HDR_CPU_AVX2, HDR_CPU_AVX512 } hdr_cpu_level;

/* The highest rung this processor has, held down by the environment's HDR_CPU (c, sse2, avx2 or avx512). Decided once.
 */
hdr_cpu_level hdr_cpu(void);
const char *hdr_cpu_name(hdr_cpu_level level);

#if defined(__x86_64__)
#define HDR_X86 1
#if defined(__clang__)
#define HDR_TARGET_AVX512 __attribute__((target("avx2,fma,f16c,bmi2,avx512f,avx512dq,avx512bw,avx512vl")))
#else
#define HDR_TARGET_AVX512                                                                                              \
    __attribute__((target("avx2,fma,f16c,bmi2,avx512f,avx512dq,avx512bw,avx512vl,prefer-vector-width=512")))
#endif
#define HDR_TARGET_AVX2 __attribute__((target("avx2,fma,f16c,bmi2")))
#endif

#define HDR_INLINE static inline __attribute__((always_inline))

/* HDR_VERSIONS(name, (parameters), (arguments)) defines void name(parameters), which runs name_body(arguments): a
 * function marked HDR_INLINE that stands above it (HDR_VERSIONS_IN(static, ...) for one file's own use), plain loops
 * that the compiler vectorises anew for each instruction set. The arithmetic is the same in each (contraction is off),
 * so the results are too, bit for bit. */
#if defined(HDR_X86)
#define HDR_VERSIONS_IN(storage, name, parameters, arguments)                                                          \
    HDR_TARGET_AVX512 static void name##_avx512 parameters {                                                           \
        name##_body arguments;                                                                                         \
    }                                                                                                                  \
    HDR_TARGET_AVX2 static void name##_avx2 parameters {                                                               \
        name##_body arguments;                                                                                         \
    }                                                                                                                  \
    static void name##_c parameters {                                                                                  \
        name##_body arguments;                                                                                         \
    }                                                                                                                  \
    storage void name parameters {                                                                                     \
        hdr_cpu_level level = hdr_cpu();                                                                               \
        if (level >= HDR_CPU_AVX512)                                                                                   \
            name##_avx512 arguments;                                                                                   \
        else if (level >= HDR_CPU_AVX2)                                                                                \
            name##_avx2 arguments;                                                                                     \
        else                                                                                                           \
            name##_c arguments;                                                                                        \
    }
#else
#define HDR_VERSIONS_IN(storage, name, parameters, arguments)                                                          \
    storage void name parameters {                                                                                     \
        name##_body arguments;                                                                                         \
    }
#endif
#define HDR_VERSIONS(name, parameters, arguments) HDR_VERSIONS_IN(, name, parameters, arguments)

#endif
