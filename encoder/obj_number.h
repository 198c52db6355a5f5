/* Decimal numbers, whatever the locale. */
#ifndef NSDF_OBJ_NUMBER_H
#define NSDF_OBJ_NUMBER_H

#include <stdint.h>

/* Reads [+-]digits[.digits][(e|E)[+-]digits] from a zero-terminated text, with at least one digit before the
 * exponent.  Returns the first character after it, or NULL when there is no number.  The value is correctly rounded
 * for up to 15 digits with a power of ten up to 22, else within 1 unit in the last place; infinite when it is too
 * large for a double. */
const char *nsdf_read_number(const char *text, double *value);

/* Reads [+-]digits.  Values beyond +-2^53 are cut there.  Returns as above. */
const char *nsdf_read_integer(const char *text, int64_t *value);

#endif
