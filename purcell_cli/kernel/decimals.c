/* Doubles as text: the fewest decimal digits that read back as the same double, the nearest of those to it.
 *
 * Giulietti, "The Schubfach way to render doubles" (2021). The powers of ten come from the Python side, which has whole
 * numbers of any size: for k = -292 to 324 the 128 bits of 10^k, rounded up, the higher half first.
 */
#include <string.h>

#include "kernel.h"

#define LEAST_POWER (-292)
#define EXPONENT_BIAS 1075 /* of doubles as whole numbers of 53 bits times a power of two */
#define HIDDEN_BIT (1ULL << 52)
#define POSITIONAL_FROM (-5) /* decimal exponents that are written without an exponent */
#define POSITIONAL_BELOW 16

/* floor(e log2(10)), floor(e log10(2)) and floor(e log10(2) + log10(3/4)) for every exponent of a double. */
static int floor_log2_of_power_of_10(int e) { return (int)(((int64_t)e * 1741647) >> 19); }
static int floor_log10_of_power_of_2(int e) { return (int)(((int64_t)e * 1262611) >> 22); }
static int floor_log10_of_three_quarters(int e) { return (int)(((int64_t)e * 1262611 - 524031) >> 22); }

/* The upper 64 bits of a product of 192, its last bit set where anything of those below it is. */
static uint64_t upper_to_odd(const uint64_t power[2], uint64_t factor) {
    unsigned __int128 high = (unsigned __int128)power[0] * factor, low = (unsigned __int128)power[1] * factor;
    high += (uint64_t)(low >> 64);
    return (uint64_t)(high >> 64) | ((uint64_t)high > 1);
}

/* The shortest decimal of a positive double: its digits as a whole number, times 10^*exponent. */
static uint64_t shortest(uint64_t bits, const uint64_t (*powers)[2], int *exponent) {
    uint64_t fraction = bits & (HIDDEN_BIT - 1), c = fraction;
    int biased = (int)(bits >> 52) & 0x7ff, q = 1 - EXPONENT_BIAS;
    if (biased) {
        c |= HIDDEN_BIT;
        q = biased - EXPONENT_BIAS;
        if (q <= 0 && q > -53 && !(c & ((1ULL << -q) - 1))) { /* a whole number */
            *exponent = 0;
            return c >> -q;
        }
    }
    int odd = (int)(c & 1), closer = fraction == 0 && biased > 1; /* below a power of two doubles are half as far */
    int k = closer ? floor_log10_of_three_quarters(q) : floor_log10_of_power_of_2(q);
    int h = q + floor_log2_of_power_of_10(-k) + 1;
    const uint64_t *power = powers[-k - LEAST_POWER];
    uint64_t lower = upper_to_odd(power, (4 * c - 2 + (uint64_t)closer) << h) + (uint64_t)odd;
    uint64_t value = upper_to_odd(power, (4 * c) << h);
    uint64_t upper = upper_to_odd(power, (4 * c + 2) << h) - (uint64_t)odd;
    uint64_t digits = value / 4, fewer = digits / 10;
    int below, above;
    *exponent = k;
    if (digits >= 10) {
        below = lower <= 40 * fewer;
        above = 40 * fewer + 40 <= upper;
        if (below != above) {
            *exponent = k + 1;
            return fewer + (uint64_t)above;
        }
    }
    below = lower <= 4 * digits;
    above = 4 * digits + 4 <= upper;
    if (below != above) return digits + (uint64_t)above;
    uint64_t middle = 4 * digits + 2;
    return digits + (uint64_t)(value > middle || (value == middle && (digits & 1)));
}

static char *repeated(char *out, char what, int times) {
    for (; times > 0; times--) *out++ = what;
    return out;
}

static char *copied(char *out, const char *text, int length) {
    for (int k = 0; k < length; k++) out[k] = text[k];
    return out + length;
}

static char *whole(char *out, unsigned value) {
    if (value >= 10) out = whole(out, value / 10);
    *out++ = (char)('0' + value % 10);
    return out;
}

/* One number's text; returns where it ends. */
static char *written(char *out, double number, const uint64_t (*powers)[2]) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    if (number != number) return copied(out, "NaN", 3);
    if (bits >> 63) *out++ = '-';
    bits &= ~(1ULL << 63);
    if (bits == 0) return copied(out, "0.0", 3);
    if (bits == 0x7ffULL << 52) return copied(out, "inf", 3);
    int exponent, count = 0;
    uint64_t value = shortest(bits, powers, &exponent);
    char text[20];
    int first = (int)sizeof text;
    for (; value; value /= 10) text[--first] = (char)('0' + value % 10);
    count = (int)sizeof text - first;
    const char *digits = text + first;
    int point = count + exponent; /* digits before the decimal point */
    while (count > 1 && digits[count - 1] == '0') count--;
    if (point <= POSITIONAL_FROM || point > POSITIONAL_BELOW) {
        *out++ = digits[0];
        if (count > 1) *out++ = '.';
        out = copied(out, digits + 1, count - 1);
        *out++ = 'e';
        *out++ = point > 0 ? '+' : '-';
        return whole(out, (unsigned)(point > 0 ? point - 1 : 1 - point));
    }
    if (point <= 0) return copied(repeated(copied(out, "0.", 2), '0', -point), digits, count);
    if (point >= count) return copied(repeated(copied(out, digits, count), '0', point - count), ".0", 2);
    out = copied(out, digits, point);
    *out++ = '.';
    return copied(out, digits + point, count - point);
}

/* Rows of numbers as text, with commas between and, after the first of each row, one of some words; returns how long
 * it is. Word k is words[stops[k]] to words[stops[k + 1]]. */
API SIZE purcell_rows_as_text(SIZE rows, SIZE columns, const double *numbers, const uint64_t (*powers)[2],
                              const SIZE *which, const SIZE *stops, const char *words, char *out) {
    char *at = out;
    for (SIZE i = 0; i < rows; i++) {
        const SIZE *word = stops + which[i];
        for (SIZE k = 0; k < columns; k++) {
            at = written(at, numbers[i * columns + k], powers);
            if (k == 0) at = copied(at, words + word[0], (int)(word[1] - word[0]));
            *at++ = k + 1 < columns ? ',' : '\n';
        }
    }
    return (SIZE)(at - out);
}
