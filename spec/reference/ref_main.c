/* nsdf-ref FILE: prints what the reference decoder finds in a file. Exit status 1 with one line on any fault. */

#include "nsdf_ref.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

static int complain(const char *name, const char *message) {
    fprintf(stderr, "nsdf-ref: %s: %s\n", name, message);
    return 1;
}

/* NULL if the file cannot be read whole. */
static uint8_t *read_whole(FILE *in, size_t *size) {
    size_t room = 1 << 16;
    uint8_t *data = malloc(room);
    *size = 0;
    while (data) {
        *size += fread(data + *size, 1, room - *size, in);
        if (*size < room)
            break;
        uint8_t *larger = realloc(data, 2 * room);
        if (!larger)
            free(data);
        data = larger;
        room *= 2;
    }
    if (data && ferror(in)) {
        free(data);
        data = NULL;
    }
    return data;
}

static void print_head(const ref_file *f) {
    printf("rate %" PRIu32 "/%" PRIu32 "\nframes %" PRIu32 "\nsegments %" PRIu32 "\n", f->rate_num, f->rate_den,
           f->frame_count, f->segment_count);
    printf("box %.9g %.9g %.9g to %.9g %.9g %.9g\n", f->box_min[0], f->box_min[1], f->box_min[2], f->box_max[0],
           f->box_max[1], f->box_max[2]);
    printf("centre %.9g %.9g %.9g\nscale %.9g\n", f->centre[0], f->centre[1], f->centre[2], f->scale);
    printf("domain %.6g %.6g %.6g to %.6g %.6g %.6g\n", (double)f->domain_min[0], (double)f->domain_min[1],
           (double)f->domain_min[2], (double)f->domain_max[0], (double)f->domain_max[1], (double)f->domain_max[2]);
    printf("resolution %" PRIu32 "\nbound %.6g\nbytes %" PRIu64 "\n", f->default_resolution,
           (double)f->extraction_bound, f->file_size);
}

static int print_segments(const ref_file *f) {
    int wrong = 0;
    for (uint32_t i = 0; i < f->segment_count; i++) {
        const ref_segment *s = &f->segments[i];
        const int same = s->hash == s->stored_hash;
        printf("segment %" PRIu32 ": frames %" PRIu32 " to %" PRIu32 ", lead %" PRId32 ", trail %" PRId32
               ", fade %" PRIu32 ", smallest piece %.6g, %" PRIu32 " parts, %" PRIu64 " parameters, hash %016" PRIx64
               " %s\n",
               i, s->first_frame, s->last_frame, s->lead, s->trail, s->fade, (double)s->smallest_piece, s->part_count,
               s->parameter_count, s->hash, same ? "equal" : "DIFFERS");
        wrong |= !same;
    }
    return wrong;
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fputs("usage: nsdf-ref FILE\n", stderr);
        return 2;
    }
    FILE *in = fopen(argv[1], "rb");
    if (!in)
        return complain(argv[1], "cannot open");
    size_t size;
    uint8_t *data = read_whole(in, &size);
    fclose(in);
    if (!data)
        return complain(argv[1], "cannot read");
    ref_file *file;
    const char *message;
    const ref_status status = ref_open(data, size, &file, &message);
    free(data);
    if (status != REF_OK)
        return complain(argv[1], message);
    print_head(file);
    const int wrong = print_segments(file);
    ref_close(&file);
    return wrong ? complain(argv[1], "a parameter hash differs") : 0;
}
