/* Numbers of up to 2^53 times a power of ten up to 10^22 are one exact division or multiplication (Clinger 1990).
 * The rest keep their first 19 digits and are scaled in pairs of doubles, with about 100 bits. */
#include "obj_number.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#define MAX_EXACT_POWER 22
#define MAX_MANTISSA UINT64_C(1000000000000000000) /* one more digit still fits 64 bits */
#define MAX_EXPONENT 100000

static const double powers[MAX_EXACT_POWER + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

typedef struct decimal {
    uint64_t mantissa;
    int exponent;
} decimal;

/* The sum of two doubles, high + low. */
typedef struct pair {
    double high, low;
} pair;

static pair pair_times(pair a, double b) {
    double high = a.high * b;
    double low = fma(a.high, b, -high) + a.low * b;
    return (pair){high + low, low - ((high + low) - high)};
}

static pair pair_over(pair a, double b) {
    double high = a.high / b;
    double low = (fma(-high, b, a.high) + a.low) / b;
    return (pair){high + low, low - ((high + low) - high)};
}

static double scale_carefully(decimal d) {
    /* Beyond these the value is 0 or infinite whatever its digits. */
    if (d.mantissa == 0 || d.exponent < -360) {
        return 0.0;
    }
    if (d.exponent > 310) {
        return INFINITY;
    }
    double high = (double)(d.mantissa >> 11 << 11), low = (double)(d.mantissa & 0x7ff);
    pair value = {high + low, low - ((high + low) - high)};
    int power = d.exponent < 0 ? -d.exponent : d.exponent;
    while (power > 0 && value.high != 0.0 && isfinite(value.high)) {
        int step = power < MAX_EXACT_POWER ? power : MAX_EXACT_POWER;
        value = d.exponent < 0 ? pair_over(value, powers[step]) : pair_times(value, powers[step]);
        power -= step;
    }
    return isnan(value.high) ? INFINITY : value.high;
}

static double to_double(decimal d) {
    if (d.mantissa <= UINT64_C(1) << 53 && d.exponent >= -MAX_EXACT_POWER && d.exponent <= MAX_EXACT_POWER) {
        double mantissa = (double)d.mantissa;
        return d.exponent < 0 ? mantissa / powers[-d.exponent] : mantissa * powers[d.exponent];
    }
    return scale_carefully(d);
}

/* Digits of the whole or the fractional part; digits beyond the 19th only move the point. */
static const char *read_digits(const char *text, decimal *d, int fraction) {
    for (; is_digit(*text); text++) {
        if (d->mantissa < MAX_MANTISSA) {
            d->mantissa = 10 * d->mantissa + (uint64_t)(*text - '0');
            d->exponent -= d->exponent > -MAX_EXPONENT ? fraction : 0;
        } else if (d->exponent < MAX_EXPONENT) {
            d->exponent += 1 - fraction;
        }
    }
    return text;
}

/* Returns the text itself when what follows is not an exponent. */
static const char *read_exponent(const char *text, decimal *d) {
    const char *p = text + 1;
    bool negative = *p == '-';
    p += *p == '-' || *p == '+';
    if ((*text != 'e' && *text != 'E') || !is_digit(*p)) {
        return text;
    }
    int exponent = 0;
    for (; is_digit(*p); p++) {
        exponent = exponent < MAX_EXPONENT ? 10 * exponent + (*p - '0') : exponent;
    }
    d->exponent += negative ? -exponent : exponent;
    return p;
}

const char *nsdf_read_number(const char *text, double *value) {
    bool negative = *text == '-';
    const char *first = text + (*text == '-' || *text == '+');
    decimal d = {0, 0};
    const char *p = read_digits(first, &d, 0);
    ptrdiff_t digits = p - first;
    if (*p == '.') {
        const char *fraction = p + 1;
        p = read_digits(fraction, &d, 1);
        digits += p - fraction;
    }
    if (digits == 0) {
        return NULL;
    }
    if (*p == 'e' || *p == 'E') {
        p = read_exponent(p, &d);
    }
    double magnitude = to_double(d);
    *value = negative ? -magnitude : magnitude;
    return p;
}

const char *nsdf_read_integer(const char *text, int64_t *value) {
    const int64_t limit = INT64_C(1) << 53;
    bool negative = *text == '-';
    const char *first = text + (*text == '-' || *text == '+'), *p = first;
    int64_t magnitude = 0;
    for (; is_digit(*p); p++) {
        magnitude = magnitude < limit ? 10 * magnitude + (*p - '0') : limit;
    }
    *value = negative ? -magnitude : magnitude;
    return p > first ? p : NULL;
}
