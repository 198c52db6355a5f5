#include "enc_frames.h"

#include "cli_util.h"

#include <stdio.h>

/* The frames that have a file, or of those every `step`th and the last. */
static int take_every(const nsdf_sequence *sequence, uint32_t step, nsdf_cli_list *list) {
    const uint32_t count = nsdf_sequence_mesh_count(sequence);
    uint32_t kept = 0;
    const int code = nsdf_cli_list_all(list, count);
    for (uint32_t i = 0; i < list->count; i++)
        if (i % step == 0 || i + 1 == count)
            list->numbers[kept++] = nsdf_sequence_mesh_frame(sequence, i);
    list->count = kept;
    return code;
}

/* Those of --frames that have a file. */
static int take_named(const nsdf_sequence *sequence, const char *text, nsdf_cli_list *list) {
    uint32_t kept = 0;
    const int code = nsdf_cli_list_parse(list, "--frames", text, nsdf_sequence_frame_count(sequence));
    if (code != NSDF_CLI_SUCCESS)
        return code;
    nsdf_cli_list_sort(list);
    for (uint32_t i = 0; i < list->count; i++)
        if (nsdf_sequence_frame_path(sequence, list->numbers[i]))
            list->numbers[kept++] = list->numbers[i];
    list->count = kept;
    return kept > 0 ? code : nsdf_cli_usage_error("--frames: the file of frame %s is missing", text);
}

int enc_choose_frames(const enc_options *o, const nsdf_sequence *sequence, nsdf_cli_list *list) {
    return o->frames ? take_named(sequence, o->frames, list)
                     : take_every(sequence, o->frame_step ? o->frame_step : 1, list);
}

uint32_t enc_explain_missing(const nsdf_sequence *sequence, char *text, size_t size) {
    char numbers[200];
    const uint32_t missing = nsdf_sequence_missing(sequence, numbers, sizeof numbers);
    text[0] = '\0';
    if (missing > 0 && *numbers)
        snprintf(text, size,
                 "no file%s number%s %s: the surface there is interpolated in time (--numbers ignore: files follow "
                 "each other)",
                 missing > 1 ? "s have the" : " has the", missing > 1 ? "s" : "", numbers);
    return missing;
}

int enc_add_frame(nsdf_encoder *encoder, nsdf_sequence *sequence, uint32_t frame) {
    char name[400];
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    if (nsdf_sequence_load(sequence, frame, &mesh, &error) != NSDF_OK) {
        nsdf_cli_error("%s", error.message); /* names the file */
        return -1;
    }
    if (nsdf_encoder_add_frame(encoder, frame, &mesh, &error) != NSDF_OK) {
        nsdf_sequence_name_frame(sequence, frame, name, sizeof name);
        nsdf_cli_error("%s: %s", name, error.message);
        return -1;
    }
    return 0;
}
