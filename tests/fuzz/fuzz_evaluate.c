/* Opening, loading segments and evaluating the field, with every kind of kernel. */
#include "fuzz_target.h"

#include <math.h>

enum { POINTS = 19 };

static void evaluate(nsdf_decoder *decoder, double t) {
    float xyz[3 * POINTS], distance[POINTS], gradient[3 * POINTS];
    nsdf_info info;
    fuzz_any(nsdf_get_info(decoder, &info));
    for (int i = 0; i < 3 * POINTS; i++) {
        const double part = 0.61803398875 * i - floor(0.61803398875 * i);
        xyz[i] =
            (float)(info.domain_min[i % 3] + (1.2 * part - 0.1) * (info.domain_max[i % 3] - info.domain_min[i % 3]));
    }
    fuzz_any(nsdf_evaluate(decoder, t, xyz, POINTS, distance, NULL));
    fuzz_any(nsdf_evaluate(decoder, t, xyz, POINTS, distance, gradient));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint8_t choice[FUZZ_CHOICES];
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_info info;
    fuzz_choices(data, &size, choice);
    fuzz_options_init(&options);
    options.cpu_mask = choice[0] & 3;
    if (nsdf_open_memory(&decoder, data, size, &options, NULL) == NSDF_OK && nsdf_get_info(decoder, &info) == NSDF_OK) {
        evaluate(decoder, 0.0);
        evaluate(decoder, info.duration * choice[1] / 255.0);
        fuzz_any(nsdf_verify(decoder));
    }
    nsdf_close(&decoder);
    return 0;
}
