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
    uint32_t *frames; /* [count], ascending: of each mesh; NULL = mesh i is frame i */
    uint32_t loaded;  /* index + 1; 0 = none */
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

/* ---- Times ----------------------------------------------------------------------------------------------- */

/* The last number in a name; 0 when it has none, or one too large. */
static int number_of(const char *name, uint32_t *number) {
    const char *end = name + strlen(name);
    while (end > name && !isdigit((unsigned char)end[-1]))
        end--;
    const char *begin = end;
    while (begin > name && isdigit((unsigned char)begin[-1]))
        begin--;
    const unsigned long long value = begin < end && end - begin < 19 ? strtoull(begin, NULL, 10) : UINT32_MAX;
    *number = (uint32_t)value;
    return value < UINT32_MAX;
}

/* As nsdf-cmp has it: meshes are as far apart in time as the numbers in their names, from the first on. */
static int number_meshes(play_reference *r) {
    uint32_t first = 0;
    for (uint32_t i = 0; i < r->count; i++) {
        if (!number_of(r->names[i], &r->frames[i]) || (i > 0 && r->frames[i] - first <= r->frames[i - 1]))
            return 0;
        first = i == 0 ? r->frames[0] : first;
        r->frames[i] -= first;
    }
    return 1;
}

/* Whether they reach the last frame, give or take one of their intervals. */
static int reach(const play_reference *r, uint32_t last) {
    uint32_t interval = 1;
    for (uint32_t i = 1; i < r->count; i++)
        if (r->frames[i] - r->frames[i - 1] > interval)
            interval = r->frames[i] - r->frames[i - 1];
    return (uint64_t)r->frames[r->count - 1] + interval > last;
}

/* For a folder of another number of meshes than the file has frames. */
static int match_times(play_reference *r, uint32_t count) {
    const unsigned long meshes = r->count, frames = count;
    if (r->count == 0 || !(r->frames = malloc(r->count * sizeof *r->frames))) {
        nsdf_cli_error("%s: %lu OBJ meshes, but the file has %lu frames", r->folder, meshes, frames);
        return NSDF_CLI_FAILURE;
    }
    if (!number_meshes(r)) {
        nsdf_cli_error("%s: %lu OBJ meshes, but the file has %lu frames: expected a number of its own in each name, "
                       "which tells its time",
                       r->folder, meshes, frames);
        return NSDF_CLI_FAILURE;
    }
    if (!reach(r, count - 1)) {
        nsdf_cli_error("%s: %lu OBJ meshes, but the file has %lu frames: by its number the last mesh is frame %lu, "
                       "expected about %lu",
                       r->folder, meshes, frames, (unsigned long)r->frames[r->count - 1], frames - 1);
        return NSDF_CLI_FAILURE;
    }
    nsdf_cli_warn("%s: %lu OBJ meshes for %lu frames: of each frame the mesh nearest in time is shown", r->folder,
                  meshes, frames);
    return NSDF_CLI_SUCCESS;
}

/* The earlier of two that are equally near. */
static uint32_t nearest_mesh(const play_reference *r, uint32_t frame) {
    uint32_t best = 0;
    if (!r->frames)
        return frame;
    while (best + 1 < r->count && r->frames[best + 1] <= frame)
        best++;
    return best + 1 < r->count && r->frames[best + 1] - frame < frame - r->frames[best] ? best + 1 : best;
}

/* ---- Folders --------------------------------------------------------------------------------------------- */

int play_reference_open(play_reference **reference, const char *folder, uint32_t count) {
    play_reference *r = calloc(1, sizeof *r);
    if (!r)
        return no_memory();
    r->folder = folder;
    int result = list_folder(r);
    if (result == NSDF_CLI_SUCCESS && r->count != count)
        result = match_times(r, count);
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
    free(r->frames);
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

int play_reference_load(play_reference *r, uint32_t frame, nsdf_mesh_view *view) {
    const uint32_t index = nearest_mesh(r, frame);
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
