/* Differences to bytes and halves to pairs, in one pass.
 *
 * Done one after the other, the two steps read and write every byte twice. Both halves can be summed at the same time,
 * and so go out as pairs at once, if the sum that the second half starts from is known: the sum of all differences of
 * the first, a reduction that costs a tenth of a running sum. The two running sums are independent, so they also fill
 * each other's waits.
 *
 * With d[i] the stored byte, the byte is b[0] = d[0], b[i] = b[i-1] + d[i] - 128, all modulo 256. Where the text below
 * adds 128 instead of subtracting it, that is the same modulo 256; starting from b[-1] = 128 makes the first byte no
 * exception. */
#include "kernel/predictor.h"

#include <stdint.h>

#if defined(HDR_X86)
#include <immintrin.h>
#endif

enum { BIAS = 128 };

/* A running sum for each half, at pair number done. */
typedef struct pairs {
    const unsigned char *even, *odd; /* the halves: ceil(size/2) and floor(size/2) bytes */
    size_t count;                    /* whole pairs; an odd size leaves one even byte over */
    size_t done;
    uint8_t even_sum, odd_sum; /* the last byte of each half so far */
} pairs;

/* The remaining pairs and the last odd one out, in plain C. */
static void finish(pairs *p, size_t size, unsigned char *out) {
    uint8_t even = p->even_sum, odd = p->odd_sum;
    for (size_t i = p->done; i < p->count; i++) {
        even = (uint8_t)(even + p->even[i] + BIAS);
        odd = (uint8_t)(odd + p->odd[i] + BIAS);
        out[2 * i] = even;
        out[2 * i + 1] = odd;
    }
    if (size & 1) out[size - 1] = (uint8_t)(even + p->even[p->count] + BIAS);
}

/* total: the sum of the first half's stored bytes. */
static pairs start(const unsigned char *in, size_t size, uint8_t total) {
    size_t half = (size + 1) / 2;
    return (pairs){.even = in,
                   .odd = in + half,
                   .count = size / 2,
                   .even_sum = BIAS,
                   .odd_sum = (uint8_t)(BIAS + total + BIAS * (half & 1))};
}

static uint8_t sum_c(const unsigned char *in, size_t count) {
    uint8_t sum = 0;
    for (size_t i = 0; i < count; i++)
        sum = (uint8_t)(sum + in[i]);
    return sum;
}

static void undo_c(const unsigned char *in, size_t size, unsigned char *out) {
    pairs p = start(in, size, sum_c(in, (size + 1) / 2));
    finish(&p, size, out);
}

#if defined(HDR_X86)

static uint8_t sum_sse2(const unsigned char *in, size_t count) {
    __m128i sum = _mm_setzero_si128();
    size_t i = 0;
    for (; i + 16 <= count; i += 16)
        sum = _mm_add_epi64(sum, _mm_sad_epu8(_mm_loadu_si128((const __m128i *)(in + i)), _mm_setzero_si128()));
    int total = _mm_cvtsi128_si32(sum) + _mm_cvtsi128_si32(_mm_srli_si128(sum, 8));
    return (uint8_t)(total + sum_c(in + i, count - i));
}

/* Running sums within 16 bytes, in four doubling steps. */
HDR_INLINE __m128i running_sse2(__m128i d) {
    d = _mm_add_epi8(d, _mm_set1_epi8((char)BIAS));
    d = _mm_add_epi8(d, _mm_slli_si128(d, 1));
    d = _mm_add_epi8(d, _mm_slli_si128(d, 2));
    d = _mm_add_epi8(d, _mm_slli_si128(d, 4));
    return _mm_add_epi8(d, _mm_slli_si128(d, 8));
}

/* The last byte in all places. */
HDR_INLINE __m128i last_sse2(__m128i v) {
    v = _mm_unpackhi_epi8(v, v);
    v = _mm_shufflehi_epi16(v, 0xff);
    return _mm_shuffle_epi32(v, 0xff);
}

static void undo_sse2(const unsigned char *in, size_t size, unsigned char *out) {
    pairs p = start(in, size, sum_sse2(in, (size + 1) / 2));
    __m128i even_sum = _mm_set1_epi8((char)p.even_sum), odd_sum = _mm_set1_epi8((char)p.odd_sum);
    size_t i = 0;
    for (; i + 16 <= p.count; i += 16) {
        __m128i even = running_sse2(_mm_loadu_si128((const __m128i *)(p.even + i)));
        __m128i odd = running_sse2(_mm_loadu_si128((const __m128i *)(p.odd + i)));
        /* Only one addition is on the way from one round to the next. */
        __m128i even_last = last_sse2(even), odd_last = last_sse2(odd);
        even = _mm_add_epi8(even, even_sum);
        odd = _mm_add_epi8(odd, odd_sum);
        even_sum = _mm_add_epi8(even_sum, even_last);
        odd_sum = _mm_add_epi8(odd_sum, odd_last);
        _mm_storeu_si128((__m128i *)(out + 2 * i), _mm_unpacklo_epi8(even, odd));
        _mm_storeu_si128((__m128i *)(out + 2 * i + 16), _mm_unpackhi_epi8(even, odd));
    }
    p.done = i;
    p.even_sum = (uint8_t)_mm_cvtsi128_si32(even_sum);
    p.odd_sum = (uint8_t)_mm_cvtsi128_si32(odd_sum);
    finish(&p, size, out);
}

HDR_TARGET_AVX2 static uint8_t sum_avx2(const unsigned char *in, size_t count) {
    __m256i sum = _mm256_setzero_si256();
    size_t i = 0;
    for (; i + 32 <= count; i += 32)
        sum = _mm256_add_epi64(sum,
                               _mm256_sad_epu8(_mm256_loadu_si256((const __m256i *)(in + i)), _mm256_setzero_si256()));
    __m128i both = _mm_add_epi64(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
    int total = _mm_cvtsi128_si32(both) + _mm_cvtsi128_si32(_mm_srli_si128(both, 8));
    return (uint8_t)(total + sum_c(in + i, count - i));
}

/* Running sums within each 16 of 32 bytes, then the low sixteen's total added to the high. */
HDR_TARGET_AVX2 HDR_INLINE __m256i running_avx2(__m256i d) {
    d = _mm256_add_epi8(d, _mm256_set1_epi8((char)BIAS));
    d = _mm256_add_epi8(d, _mm256_slli_si256(d, 1));
    d = _mm256_add_epi8(d, _mm256_slli_si256(d, 2));
    d = _mm256_add_epi8(d, _mm256_slli_si256(d, 4));
    d = _mm256_add_epi8(d, _mm256_slli_si256(d, 8));
    __m256i totals = _mm256_shuffle_epi8(d, _mm256_set1_epi8(15));
    return _mm256_add_epi8(d, _mm256_permute2x128_si256(totals, totals, 0x08));
}

HDR_TARGET_AVX2 HDR_INLINE __m256i last_avx2(__m256i v) {
    v = _mm256_shuffle_epi8(v, _mm256_set1_epi8(15));
    return _mm256_permute2x128_si256(v, v, 0x11);
}

HDR_TARGET_AVX2 static void undo_avx2(const unsigned char *in, size_t size, unsigned char *out) {
    pairs p = start(in, size, sum_avx2(in, (size + 1) / 2));
    __m256i even_sum = _mm256_set1_epi8((char)p.even_sum), odd_sum = _mm256_set1_epi8((char)p.odd_sum);
    size_t i = 0;
    for (; i + 32 <= p.count; i += 32) {
        __m256i even = running_avx2(_mm256_loadu_si256((const __m256i *)(p.even + i)));
        __m256i odd = running_avx2(_mm256_loadu_si256((const __m256i *)(p.odd + i)));
        __m256i even_last = last_avx2(even), odd_last = last_avx2(odd);
        even = _mm256_add_epi8(even, even_sum);
        odd = _mm256_add_epi8(odd, odd_sum);
        even_sum = _mm256_add_epi8(even_sum, even_last);
        odd_sum = _mm256_add_epi8(odd_sum, odd_last);
        /* Unpacking works within halves of the register: put the four quarters in order. */
        __m256i low = _mm256_unpacklo_epi8(even, odd), high = _mm256_unpackhi_epi8(even, odd);
        _mm256_storeu_si256((__m256i *)(out + 2 * i), _mm256_permute2x128_si256(low, high, 0x20));
        _mm256_storeu_si256((__m256i *)(out + 2 * i + 32), _mm256_permute2x128_si256(low, high, 0x31));
    }
    p.done = i;
    p.even_sum = (uint8_t)_mm_cvtsi128_si32(_mm256_castsi256_si128(even_sum));
    p.odd_sum = (uint8_t)_mm_cvtsi128_si32(_mm256_castsi256_si128(odd_sum));
    finish(&p, size, out);
}

#endif

hdr_predictor hdr_predictor_at(hdr_cpu_level level) {
#if defined(HDR_X86)
    if (level >= HDR_CPU_AVX2) return undo_avx2;
    if (level >= HDR_CPU_SSE2) return undo_sse2;
#endif
    (void)level;
    return undo_c;
}

void hdr_predictor_undo(const unsigned char *in, size_t size, unsigned char *out) {
    hdr_predictor_at(hdr_cpu())(in, size, out);
}
