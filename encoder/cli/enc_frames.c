#include "enc_frames.h"

#include "cli_util.h"

int enc_choose_frames(const enc_options *o, uint32_t count, nsdf_cli_list *list) {
    int code = o->frames ? nsdf_cli_list_parse(list, "--frames", o->frames, count) : nsdf_cli_list_all(list, count);
    uint32_t kept = 0;
    nsdf_cli_list_sort(list);
    for (uint32_t i = 0; o->frame_step && i < list->count; i++)
        if (i % o->frame_step == 0 || i + 1 == count)
            list->numbers[kept++] = i;
    if (o->frame_step)
        list->count = kept;
    return code;
}

int enc_add_frame(nsdf_encoder *encoder, nsdf_sequence *sequence, uint32_t index) {
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    if (nsdf_sequence_load(sequence, index, &mesh, &error) != NSDF_OK) {
        nsdf_cli_error("%s", error.message); /* names the file */
        return -1;
    }
    if (nsdf_encoder_add_frame(encoder, index, &mesh, &error) != NSDF_OK) {
        nsdf_cli_error("%s: %s", nsdf_sequence_frame_path(sequence, index), error.message);
        return -1;
    }
    return 0;
}
