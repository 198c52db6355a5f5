#include "enc_part.h"

#include "cli_util.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- Names -------------------------------------------------------------------------------------------------- */

/* "NAME.segments", the caller's to free; NULL after printing why. */
static char *folder_beside(const char *output) {
    const char *name = strcmp(output, "-") == 0 ? "nsdf-enc" : output;
    const size_t size = strlen(name) + sizeof ".segments";
    char *folder = malloc(size);
    if (folder)
        snprintf(folder, size, "%s.segments", name);
    else
        nsdf_cli_error("out of memory");
    return folder;
}

static int refuse_folder(const char *folder, int reason) {
    nsdf_cli_error("cannot make the folder '%s' for segments: %s", folder, strerror(reason));
    return -1;
}

int enc_parts_check(const char *output) {
    struct stat about;
    char *folder = folder_beside(output);
    int result = folder ? 0 : -1;
    if (folder && stat(folder, &about) == 0 && !S_ISDIR(about.st_mode))
        result = refuse_folder(folder, EEXIST);
    free(folder);
    return result;
}

int enc_parts_open(enc_parts *parts, const enc_plan *plan, const char *output) {
    *parts = (enc_parts){plan, folder_beside(output), NULL};
    if (!parts->folder)
        return -1;
    if (mkdir(parts->folder, 0777) == 0 || (errno == EEXIST && nsdf_cli_is_folder(parts->folder)))
        return 0;
    return refuse_folder(parts->folder, errno);
}

int enc_parts_open_temporary(enc_parts *parts, const enc_plan *plan) {
    const char *root = getenv("TMPDIR");
    const size_t size = (root ? strlen(root) : 0) + 64;
    char *path = malloc(size);
    *parts = (enc_parts){plan, NULL, NULL};
    if (path) {
        snprintf(path, size, "%s/nsdf-enc-XXXXXX", root && *root ? root : "/tmp");
        const int file = mkstemp(path);
        if (file >= 0) {
            unlink(path);
            parts->store = fdopen(file, "w+b");
        }
    }
    if (!parts->store)
        nsdf_cli_error("cannot make a file like '%s': %s", path ? path : "", strerror(errno));
    else
        setvbuf(parts->store, NULL, _IONBF, 0); /* another process writes into it */
    free(path);
    return parts->store ? 0 : -1;
}

void enc_parts_free(enc_parts *parts) {
    free(parts->folder);
    parts->folder = NULL;
    if (parts->store)
        fclose(parts->store);
    parts->store = NULL;
}

/* The path of a segment's file, with the hash of what it was made of in its name; the caller's to free. */
static char *part_path(const enc_parts *parts, uint32_t segment) {
    const size_t size = strlen(parts->folder) + 64;
    char *path = malloc(size);
    if (path)
        snprintf(path, size, "%s/%06u-%016llx.part", parts->folder, segment,
                 (unsigned long long)parts->plan->hashes[segment]);
    return path;
}

void enc_parts_remove(const enc_parts *parts) {
    for (uint32_t i = 0; i < parts->plan->count; i++) {
        char *path = part_path(parts, i);
        if (path)
            unlink(path);
        free(path);
    }
    rmdir(parts->folder);
}

/* ---- Fitting ------------------------------------------------------------------------------------------------ */

typedef struct fit_state {
    enc_part_progress progress;
    void *user;
} fit_state;

/* About how the time is spent. */
static int on_progress(void *user, const nsdf_progress *p) {
    static const double before[] = {0.0, 0.05, 0.9, 0.94}, share[] = {0.05, 0.85, 0.04, 0.06};
    const fit_state *s = user;
    return s->progress(s->user, before[p->stage] + share[p->stage] * p->fraction) ? NSDF_ABORT : NSDF_CONTINUE;
}

static int add_frames(const enc_plan *plan, const nsdf_span *span, nsdf_encoder *encoder) {
    const uint32_t *numbers = plan->list->numbers;
    nsdf_sequence_part part = {numbers[span->first] - numbers[span->first - span->lead],
                               numbers[span->last + span->trail] - numbers[span->last],
                               {0.0, 0.0, 0.0},
                               {0.0, 0.0, 0.0}};
    nsdf_encoder_error error;
    for (uint32_t i = span->first - span->lead; i <= span->last + span->trail; i++)
        if (enc_add_frame(encoder, plan->sequence, numbers[i]) != 0)
            return -1;
    memcpy(part.box_min, plan->box_min, sizeof part.box_min);
    memcpy(part.box_max, plan->box_max, sizeof part.box_max);
    if (nsdf_encoder_set_part(encoder, &part, &error) == NSDF_OK)
        return 0;
    nsdf_cli_error("%s", error.message);
    return -1;
}

static int append(void *user, const void *data, size_t size) {
    enc_part *part = user;
    unsigned char *grown = realloc(part->file, part->size + size);
    if (!grown)
        return -1;
    memcpy(grown + part->size, data, size);
    part->file = grown;
    part->size += size;
    return 0;
}

int enc_part_fit(const enc_plan *plan, uint32_t segment, enc_part_progress progress, void *user, enc_part *part) {
    const nsdf_encoder_options options = enc_plan_options(plan, segment);
    fit_state state = {progress, user};
    nsdf_encoder *encoder = NULL;
    nsdf_encoder_error error;
    memset(part, 0, sizeof *part);
    nsdf_status status = nsdf_encoder_create(&encoder, &options, &error);
    if (status == NSDF_OK && add_frames(plan, &plan->spans[segment], encoder) != 0) {
        nsdf_encoder_close(&encoder);
        return -1;
    }
    if (status == NSDF_OK)
        status = nsdf_encoder_run(encoder, on_progress, &state, &error);
    if (status == NSDF_OK)
        status = nsdf_encoder_write(encoder, append, part, &error);
    if (status == NSDF_OK)
        status = nsdf_encoder_get_stats(encoder, &part->stats);
    if (status != NSDF_OK && status != NSDF_CANCELLED)
        nsdf_cli_error("segment %u: %s", segment + 1, error.message);
    nsdf_encoder_close(&encoder);
    return status == NSDF_OK ? 0 : -1;
}

void enc_part_free(enc_part *part) {
    free(part->file);
    memset(part, 0, sizeof *part);
}

/* ---- Files: the stats, then the .nsdf file ------------------------------------------------------------------ */

static int read_whole(FILE *file, long size, enc_part *part) {
    if (size <= (long)sizeof part->stats || fseek(file, 0, SEEK_SET) != 0)
        return -1;
    part->size = (size_t)size - sizeof part->stats;
    part->file = malloc(part->size);
    return part->file && fread(&part->stats, sizeof part->stats, 1, file) == 1 &&
                   fread(part->file, part->size, 1, file) == 1 && part->stats.file_size == part->size
               ? 0
               : -1;
}

static FILE *open_part(const enc_parts *parts, uint32_t segment) {
    if (parts->store)
        return parts->store;
    char *path = part_path(parts, segment);
    FILE *file = path ? fopen(path, "rb") : NULL;
    free(path);
    return file;
}

int enc_part_read(const enc_parts *parts, uint32_t segment, enc_part *part) {
    FILE *file = open_part(parts, segment);
    int result = -1;
    memset(part, 0, sizeof *part);
    if (file && fseek(file, 0, SEEK_END) == 0)
        result = read_whole(file, ftell(file), part);
    if (file && file != parts->store)
        fclose(file);
    if (result != 0)
        enc_part_free(part);
    return result;
}

/* In place of what was stored before. */
static int store_part(FILE *store, const enc_part *part) {
    rewind(store);
    if (ftruncate(fileno(store), 0) == 0 && fwrite(&part->stats, sizeof part->stats, 1, store) == 1 &&
        fwrite(part->file, part->size, 1, store) == 1 && fflush(store) == 0)
        return 0;
    nsdf_cli_error("cannot keep a segment: %s", strerror(errno));
    return -1;
}

int enc_part_write(const enc_parts *parts, uint32_t segment, const enc_part *part) {
    nsdf_cli_file file;
    if (parts->store)
        return store_part(parts->store, part);
    char *path = part_path(parts, segment);
    const int opened = path && nsdf_cli_file_open(&file, path) == 0;
    free(path);
    if (!opened)
        return -1;
    (void)nsdf_cli_file_write(&file, &part->stats, sizeof part->stats);
    (void)nsdf_cli_file_write(&file, part->file, part->size);
    return nsdf_cli_file_publish(&file);
}
