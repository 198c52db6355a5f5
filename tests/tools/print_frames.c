/* print_frames INPUT: the vertices of every frame of a sequence, each behind a line with its time. */
#include "nsdf/sequence.h"

#include <stdio.h>
#include <stdlib.h>

static int print_frame(nsdf_sequence *sequence, uint32_t frame) {
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    uint32_t num, den;
    if (nsdf_sequence_load(sequence, frame, &mesh, &error) != NSDF_OK) {
        fprintf(stderr, "print_frames: %s\n", error.message);
        return -1;
    }
    nsdf_sequence_rate(sequence, &num, &den);
    printf("frame %.9g\n", (double)frame * den / num);
    for (size_t i = 0; i < mesh.vertex_count; i++)
        printf("%.9g %.9g %.9g\n", mesh.positions[3 * i], mesh.positions[3 * i + 1], mesh.positions[3 * i + 2]);
    return 0;
}

int main(int argc, char **argv) {
    nsdf_sequence *sequence = NULL;
    nsdf_encoder_error error;
    const char *input = argc == 2 ? argv[1] : "";
    int result = 0;
    if (nsdf_sequence_open(&sequence, &input, 1, NULL, &error) != NSDF_OK) {
        fprintf(stderr, "print_frames: %s\n", error.message);
        return EXIT_FAILURE;
    }
    for (uint32_t i = 0; result == 0 && i < nsdf_sequence_mesh_count(sequence); i++)
        result = print_frame(sequence, nsdf_sequence_mesh_frame(sequence, i));
    nsdf_sequence_close(&sequence);
    return result == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
