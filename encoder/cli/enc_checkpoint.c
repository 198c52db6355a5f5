#include "enc_checkpoint.h"

#include "cli_util.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const double default_seconds = 60.0;

/* ---- Going on ------------------------------------------------------------------------------------------- */

/* The file whole, to be freed; NULL after printing why. */
static unsigned char *read_file(const char *path, size_t size) {
    unsigned char *data = malloc(size + 1);
    FILE *file = data ? fopen(path, "rb") : NULL;
    const int read = file && fread(data, 1, size, file) == size;
    if (!read)
        nsdf_cli_error("cannot read '%s': %s", path, strerror(data ? errno : ENOMEM));
    if (file)
        fclose(file);
    if (read)
        return data;
    free(data);
    return NULL;
}

static int resume(enc_checkpoint *checkpoint, size_t size, nsdf_encoder *encoder) {
    nsdf_encoder_error error;
    uint64_t steps;
    unsigned char *data = read_file(checkpoint->path, size);
    if (!data)
        return -1;
    const nsdf_status status = nsdf_encoder_resume(encoder, data, size, &steps, &error);
    free(data);
    if (status != NSDF_OK) {
        nsdf_cli_error("%s: %s (without the file, fitting begins anew)", checkpoint->path, error.message);
        return -1;
    }
    checkpoint->there = 1;
    nsdf_cli_say("going on from '%s': %llu steps are done", checkpoint->path, (unsigned long long)steps);
    return 0;
}

/* ---- Writing -------------------------------------------------------------------------------------------- */

/* Fitting is worth more than its checkpoints: what cannot be written is told, and tried again with the next. */
static void write_checkpoint(void *user, const void *data, size_t size) {
    enc_checkpoint *checkpoint = user;
    nsdf_cli_file file;
    if (nsdf_cli_file_open(&file, checkpoint->path) != 0)
        return;
    (void)nsdf_cli_file_write(&file, data, size);
    if (nsdf_cli_file_publish(&file) == 0)
        checkpoint->there = 1;
}

/* So that a name that cannot be written is told before fitting. */
static int check_folder(const char *path) {
    const char *slash = strrchr(path, '/');
    char *folder = malloc(strlen(path) + 2);
    if (folder && slash)
        snprintf(folder, (size_t)(slash - path) + 2, "%s", path);
    else if (folder)
        snprintf(folder, 2, ".");
    const int missing = !folder || access(folder, W_OK | X_OK) != 0;
    if (missing)
        nsdf_cli_error("cannot write '%s': %s", path, strerror(folder ? errno : ENOMEM));
    free(folder);
    return missing ? -1 : 0;
}

int enc_checkpoint_open(enc_checkpoint *checkpoint, const enc_options *options, nsdf_encoder *encoder) {
    struct stat about;
    nsdf_encoder_error error;
    checkpoint->path = options->checkpoint;
    checkpoint->there = 0;
    if (!checkpoint->path)
        return 0;
    if (check_folder(checkpoint->path) != 0)
        return -1;
    const double seconds = options->checkpoint_every < 0.0 ? default_seconds : options->checkpoint_every;
    const int found = stat(checkpoint->path, &about) == 0;
    if (found && !S_ISREG(about.st_mode)) {
        nsdf_cli_error("cannot write '%s': not a file", checkpoint->path);
        return -1;
    }
    if (found && resume(checkpoint, (size_t)about.st_size, encoder) != 0)
        return -1;
    if (nsdf_encoder_set_checkpoint(encoder, seconds, write_checkpoint, checkpoint, &error) == NSDF_OK)
        return 0;
    nsdf_cli_error("%s", error.message);
    return -1;
}

void enc_checkpoint_close(const enc_checkpoint *checkpoint, int ended_early) {
    if (!checkpoint->there)
        return;
    if (ended_early)
        nsdf_cli_say("'%s' stays: the same command goes on with fitting", checkpoint->path);
    else if (unlink(checkpoint->path) != 0 && errno != ENOENT)
        nsdf_cli_warn("cannot remove '%s': %s", checkpoint->path, strerror(errno));
}
