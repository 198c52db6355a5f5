#include "bytes.h"

/* Length of the UTF-8 sequence at p (RFC 3629: shortest form, no surrogates, at most U+10FFFF), 0 if it is none. */
static size_t utf8_sequence(const uint8_t *p, size_t size) {
    uint8_t lead = p[0];
    if (lead < 0x80)
        return 1;
    size_t length = lead < 0xc2 ? 0 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : lead < 0xf5 ? 4 : 0;
    if (length == 0 || length > size)
        return 0;
    for (size_t i = 1; i < length; i++)
        if ((p[i] & 0xc0) != 0x80)
            return 0;
    int overlong = (lead == 0xe0 && p[1] < 0xa0) || (lead == 0xf0 && p[1] < 0x90);
    int surrogate = lead == 0xed && p[1] >= 0xa0;
    int beyond = lead == 0xf4 && p[1] >= 0x90;
    return overlong || surrogate || beyond ? 0 : length;
}

/* Takes a string of `size` bytes and the NUL behind it. */
static const char *take_string(nsdf_cursor *c, size_t size) {
    size_t at = c->at;
    const uint8_t *s = nsdf_take(c, size);
    nsdf_cursor_expect(c, nsdf_take_u8(c) == 0, at + size, "metadata string without its NUL");
    if (c->status != NSDF_PARSE_OK)
        return NULL;
    for (size_t i = 0; i < size && c->status == NSDF_PARSE_OK;) {
        size_t length = utf8_sequence(s + i, size - i);
        nsdf_cursor_expect(c, length > 0, at + i, "metadata string that is not UTF-8");
        nsdf_cursor_expect(c, s[i] != 0, at + i, "metadata string with a NUL inside");
        i += length;
    }
    return (const char *)s;
}

nsdf_parse nsdf_read_metadata(const uint8_t *payload, size_t size, size_t *cursor, const char **key, const char **value,
                              nsdf_fault *fault) {
    if (*cursor >= size) {
        *key = *value = NULL;
        return NSDF_PARSE_OK;
    }
    nsdf_cursor c = nsdf_cursor_start(payload, size, *cursor);
    size_t key_size = nsdf_take_u16(&c);
    nsdf_cursor_expect(&c, key_size > 0, *cursor, "metadata key without a byte");
    size_t value_size = nsdf_take_u32(&c);
    const char *found_key = take_string(&c, key_size);
    const char *found_value = take_string(&c, value_size);
    if (c.status == NSDF_PARSE_OK) {
        *cursor = c.at;
        *key = found_key;
        *value = found_value;
    }
    return nsdf_cursor_finish(&c, fault);
}
