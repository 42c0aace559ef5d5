/* The sums in which most time goes: over a table of links that feel each other, in Cholesky's factor, and of linear programs.
 *
 * Four numbers stand side by side, in one register of 256 bits where the processor has such, and else in two of 128; each
 * number is the same sum in the same order. A build with PURCELL_NARROW never uses the wide ones. */
#include <math.h>

#include "kernel.h"

#define QUAD 4

/* Two registers. Compilers split vectors that are wider than the processor's badly, so it is done here. */
typedef double half __attribute__((vector_size(16), aligned(8), may_alias));
typedef struct {
    half low, high;
} pair;
#define VARIANT static
#define NAMED(name) name##_narrow
#define NUMBERS pair
#define NOTHING {{0.0, 0.0}, {0.0, 0.0}}
#define ZERO ((pair)NOTHING)
#define AT(numbers) ((pair){*(const half *)(numbers), *(const half *)((numbers) + 2)})
#define PUT(numbers, value) (*(half *)(numbers) = (value).low, *(half *)((numbers) + 2) = (value).high)
#define ADD_EACH(sum, one, other)                 \
    do {                                          \
        const pair one_ = (one), other_ = (other); \
        (sum).low += one_.low * other_.low;       \
        (sum).high += one_.high * other_.high;    \
    } while (0)
#define ADD(sum, factor, numbers)                      \
    do {                                               \
        const double factor_ = (factor);               \
        const pair numbers_ = (numbers);               \
        (sum).low += factor_ * numbers_.low;           \
        (sum).high += factor_ * numbers_.high;         \
    } while (0)
#define PART(numbers, i) ((i) < 2 ? (numbers).low[(i)] : (numbers).high[(i) - 2])
#include "wide_sums_body.h"

#ifdef WIDE
#include <cpuid.h>

#undef VARIANT
#undef NAMED
#undef NUMBERS
#undef NOTHING
#undef ZERO
#undef AT
#undef PUT
#undef ADD_EACH
#undef ADD
#undef PART
typedef double quad __attribute__((vector_size(32), aligned(8), may_alias));
#define VARIANT __attribute__((target("avx2"))) static
#define NAMED(name) name##_wide
#define NUMBERS quad
#define NOTHING {0.0, 0.0, 0.0, 0.0}
#define ZERO ((quad)NOTHING)
#define AT(numbers) (*(const quad *)(numbers))
#define PUT(numbers, value) (*(quad *)(numbers) = (value))
#define ADD_EACH(sum, one, other) ((sum) += (one) * (other))
#define ADD(sum, factor, numbers) ((sum) += (factor) * (numbers))
#define PART(numbers, i) ((numbers)[i])
#include "wide_sums_body.h"

int purcell_is_wide(void) {
    static int known = -1;
    if (known < 0) {
        unsigned a, b, c, d, low, high;
        int found = 0;
        if (__get_cpuid(1, &a, &b, &c, &d) && (c & bit_OSXSAVE) && (c & bit_AVX) && (c & bit_FMA)) {
            __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
            found = (low & 6u) == 6u && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2);
        }
        known = found;
    }
    return known;
}

#define EITHER(name, parameters, arguments)   \
    void purcell_##name parameters {          \
        if (purcell_is_wide()) name##_wide arguments; \
        else name##_narrow arguments;         \
    }
#else
#define EITHER(name, parameters, arguments) \
    void purcell_##name parameters { name##_narrow arguments; }
#endif

EITHER(table_rows,
       (const double *rows, int count, int entries, const double *weight, const double *slope, double *sum, double *sloped),
       (rows, count, entries, weight, slope, sum, sloped))
EITHER(contract, (const struct known *known, const double *weight, const double *slope, struct contracted *out),
       (known, weight, slope, out))
EITHER(angle_series,
       (double (*of)[WIDTH], int used, int entries, const double *plain, const double *mixed, struct series *out),
       (of, used, entries, plain, mixed, out))
EITHER(interpolated, (const struct field *f, double (*weight)[LANES], int first, int last, lane *out),
       (f, weight, first, last, out))
EITHER(cholesky, (SIZE n, double *m, int *positive), (n, m, positive))
EITHER(renewed,
       (SIZE n, int changed, double *const *row, const double *factor, const double *slope, const double *pivot,
        double *gains),
       (n, changed, row, factor, slope, pivot, gains))
EITHER(inner_products, (SIZE n, SIZE count, const double *rows, const double *other, double *out),
       (n, count, rows, other, out))
