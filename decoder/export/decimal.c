/* Numbers as decimals, fast and without the locale: floats with the fewest digits that read back as the same float. */
#include "mesh_output.h"

#include <math.h>

enum { MOST_DIGITS = 9, POWERS = 64 }; /* 9 digits always suffice (C11 5.2.4.2.2, FLT_DECIMAL_DIG) */

/* Exact up to 10^22, correctly rounded beyond. */
static const double power_of_ten[POWERS] = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22, 1e23, 1e24, 1e25, 1e26, 1e27, 1e28, 1e29, 1e30, 1e31,
    1e32, 1e33, 1e34, 1e35, 1e36, 1e37, 1e38, 1e39, 1e40, 1e41, 1e42, 1e43, 1e44, 1e45, 1e46, 1e47,
    1e48, 1e49, 1e50, 1e51, 1e52, 1e53, 1e54, 1e55, 1e56, 1e57, 1e58, 1e59, 1e60, 1e61, 1e62, 1e63};

static const char digit_pairs[] =
    "00010203040506070809101112131415161718192021222324252627282930313233343536373839404142434445"
    "46474849505152535455565758596061626364656667686970717273747576777879808182838485868788899091"
    "9293949596979899";

static double scale_by_ten(double value, int exponent) {
    return exponent >= 0 ? value * power_of_ten[exponent] : value / power_of_ten[-exponent];
}

static float from_bits(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* digits * 10^exponent. */
typedef struct decimal {
    uint32_t digits;
    int count, exponent;
} decimal;

/* The largest e with 10^e <= value. */
static int decimal_exponent(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    const int binary = (int)(bits >> 52) - 1023; /* a float is never subnormal as a double */
    /* floor(binary log10(2)), shifted to stay positive: right, or one too small */
    const int e = (int)(((int64_t)binary * 1292913986 + ((int64_t)128 << 32)) >> 32) - 128;
    return scale_by_ten(1, e + 1) <= value ? e + 1 : e;
}

/* Works on the value scaled to 9 digits before the point, and takes digits away while the decimal stays safely between
 * the middles towards the neighbouring floats: the margin covers the rounding of the doubles used here, so that any
 * correct reader finds the same float. */
static decimal shortest(float value) {
    static const double inverse[MOST_DIGITS] = {1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8};
    const uint32_t bits = nsdf_float_bits(value);
    const double v = (double)value, margin = v * 0x1p-49;
    const double below = 0.5 * (v + (double)from_bits(bits - 1)) + margin;
    const double above = bits == 0x7f7fffffu ? v * (1 + 0x1p-25) : 0.5 * (v + (double)from_bits(bits + 1)) - margin;
    const int e = decimal_exponent(v), shift = MOST_DIGITS - 1 - e;
    const double scaled = scale_by_ten(v, shift), low = scale_by_ten(below, shift), high = scale_by_ten(above, shift);
    decimal d = {(uint32_t)(scaled + 0.5), MOST_DIGITS, -shift};
    for (int cut = 1; cut < MOST_DIGITS; cut++) {
        const uint32_t digits = (uint32_t)(scaled * inverse[cut] + 0.5);
        const double shorter = (double)digits * power_of_ten[cut];
        if (shorter <= low || shorter >= high)
            break;
        d = (decimal){digits, MOST_DIGITS - cut, cut - shift};
    }
    if (d.digits >= (uint32_t)power_of_ten[d.count]) { /* 9.9999997 became 10 */
        d.digits /= 10;
        d.exponent++;
    }
    return d;
}

unsigned char *nsdf_put_integer(unsigned char *at, uint32_t value) {
    char text[10];
    int first = 10;
    for (; value >= 100; value /= 100)
        memcpy(text + (first -= 2), digit_pairs + 2 * (value % 100), 2);
    if (value >= 10)
        memcpy(text + (first -= 2), digit_pairs + 2 * value, 2);
    else
        text[--first] = (char)('0' + value);
    memcpy(at, text + first, (size_t)(10 - first));
    return at + (10 - first);
}

/* Digits with the point behind the first `before` of them; before may be negative or beyond the last.  Copies of a
 * fixed length are faster than of the right one. */
static unsigned char *put_with_point(unsigned char *at, const decimal *d, int before) {
    unsigned char text[24];
    memset(text, '0', sizeof text);
    nsdf_put_integer(text, d->digits);
    if (before <= 0) {
        memcpy(at, "0.000", 6);
        memcpy(at + 2 - before, text, MOST_DIGITS);
        return at + 2 - before + d->count;
    }
    memcpy(at, text, MOST_DIGITS);
    if (before >= d->count)
        return at + before;
    at[before] = '.';
    memcpy(at + before + 1, text + before, MOST_DIGITS);
    return at + d->count + 1;
}

unsigned char *nsdf_put_decimal(unsigned char *at, float value) {
    if (value != value)
        return memcpy(at, "nan", 3), at + 3;
    if (signbit(value))
        *at++ = '-';
    value = fabsf(value);
    if (value == 0)
        return *at++ = '0', at;
    if (isinf(value))
        return memcpy(at, "inf", 3), at + 3;
    const decimal d = shortest(value);
    const int before = d.count + d.exponent;
    if (before > -4 && before <= MOST_DIGITS)
        return put_with_point(at, &d, before);
    at = put_with_point(at, &d, 1);
    *at++ = 'e';
    *at++ = before > 0 ? '+' : '-';
    return nsdf_put_integer(at, (uint32_t)(before > 0 ? before - 1 : 1 - before));
}
