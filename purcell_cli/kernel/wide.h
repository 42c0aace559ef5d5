/* Sums of many numbers side by side. A processor with wider registers makes more of them at once; each number is the same sum in
 * the same order. A build with PURCELL_NARROW never uses them. */
#ifndef PURCELL_WIDE_H
#define PURCELL_WIDE_H

#include "kernel.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(PURCELL_NARROW)
#include <cpuid.h>

#define WIDE __attribute__((target("avx2")))

/* Whether the processor and its system have 256 bit registers. */
static int is_wide(void) {
    static int known = -1;
    if (known < 0) {
        unsigned a, b, c, d, low, high;
        int found = 0;
        if (__get_cpuid(1, &a, &b, &c, &d) && (c & bit_OSXSAVE) && (c & bit_AVX)) {
            __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
            found = (low & 6u) == 6u && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2);
        }
        known = found;
    }
    return known;
}

/* A function from its body, `name_body`, built twice. */
#define EITHER(name, parameters, arguments)                   \
    WIDE static void name##_wide parameters { name##_body arguments; } \
    static void name##_plain parameters { name##_body arguments; }     \
    void purcell_##name parameters {                          \
        if (is_wide()) name##_wide arguments;                 \
        else name##_plain arguments;                          \
    }
#else
#define EITHER(name, parameters, arguments) \
    void purcell_##name parameters { name##_body arguments; }
#endif

#define BODY static inline __attribute__((always_inline)) void

/* Numbers side by side, which compilers would else rather not keep so. */
typedef double quad __attribute__((vector_size(32), aligned(8), may_alias));
#define QUAD 4
#define AT(numbers) (*(const quad *)(numbers))
#define PUT(numbers, value) (*(quad *)(numbers) = (value))
static const quad nothing = {0.0, 0.0, 0.0, 0.0};

#endif
