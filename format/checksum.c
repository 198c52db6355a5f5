#include <string.h>

#include "container_read.h"

/* CRC-32 of the sixteen 4-bit values, reflected polynomial 0xedb88320: chunks are small beside the work of decoding
 * them, so a table that fits one cache line serves. */
static const uint32_t crc_nibble[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4,
                                        0x4db26158, 0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                        0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};

uint32_t nsdf_crc32(uint32_t crc, const void *data, size_t size) {
    const uint8_t *p = data;
    crc = ~crc;
    for (size_t i = 0; i < size; i++) {
        crc ^= p[i];
        crc = crc >> 4 ^ crc_nibble[crc & 15];
        crc = crc >> 4 ^ crc_nibble[crc & 15];
    }
    return ~crc;
}

static uint64_t hash_byte(uint64_t hash, uint32_t byte) {
    return (hash ^ byte) * UINT64_C(0x100000001b3);
}

uint64_t nsdf_hash64(uint64_t hash, const void *data, size_t size) {
    const uint8_t *p = data;
    for (size_t i = 0; i < size; i++)
        hash = hash_byte(hash, p[i]);
    return hash;
}

uint64_t nsdf_hash_floats(uint64_t hash, const float *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        for (int k = 0; k < 4; k++)
            hash = hash_byte(hash, bits >> 8 * k & 0xff);
    }
    return hash;
}
