/* Reading through callbacks that fail: a read beyond `available` bytes, or the call of a number that the input chooses,
 * gives an error after having written half of what was asked for. */
#include "fuzz_target.h"

#include <stdlib.h>
#include <string.h>

typedef struct short_reader {
    const uint8_t *data;
    size_t size, available;
    uint32_t calls, fail_at;
} short_reader;

static int read_short(void *user, uint64_t offset, void *dst, size_t size) {
    short_reader *reader = user;
    if (offset > reader->size || size > reader->size - offset)
        abort();
    const int fails = ++reader->calls == reader->fail_at || offset + size > reader->available;
    memcpy(dst, reader->data + offset, fails ? size / 2 : size);
    return fails;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const float points[6] = {0.0f, 0.0f, 0.0f, 1.0f, 2.0f, 3.0f};
    uint8_t choice[FUZZ_CHOICES];
    fuzz_choices(data, &size, choice);
    short_reader reader = {data, size, choice[1] ? size * choice[1] / 255 : size, 0, choice[0]};
    const nsdf_io io = {&reader, read_short, size};
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    float distance[2];
    fuzz_options_init(&options);
    options.check_all = choice[0] & 1;
    const nsdf_status status = nsdf_open_callbacks(&decoder, &io, &options, &error);
    if (status != NSDF_OK && (decoder || error.status != status))
        abort();
    for (int i = 0; status == NSDF_OK && i < 4; i++)
        fuzz_any(nsdf_evaluate(decoder, 0.05 * i, points, 2, distance, NULL));
    if (status == NSDF_OK)
        fuzz_any(nsdf_verify(decoder));
    nsdf_close(&decoder);
    return 0;
}
