#include <stdlib.h>
#include <string.h>

#include "container_write.h"

/* Room for `size` more bytes; 0 when memory ran out, now or before. */
static int reserve(nsdf_buffer *b, size_t size) {
    if (b->failed)
        return 0;
    if (size <= b->capacity - b->size)
        return 1;
    size_t capacity = b->capacity < 256 ? 256 : b->capacity;
    while (capacity - b->size < size && capacity <= SIZE_MAX / 2)
        capacity *= 2;
    uint8_t *data = capacity - b->size < size ? NULL : realloc(b->data, capacity);
    if (!data) {
        b->failed = 1;
        return 0;
    }
    b->data = data;
    b->capacity = capacity;
    return 1;
}

void nsdf_buffer_append(nsdf_buffer *b, const void *data, size_t size) {
    if (size == 0 || !reserve(b, size))
        return;
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void append_number(nsdf_buffer *b, uint64_t v, size_t size) {
    uint8_t bytes[8];
    for (size_t i = 0; i < size; i++)
        bytes[i] = (uint8_t)(v >> 8 * i);
    nsdf_buffer_append(b, bytes, size);
}

void nsdf_buffer_u8(nsdf_buffer *b, uint8_t v) {
    append_number(b, v, 1);
}

void nsdf_buffer_u16(nsdf_buffer *b, uint16_t v) {
    append_number(b, v, 2);
}

void nsdf_buffer_u32(nsdf_buffer *b, uint32_t v) {
    append_number(b, v, 4);
}

void nsdf_buffer_u64(nsdf_buffer *b, uint64_t v) {
    append_number(b, v, 8);
}

void nsdf_buffer_f32(nsdf_buffer *b, float v) {
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    nsdf_buffer_u32(b, bits);
}

void nsdf_buffer_f64(nsdf_buffer *b, double v) {
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    nsdf_buffer_u64(b, bits);
}

void nsdf_buffer_free(nsdf_buffer *b) {
    free(b->data);
    memset(b, 0, sizeof *b);
}
