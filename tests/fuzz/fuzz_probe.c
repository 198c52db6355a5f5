/* Opening and describing: container, header, index, metadata, quality. */
#include "fuzz_target.h"

#include <stdlib.h>
#include <string.h>

static void describe(nsdf_decoder *decoder) {
    nsdf_info info;
    nsdf_segment_info segment;
    const char *key, *value;
    double seconds;
    if (nsdf_get_info(decoder, &info) != NSDF_OK)
        abort();
    for (uint32_t i = 0; i < nsdf_metadata_count(decoder); i++)
        if (nsdf_get_metadata(decoder, i, &key, &value) != NSDF_OK || strlen(key) + strlen(value) > info.file_size)
            abort();
    for (uint32_t i = 0; i < info.segment_count && i < 4; i++)
        fuzz_any(nsdf_get_segment_info(decoder, i, &segment));
    if (nsdf_frame_time(decoder, info.frame_count - 1, &seconds) != NSDF_OK || !(seconds >= 0))
        abort();
    if (nsdf_frame_time(decoder, info.frame_count, &seconds) == NSDF_OK)
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint8_t choice[FUZZ_CHOICES];
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    memset(&error, 0, sizeof error);
    fuzz_options_init(&options);
    fuzz_choices(data, &size, choice);
    options.check_all = choice[0] & 1;
    const nsdf_status status = nsdf_open_memory(&decoder, data, size, &options, &error);
    if (status == NSDF_OK)
        describe(decoder);
    else if (decoder || error.status != status || !error.message[0] || error.offset > size)
        abort();
    nsdf_close(&decoder);
    return 0;
}
