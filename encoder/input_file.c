#include "input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "gltf_read.h"
#include "input_error.h"
#include "obj_read.h"
#include "ply_header.h"
#include "ply_read.h"
#include "stl_read.h"

#define MAX_FILE_SIZE (INT64_C(1) << 32)

static nsdf_status read_bytes(int file, const char *path, char *text, size_t size, nsdf_encoder_error *error) {
    size_t done = 0;
    while (done < size) {
        ssize_t n = read(file, text + done, size - done);
        if (n > 0) {
            done += (size_t)n;
        } else if (n == 0 || errno != EINTR) {
            return nsdf_input_fail(error, NSDF_IO, "%s: cannot read the file", nsdf_show_path(path).text);
        }
    }
    text[size] = '\0';
    return NSDF_OK;
}

static nsdf_status read_open_file(int file, const char *path, char **text, size_t *size, nsdf_encoder_error *error) {
    nsdf_shown_path shown = nsdf_show_path(path);
    struct stat info;
    if (fstat(file, &info) != 0 || !S_ISREG(info.st_mode)) {
        return nsdf_input_fail(error, NSDF_IO, "%s: not a regular file", shown.text);
    }
    if ((int64_t)info.st_size > MAX_FILE_SIZE || (uint64_t)info.st_size >= SIZE_MAX) {
        return nsdf_input_fail(error, NSDF_LIMIT, "%s: too large (meshes of up to 4 GiB are read)", shown.text);
    }
    char *bytes = malloc((size_t)info.st_size + 1);
    if (bytes == NULL) {
        return nsdf_input_no_memory(error);
    }
    nsdf_status status = read_bytes(file, path, bytes, (size_t)info.st_size, error);
    if (status != NSDF_OK) {
        free(bytes);
        return status;
    }
    *text = bytes;
    *size = (size_t)info.st_size;
    return NSDF_OK;
}

nsdf_status nsdf_input_read(const char *path, char **text, size_t *size, nsdf_encoder_error *error) {
    int file = open(path, O_RDONLY | O_NONBLOCK); /* opening a pipe must not wait for a writer */
    if (file < 0) {
        const char *why = errno == ENOENT   ? "no such file"
                          : errno == EACCES ? "no permission to read it"
                                            : "cannot open it";
        return nsdf_input_fail(error, NSDF_IO, "%s: %s", nsdf_show_path(path).text, why);
    }
    nsdf_status status = read_open_file(file, path, text, size, error);
    (void)close(file);
    return status;
}

nsdf_status nsdf_input_read_mesh(const char *path, nsdf_file_mesh *mesh, nsdf_encoder_error *error) {
    char *text = NULL;
    size_t size = 0;
    nsdf_file_mesh_clear(mesh);
    nsdf_status status = nsdf_input_read(path, &text, &size, error);
    if (status == NSDF_OK && (nsdf_input_has_suffix(path, ".ply") || nsdf_ply_begins(text))) {
        status = nsdf_ply_parse(path, text, size, mesh, error);
    } else if (status == NSDF_OK && (nsdf_input_has_suffix(path, ".stl"))) {
        status = nsdf_stl_parse(path, text, size, mesh, error);
    } else if (status == NSDF_OK && (nsdf_input_has_suffix(path, ".glb") || nsdf_input_has_suffix(path, ".gltf"))) {
        status = nsdf_gltf_parse(path, text, size, mesh, error);
    } else if (status == NSDF_OK) {
        status = nsdf_obj_parse(path, text, size, mesh, error);
    }
    free(text);
    return status;
}

bool nsdf_input_has_suffix(const char *name, const char *suffix) {
    size_t length = strlen(name), n = strlen(suffix);
    if (length <= n) {
        return false;
    }
    for (size_t i = 0; i < n; i++) {
        char c = name[length - n + i];
        c = c >= 'A' && c <= 'Z' ? (char)(c | 0x20) : c;
        if (c != suffix[i]) {
            return false;
        }
    }
    return true;
}
