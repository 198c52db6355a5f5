#include "mux_info.h"

#include <stdio.h>
#include <string.h>

#include "cli_util.h"

/* ---- JSON ------------------------------------------------------------------------------------------------------- */

static void print_vector(nsdf_cli_file *out, const char *key, const double v[3]) {
    nsdf_cli_file_print(out, "  \"%s\": [%.17g, %.17g, %.17g],\n", key, v[0], v[1], v[2]);
}

static void print_head(nsdf_cli_file *out, const char *name, const nsdf_info *info) {
    nsdf_cli_file_print(out, "{\n  \"file\": ");
    nsdf_cli_file_print_json(out, name);
    nsdf_cli_file_print(out, ",\n  \"format\": \"%u.%u\",\n", info->format_major, info->format_minor);
    nsdf_cli_file_print(out, "  \"size\": %llu,\n", (unsigned long long)info->file_size);
    nsdf_cli_file_print(out, "  \"frames\": %u,\n", info->frame_count);
    nsdf_cli_file_print(out, "  \"rate\": [%u, %u],\n", info->rate_num, info->rate_den);
    nsdf_cli_file_print(out, "  \"duration\": %.17g,\n", info->duration);
    print_vector(out, "box_min", info->box_min);
    print_vector(out, "box_max", info->box_max);
    nsdf_cli_file_print(out, "  \"diagonal\": %.17g,\n", info->diagonal);
    print_vector(out, "domain_min", info->domain_min);
    print_vector(out, "domain_max", info->domain_max);
    nsdf_cli_file_print(out, "  \"resolution\": %u,\n", info->default_resolution);
    nsdf_cli_file_print(out, "  \"bound\": %.9g,\n", info->extraction_bound);
    nsdf_cli_file_print(out, "  \"hash\": \"%016llx\",\n", (unsigned long long)info->parameter_hash);
}

static void print_quality(nsdf_cli_file *out, const nsdf_quality *q) {
    if (q->frames == 0) {
        nsdf_cli_file_print(out, "  \"quality\": null,\n");
        return;
    }
    nsdf_cli_file_print(out, "  \"quality\": {\n    \"frames\": %u,\n    \"resolution\": %u,\n", q->frames,
                        q->resolution);
    nsdf_cli_file_print(out, "    \"to_decoded\": {\"mean\": %.9g, \"rms\": %.9g, \"max\": %.9g},\n",
                        q->mean_to_decoded, q->rms_to_decoded, q->max_to_decoded);
    nsdf_cli_file_print(out, "    \"to_input\": {\"mean\": %.9g, \"rms\": %.9g, \"max\": %.9g}\n  },\n",
                        q->mean_to_input, q->rms_to_input, q->max_to_input);
}

static void print_segments(nsdf_cli_file *out, const nsdf_mux *mux, const nsdf_decoder *decoder) {
    nsdf_mux_segment s;
    nsdf_segment_info place;
    nsdf_cli_file_print(out, "  \"segments\": [");
    for (uint32_t i = 0; nsdf_mux_get_segment(mux, i, &s) == NSDF_OK; i++) {
        if (nsdf_get_segment_extent(decoder, i, &place) != NSDF_OK)
            break;
        nsdf_cli_file_print(out, "%s\n    {\"first\": %u, \"last\": %u, \"lead\": %d, \"trail\": %d, \"fade\": %u, ",
                            i ? "," : "", s.first_frame, s.last_frame, s.lead, s.trail, s.fade);
        nsdf_cli_file_print(out, "\"smallest_piece\": %.9g, \"offset\": %llu, \"size\": %llu, \"hash\": \"%016llx\"}",
                            place.smallest_piece, (unsigned long long)place.offset, (unsigned long long)place.size,
                            (unsigned long long)s.parameter_hash);
    }
    nsdf_cli_file_print(out, "\n  ],\n");
}

static void print_chunks(nsdf_cli_file *out, const nsdf_mux *mux) {
    nsdf_mux_chunk c;
    uint32_t i;
    nsdf_cli_file_print(out, "  \"other_chunks\": [");
    for (i = 0; nsdf_mux_get_chunk(mux, i, &c) == NSDF_OK; i++)
        nsdf_cli_file_print(out, "%s\n    {\"type\": \"%s\", \"before_segment\": %u, \"payload\": %llu}", i ? "," : "",
                            c.type, c.before, (unsigned long long)c.size);
    nsdf_cli_file_print(out, "%s],\n", i ? "\n  " : "");
}

static void print_metadata(nsdf_cli_file *out, const nsdf_mux *mux) {
    const char *key, *value;
    uint32_t i;
    nsdf_cli_file_print(out, "  \"metadata\": [");
    for (i = 0; nsdf_mux_get_metadata(mux, i, &key, &value) == NSDF_OK; i++) {
        nsdf_cli_file_print(out, "%s\n    [", i ? "," : "");
        nsdf_cli_file_print_json(out, key);
        nsdf_cli_file_print(out, ", ");
        nsdf_cli_file_print_json(out, value);
        nsdf_cli_file_print(out, "]");
    }
    nsdf_cli_file_print(out, "%s]\n}\n", i ? "\n  " : "");
}

int mux_info_print(const mux_input *input) {
    nsdf_mux *mux = mux_input_open(input);
    nsdf_decoder *decoder = NULL;
    nsdf_info info;
    nsdf_cli_file out;
    int result = NSDF_CLI_FAILURE;
    if (mux && nsdf_open_memory(&decoder, input->data, input->size, NULL, NULL) == NSDF_OK &&
        nsdf_get_info(decoder, &info) == NSDF_OK && nsdf_cli_file_open(&out, "-") == 0) {
        print_head(&out, input->name, &info);
        print_quality(&out, &info.quality);
        print_segments(&out, mux, decoder);
        print_chunks(&out, mux);
        print_metadata(&out, mux);
        if (nsdf_cli_file_close(&out) == 0)
            result = NSDF_CLI_SUCCESS;
    }
    nsdf_close(&decoder);
    nsdf_mux_close(&mux);
    return result;
}

/* ---- What is wrong ----------------------------------------------------------------------------------------------- */

/* Each segment by itself, so that a damaged one does not hide the next; returns how many are. */
static uint32_t check_segments(const mux_input *input, nsdf_decoder *decoder, uint32_t count) {
    uint32_t damaged = 0;
    for (uint32_t i = 0; i < count; i++) {
        nsdf_segment_info segment;
        nsdf_error error;
        const nsdf_status status = nsdf_get_segment_info(decoder, i, &segment);
        if (status == NSDF_OK)
            continue;
        nsdf_cli_get_error(decoder, status, &error);
        nsdf_cli_nsdf_error(input->name, &error);
        damaged++;
    }
    return damaged;
}

/* All that lies between and behind the segments; what check_segments has said already is not said again. */
static int check_chunks(const mux_input *input, uint32_t damaged) {
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    nsdf_decoder_options_init(&options);
    options.check_all = 1;
    const nsdf_status status = nsdf_open_memory(&decoder, input->data, input->size, &options, &error);
    nsdf_close(&decoder);
    if (status != NSDF_OK && (damaged == 0 || strcmp(error.chunk, "SEGM") != 0))
        nsdf_cli_nsdf_error(input->name, &error);
    return status == NSDF_OK ? 0 : -1;
}

int mux_info_validate(const mux_input *input) {
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    nsdf_info info;
    nsdf_status status = nsdf_open_memory(&decoder, input->data, input->size, NULL, &error);
    if (status != NSDF_OK) {
        nsdf_cli_nsdf_error(input->name, &error);
        return NSDF_CLI_FAILURE;
    }
    status = nsdf_get_info(decoder, &info);
    const uint32_t damaged = check_segments(input, decoder, info.segment_count);
    const int failed = check_chunks(input, damaged);
    nsdf_close(&decoder);
    if (status != NSDF_OK || damaged > 0 || failed)
        return NSDF_CLI_FAILURE;
    printf("%s: ok (%u frames, %u segments, hash %016llx)\n", input->name, info.frame_count, info.segment_count,
           (unsigned long long)info.parameter_hash);
    return NSDF_CLI_SUCCESS;
}
