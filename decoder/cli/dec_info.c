#include "dec_info.h"

#include <stdio.h>
#include <string.h>

static nsdf_status get_segment(nsdf_decoder *decoder, uint32_t index, int load, nsdf_segment_info *info) {
    return load ? nsdf_get_segment_info(decoder, index, info) : nsdf_get_segment_extent(decoder, index, info);
}

/* The number of parameters is known only when every segment was loaded. */
static nsdf_status load_info(nsdf_decoder *decoder, int load, nsdf_info *info) {
    nsdf_segment_info segment;
    nsdf_status status = nsdf_get_info(decoder, info);
    if (!load)
        return status;
    for (uint32_t i = 0; status == NSDF_OK && i < info->segment_count; i++)
        status = nsdf_get_segment_info(decoder, i, &segment);
    return status == NSDF_OK ? nsdf_get_info(decoder, info) : status;
}

/* ---- For people -------------------------------------------------------------------------------------------- */

/* Text from the file must not be able to drive the terminal. */
static void print_plain(const char *text) {
    for (; *text; text++)
        putchar((unsigned char)*text < 0x20 || *text == 0x7f ? '?' : *text);
}

static void print_quality(const nsdf_quality *q) {
    if (q->frames == 0) {
        printf("quality         not measured\n");
        return;
    }
    printf("quality         of %lu frames at resolution %lu, as fractions of the diagonal\n", (unsigned long)q->frames,
           (unsigned long)q->resolution);
    printf("                             mean         rms         max\n");
    printf("  input to decoded  %11.3e %11.3e %11.3e\n", q->mean_to_decoded, q->rms_to_decoded, q->max_to_decoded);
    printf("  decoded to input  %11.3e %11.3e %11.3e\n", q->mean_to_input, q->rms_to_input, q->max_to_input);
}

static nsdf_status print_segments(nsdf_decoder *decoder, int load, uint32_t count) {
    printf("segments        %lu\n", (unsigned long)count);
    printf("  no.     start s       end s       bytes%s\n", load ? "  parameters  layers  width  coding" : "");
    for (uint32_t i = 0; i < count; i++) {
        nsdf_segment_info s;
        const nsdf_status status = get_segment(decoder, i, load, &s);
        if (status != NSDF_OK)
            return status;
        printf("  %3lu %11.6g %11.6g %11llu", (unsigned long)i, s.start, s.end, (unsigned long long)s.size);
        if (load)
            printf(" %11llu %7lu %6lu  %s", (unsigned long long)s.parameter_count, (unsigned long)s.layers,
                   (unsigned long)s.width, s.entropy);
        printf("\n");
    }
    return NSDF_OK;
}

static void print_metadata(const nsdf_decoder *decoder) {
    const uint32_t count = nsdf_metadata_count(decoder);
    if (count > 0)
        printf("metadata\n");
    for (uint32_t i = 0; i < count; i++) {
        const char *key, *value;
        if (nsdf_get_metadata(decoder, i, &key, &value) != NSDF_OK)
            continue;
        printf("  ");
        print_plain(key);
        printf(": ");
        print_plain(value);
        printf("\n");
    }
}

static void print_box(const char *label, const double low[3], const double high[3]) {
    printf("%-15s (%g, %g, %g) to (%g, %g, %g)\n", label, low[0], low[1], low[2], high[0], high[1], high[2]);
}

nsdf_status dec_info_print(nsdf_decoder *decoder, const char *path, int load) {
    nsdf_info info;
    nsdf_status status = load_info(decoder, load, &info);
    if (status != NSDF_OK)
        return status;
    printf("file            %s\n", path);
    printf("format version  %lu.%lu\n", (unsigned long)info.format_major, (unsigned long)info.format_minor);
    printf("size            %llu bytes\n", (unsigned long long)info.file_size);
    printf("frames          %lu\n", (unsigned long)info.frame_count);
    printf("frame rate      %lu/%lu = %.6g a second\n", (unsigned long)info.rate_num, (unsigned long)info.rate_den,
           info.rate_den ? (double)info.rate_num / info.rate_den : 0);
    printf("duration        %.9g s\n", info.duration);
    if (info.duration > 0)
        printf("bit rate        %.6g kbit/s\n", (double)info.file_size * 8e-3 / info.duration);
    print_box("box", info.box_min, info.box_max);
    printf("diagonal        %g\n", info.diagonal);
    print_box("domain", info.domain_min, info.domain_max);
    printf("resolution      %lu cells along the domain's longest side\n", (unsigned long)info.default_resolution);
    printf("bound           %g\n", info.extraction_bound);
    printf("smallest piece  %g\n", info.smallest_piece);
    if (load)
        printf("parameters      %llu\n", (unsigned long long)info.parameter_count);
    printf("hash            %016llx\n", (unsigned long long)info.parameter_hash);
    printf("kernels         %s\n", nsdf_kernel_name(decoder));
    print_quality(&info.quality);
    status = print_segments(decoder, load, info.segment_count);
    if (status == NSDF_OK)
        print_metadata(decoder);
    return status;
}

/* ---- For programs ------------------------------------------------------------------------------------------ */

static void json_string(const char *text) {
    putchar('"');
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            printf("\\%c", c);
        else if (c < 0x20 || c == 0x7f)
            printf("\\u%04x", c);
        else
            putchar(c);
    }
    putchar('"');
}

static void json_vector(const char *key, const double v[3]) {
    printf("  \"%s\": [%.17g, %.17g, %.17g],\n", key, v[0], v[1], v[2]);
}

static void json_quality(const nsdf_quality *q) {
    if (q->frames == 0) {
        printf("  \"quality\": null,\n");
        return;
    }
    printf("  \"quality\": {\n    \"frames\": %lu,\n    \"resolution\": %lu,\n", (unsigned long)q->frames,
           (unsigned long)q->resolution);
    printf("    \"to_decoded\": {\"mean\": %.9g, \"rms\": %.9g, \"max\": %.9g},\n", q->mean_to_decoded,
           q->rms_to_decoded, q->max_to_decoded);
    printf("    \"to_input\": {\"mean\": %.9g, \"rms\": %.9g, \"max\": %.9g}\n  },\n", q->mean_to_input,
           q->rms_to_input, q->max_to_input);
}

static void json_shape(const nsdf_segment_info *s) {
    printf(", \"parameters\": %llu, \"layers\": %lu, \"width\": %lu, \"entropy\": ",
           (unsigned long long)s->parameter_count, (unsigned long)s->layers, (unsigned long)s->width);
    json_string(s->entropy);
}

static nsdf_status json_segments(nsdf_decoder *decoder, int load, uint32_t count) {
    printf("  \"segments\": [");
    for (uint32_t i = 0; i < count; i++) {
        nsdf_segment_info s;
        const nsdf_status status = get_segment(decoder, i, load, &s);
        if (status != NSDF_OK)
            return status;
        printf("%s\n    {\"start\": %.17g, \"end\": %.17g, \"offset\": %llu, \"size\": %llu", i ? "," : "", s.start,
               s.end, (unsigned long long)s.offset, (unsigned long long)s.size);
        if (load)
            json_shape(&s);
        printf("}");
    }
    printf("\n  ],\n");
    return NSDF_OK;
}

static void json_metadata(const nsdf_decoder *decoder) {
    const uint32_t count = nsdf_metadata_count(decoder);
    printf("  \"metadata\": {");
    for (uint32_t i = 0; i < count; i++) {
        const char *key = "", *value = "";
        if (nsdf_get_metadata(decoder, i, &key, &value) != NSDF_OK)
            continue;
        printf("%s\n    ", i ? "," : "");
        json_string(key);
        printf(": ");
        json_string(value);
    }
    printf("%s}\n", count ? "\n  " : "");
}

nsdf_status dec_info_print_json(nsdf_decoder *decoder, const char *path, int load) {
    nsdf_info info;
    nsdf_status status = load_info(decoder, load, &info);
    if (status != NSDF_OK)
        return status;
    printf("{\n  \"file\": ");
    json_string(path);
    printf(",\n  \"format\": \"%lu.%lu\",\n", (unsigned long)info.format_major, (unsigned long)info.format_minor);
    printf("  \"size\": %llu,\n", (unsigned long long)info.file_size);
    printf("  \"frames\": %lu,\n", (unsigned long)info.frame_count);
    printf("  \"rate\": [%lu, %lu],\n", (unsigned long)info.rate_num, (unsigned long)info.rate_den);
    printf("  \"duration\": %.17g,\n", info.duration);
    json_vector("box_min", info.box_min);
    json_vector("box_max", info.box_max);
    printf("  \"diagonal\": %.17g,\n", info.diagonal);
    json_vector("domain_min", info.domain_min);
    json_vector("domain_max", info.domain_max);
    printf("  \"resolution\": %lu,\n", (unsigned long)info.default_resolution);
    printf("  \"bound\": %.9g,\n", info.extraction_bound);
    printf("  \"smallest_piece\": %.9g,\n", info.smallest_piece);
    if (load)
        printf("  \"parameters\": %llu,\n", (unsigned long long)info.parameter_count);
    printf("  \"hash\": \"%016llx\",\n", (unsigned long long)info.parameter_hash);
    printf("  \"kernels\": \"%s\",\n", nsdf_kernel_name(decoder));
    json_quality(&info.quality);
    status = json_segments(decoder, load, info.segment_count);
    if (status != NSDF_OK)
        return status;
    json_metadata(decoder);
    printf("}\n");
    return NSDF_OK;
}
