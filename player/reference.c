#include "reference.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "cli_util.h"
#include "obj_mesh.h"

struct play_reference {
    const char *folder; /* borrowed */
    char **names;       /* owned, in the folder */
    uint32_t count, capacity;
    uint32_t loaded; /* index + 1; 0 = none */
    play_obj_mesh mesh;
};

static int no_memory(void) {
    nsdf_cli_error("out of memory");
    return NSDF_CLI_FAILURE;
}

/* ---- Names ----------------------------------------------------------------------------------------------- */

int play_reference_order(const char *a, const char *b) {
    while (*a && *b) {
        if (isdigit((unsigned char)*a) && isdigit((unsigned char)*b)) {
            a += strspn(a, "0");
            b += strspn(b, "0");
            const size_t digits_a = strspn(a, "0123456789"), digits_b = strspn(b, "0123456789");
            const int difference = digits_a == digits_b ? strncmp(a, b, digits_a) : digits_a < digits_b ? -1 : 1;
            if (difference)
                return difference;
            a += digits_a;
            b += digits_b;
        } else if (*a != *b) {
            break;
        } else {
            a++;
            b++;
        }
    }
    return (unsigned char)*a - (unsigned char)*b;
}

static int compare_names(const void *a, const void *b) {
    const char *const *x = a, *const *y = b;
    const int order = play_reference_order(*x, *y);
    return order ? order : strcmp(*x, *y);
}

static int add_name(play_reference *r, const char *name) {
    if (r->count == r->capacity) {
        const uint32_t capacity = 2 * r->capacity + 64;
        char **names = realloc(r->names, capacity * sizeof *names);
        if (!names)
            return no_memory();
        r->names = names;
        r->capacity = capacity;
    }
    r->names[r->count] = malloc(strlen(name) + 1);
    if (!r->names[r->count])
        return no_memory();
    strcpy(r->names[r->count++], name);
    return NSDF_CLI_SUCCESS;
}

static int list_folder(play_reference *r) {
    DIR *folder = opendir(r->folder);
    if (!folder) {
        nsdf_cli_error("%s: %s", r->folder, strerror(errno));
        return NSDF_CLI_FAILURE;
    }
    int result = NSDF_CLI_SUCCESS;
    for (const struct dirent *entry; result == NSDF_CLI_SUCCESS && (entry = readdir(folder));) {
        const size_t length = strlen(entry->d_name);
        if (length > 4 && strcasecmp(entry->d_name + length - 4, ".obj") == 0)
            result = add_name(r, entry->d_name);
    }
    closedir(folder);
    if (r->count > 0)
        qsort(r->names, r->count, sizeof *r->names, compare_names);
    return result;
}

int play_reference_open(play_reference **reference, const char *folder, uint32_t count) {
    play_reference *r = calloc(1, sizeof *r);
    if (!r)
        return no_memory();
    r->folder = folder;
    int result = list_folder(r);
    if (result == NSDF_CLI_SUCCESS && r->count != count) {
        nsdf_cli_error("%s: %lu OBJ meshes, but the file has %lu frames", folder, (unsigned long)r->count,
                       (unsigned long)count);
        result = NSDF_CLI_FAILURE;
    }
    if (result == NSDF_CLI_SUCCESS)
        *reference = r;
    else
        play_reference_close(r);
    return result;
}

void play_reference_close(play_reference *r) {
    if (!r)
        return;
    for (uint32_t i = 0; i < r->count; i++)
        free(r->names[i]);
    free(r->names);
    play_obj_free(&r->mesh);
    free(r);
}

/* ---- Meshes ---------------------------------------------------------------------------------------------- */

/* All of a file and '\0'; NULL with errno set. */
static char *read_text(const char *path) {
    char *text = NULL;
    size_t used = 0, capacity = 0, got = 1;
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    while (got > 0) {
        if (capacity - used < 2) {
            capacity = 2 * capacity + (1 << 16);
            char *grown = realloc(text, capacity);
            if (!grown)
                break;
            text = grown;
        }
        got = fread(text + used, 1, capacity - used - 1, file);
        used += got;
    }
    const int failed = got > 0 || ferror(file) ? errno : 0;
    fclose(file);
    if (failed) {
        free(text);
        errno = failed;
        return NULL;
    }
    text[used] = '\0';
    return text;
}

static int load(play_reference *r, const char *path) {
    unsigned long line;
    char *text = read_text(path);
    if (!text) {
        nsdf_cli_error("%s: %s", path, strerror(errno));
        return NSDF_CLI_FAILURE;
    }
    const char *failure = play_obj_parse(&r->mesh, text, &line);
    free(text);
    if (!failure)
        return NSDF_CLI_SUCCESS;
    nsdf_cli_error("%s:%lu: %s", path, line, failure);
    return NSDF_CLI_FAILURE;
}

int play_reference_load(play_reference *r, uint32_t index, nsdf_mesh_view *view) {
    int result = NSDF_CLI_SUCCESS;
    if (r->loaded != index + 1) {
        const char *name = r->names[index];
        char *path = malloc(strlen(r->folder) + strlen(name) + 2);
        if (!path)
            return no_memory();
        sprintf(path, "%s/%s", r->folder, name);
        r->loaded = 0;
        result = load(r, path);
        free(path);
    }
    if (result != NSDF_CLI_SUCCESS)
        return result;
    r->loaded = index + 1;
    *view = play_obj_view(&r->mesh);
    return NSDF_CLI_SUCCESS;
}
