#include "sequence_paths.h"

#include <dirent.h>
#include <errno.h>
#include <glob.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "input_error.h"
#include "input_file.h"
#include "number_pattern.h"
#include "obj_number.h"

#define MAX_LINE 4096 /* of a list file, with the zero */

/* ---- Lists ---- */

void nsdf_path_list_free(nsdf_path_list *list) {
    for (size_t i = 0; i < list->count; i++) {
        free(list->items[i].path);
    }
    free(list->items);
    free(list->timed_list);
    *list = (nsdf_path_list){0};
}

/* Takes `path` over, also on failure; NULL counts as memory that ran out. */
static nsdf_status append(nsdf_path_list *list, char *path, nsdf_encoder_error *error) {
    if (path != NULL && list->count == list->capacity) {
        size_t capacity = 2 * list->capacity + 64;
        nsdf_frame_file *items = realloc(list->items, capacity * sizeof *items);
        if (items == NULL) {
            free(path);
            return nsdf_input_no_memory(error);
        }
        list->items = items;
        list->capacity = capacity;
    }
    if (path == NULL) {
        return nsdf_input_no_memory(error);
    }
    list->items[list->count++] = (nsdf_frame_file){.path = path};
    return NSDF_OK;
}

/* The first `folder_length` bytes of `folder` (which may end in '/'), and a name in it. */
static char *join(const char *folder, size_t folder_length, const char *name) {
    bool slash = folder_length > 0 && folder[folder_length - 1] != '/';
    size_t length = folder_length + slash + strlen(name) + 1;
    char *path = malloc(length);
    if (path != NULL) {
        snprintf(path, length, "%.*s%s%s", (int)folder_length, folder, slash ? "/" : "", name);
    }
    return path;
}

/* Length of the part of a path that names the folder, with its '/'; 0 when there is none. */
static size_t folder_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash != NULL ? (size_t)(slash - path) + 1 : 0;
}

/* ---- Order ---- */

static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

static const char *skip_zeros(const char *p) {
    while (p[0] == '0' && is_digit(p[1])) {
        p++;
    }
    return p;
}

static size_t count_digits(const char *p) {
    size_t n = 0;
    while (is_digit(p[n])) {
        n++;
    }
    return n;
}

int nsdf_natural_compare(const char *a, const char *b) {
    const char *whole_a = a, *whole_b = b;
    while (*a != '\0' && *b != '\0') {
        if (is_digit(*a) && is_digit(*b)) {
            a = skip_zeros(a);
            b = skip_zeros(b);
            size_t n = count_digits(a), m = count_digits(b);
            int order = n != m ? (n < m ? -1 : 1) : memcmp(a, b, n);
            if (order != 0) {
                return order;
            }
            a += n;
            b += m;
        } else if (*a != *b) {
            break;
        } else {
            a++;
            b++;
        }
    }
    int order = (int)(unsigned char)*a - (int)(unsigned char)*b;
    return order != 0 ? order : strcmp(whole_a, whole_b); /* 1 and 01 must not be equal */
}

static int compare_paths(const void *a, const void *b) {
    return nsdf_natural_compare(((const nsdf_frame_file *)a)->path, ((const nsdf_frame_file *)b)->path);
}

static void sort_paths(nsdf_path_list *list, size_t first) {
    if (list->count > first) {
        qsort(list->items + first, list->count - first, sizeof *list->items, compare_paths);
    }
}

/* ---- Kinds of files ---- */

typedef enum path_kind { PATH_MISSING, PATH_FILE, PATH_FOLDER, PATH_OTHER } path_kind;

static path_kind kind_of(const char *path) {
    struct stat info;
    if (stat(path, &info) != 0) {
        return PATH_MISSING;
    }
    return S_ISREG(info.st_mode) ? PATH_FILE : S_ISDIR(info.st_mode) ? PATH_FOLDER : PATH_OTHER;
}

/* ---- Folders and patterns ---- */

/* Calls `chosen` for the name of every entry that is not hidden, and appends the regular files among those it wants. */
static nsdf_status append_entries(nsdf_path_list *list, DIR *entries, const char *folder, size_t length,
                                  bool (*chosen)(const void *what, const char *name), const void *what,
                                  nsdf_encoder_error *error) {
    const struct dirent *entry;
    while ((entry = readdir(entries)) != NULL) {
        if (entry->d_name[0] == '.' || !chosen(what, entry->d_name)) {
            continue;
        }
        char *path = join(folder, length, entry->d_name);
        if (path != NULL && kind_of(path) != PATH_FILE) {
            free(path);
            continue;
        }
        nsdf_status status = append(list, path, error);
        if (status != NSDF_OK) {
            return status;
        }
    }
    return NSDF_OK;
}

static nsdf_status list_folder(nsdf_path_list *list, const char *folder, size_t length,
                               bool (*chosen)(const void *what, const char *name), const void *what,
                               nsdf_encoder_error *error) {
    char *path = length > 0 ? join(folder, length, "") : join(".", 1, "");
    if (path == NULL) {
        return nsdf_input_no_memory(error);
    }
    DIR *entries = opendir(path);
    nsdf_status status;
    if (entries == NULL) {
        const char *why = errno == ENOENT ? "no such folder" : "cannot read folder";
        status = nsdf_input_fail(error, NSDF_IO, "%s '%s'", why, nsdf_show_path(path).text);
    } else {
        status = append_entries(list, entries, folder, length, chosen, what, error);
        (void)closedir(entries);
    }
    free(path);
    return status;
}

static bool has_suffix(const void *suffix, const char *name) {
    return nsdf_input_has_suffix(name, suffix);
}

/* A folder may hold the same frames in several kinds of files: the first kind that is there is enough. */
static nsdf_status expand_folder(nsdf_path_list *list, const char *folder, nsdf_encoder_error *error) {
    static const char *const kinds[] = {".obj", ".ply", ".stl", ".glb", ".gltf"};
    size_t first = list->count;
    nsdf_status status = NSDF_OK;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds && status == NSDF_OK && list->count == first; i++) {
        status = list_folder(list, folder, strlen(folder), has_suffix, kinds[i], error);
    }
    if (status == NSDF_OK && list->count == first) {
        return nsdf_input_fail(error, NSDF_IO, "empty folder '%s': no .obj, .ply, .stl, .glb or .gltf files",
                               nsdf_show_path(folder).text);
    }
    sort_paths(list, first);
    return status;
}

static bool matches_pattern(const void *pattern, const char *name) {
    uint64_t number;
    return nsdf_number_pattern_match(pattern, name, &number);
}

/* Names that differ in the number only: their natural order is that of the numbers. */
static nsdf_status expand_pattern(nsdf_path_list *list, const char *input, const nsdf_number_pattern *pattern,
                                  nsdf_encoder_error *error) {
    size_t first = list->count;
    nsdf_status status = list_folder(list, input, folder_length(input), matches_pattern, pattern, error);
    if (status == NSDF_OK && list->count == first) {
        return nsdf_input_fail(error, NSDF_IO, "no file matches '%s'", nsdf_show_path(input).text);
    }
    sort_paths(list, first);
    return status;
}

static nsdf_status append_found(nsdf_path_list *list, const glob_t *found, nsdf_encoder_error *error) {
    nsdf_status status = NSDF_OK;
    for (size_t i = 0; i < found->gl_pathc && status == NSDF_OK; i++) {
        if (kind_of(found->gl_pathv[i]) == PATH_FILE) {
            status = append(list, strdup(found->gl_pathv[i]), error);
        }
    }
    return status;
}

static nsdf_status expand_glob(nsdf_path_list *list, const char *input, nsdf_encoder_error *error) {
    size_t first = list->count;
    glob_t found;
    int result = glob(input, GLOB_NOSORT, NULL, &found);
    if (result == GLOB_NOSPACE) {
        return nsdf_input_no_memory(error);
    }
    nsdf_status status = result == 0 ? append_found(list, &found, error) : NSDF_OK;
    globfree(&found);
    if (status == NSDF_OK && list->count == first) {
        return nsdf_input_fail(error, NSDF_IO, "no file matches '%s'", nsdf_show_path(input).text);
    }
    sort_paths(list, first);
    return status;
}

/* ---- List files ---- */

/* Cuts blanks and the line end off, and returns the first character that is not blank. */
static char *trim(char *line) {
    size_t length = strlen(line);
    while (length > 0 && strchr(" \t\r\n", line[length - 1]) != NULL) {
        line[--length] = '\0';
    }
    return line + strspn(line, " \t");
}

static bool holds_control(const char *line) {
    for (const unsigned char *p = (const unsigned char *)line; *p != '\0'; p++) {
        if ((*p < 0x20 && *p != '\t') || *p == 0x7f) {
            return true;
        }
    }
    return false;
}

/* A list file while it is read. */
typedef struct list_reader {
    nsdf_path_list *list;
    const char *path;
    size_t first; /* of its items in the list */
    unsigned line;
    nsdf_encoder_error *error;
} list_reader;

/* Cuts a time off the end of a line "path seconds"; false when there is none. */
static bool cut_time(char *name, double *seconds) {
    size_t end = strlen(name);
    while (end > 0 && strchr(" \t", name[end - 1]) == NULL) {
        end--;
    }
    const char *after = nsdf_read_number(name + end, seconds);
    if (end == 0 || after == NULL || *after != '\0') {
        return false;
    }
    name[end] = '\0';
    trim(name);
    return true;
}

static bool is_file(const list_reader *r, const char *name, char **path) {
    *path = join(r->path, name[0] == '/' ? 0 : folder_length(r->path), name);
    return *path != NULL && kind_of(*path) == PATH_FILE;
}

static nsdf_status refuse_listed(const list_reader *r, const char *path, const char *name) {
    if (path == NULL) {
        return nsdf_input_no_memory(r->error);
    }
    const char *why = kind_of(path) == PATH_MISSING ? "no such file" : "not a regular file";
    return nsdf_input_fail(r->error, NSDF_IO, "%s:%u: %s '%.90s'", nsdf_show_path(r->path).text, r->line, why, name);
}

/* Times are in all lines or in none, and ascend. */
static nsdf_status check_time(const list_reader *r, bool timed, double seconds) {
    const nsdf_frame_file *items = r->list->items;
    const bool is_first = r->list->count == r->first;
    if (!is_first && timed != (r->list->timed_list != NULL)) {
        return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%u: %s time, but the lines before it have %s",
                               nsdf_show_path(r->path).text, r->line, timed ? "a" : "no", timed ? "none" : "one");
    }
    if (timed && !(seconds >= 0.0 && seconds < INFINITY)) {
        return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%u: the time %.9g s is %s", nsdf_show_path(r->path).text,
                               r->line, seconds, seconds < 0.0 ? "negative" : "not finite");
    }
    if (timed && !is_first && !(seconds > items[r->list->count - 1].seconds)) {
        return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%u: the time %.9g s does not come after %.9g s in line %u",
                               nsdf_show_path(r->path).text, r->line, seconds, items[r->list->count - 1].seconds,
                               items[r->list->count - 1].line);
    }
    return NSDF_OK;
}

/* A line that names a file as it stands has no time, whatever it ends in. */
static nsdf_status append_listed(const list_reader *r, char *name) {
    char *path, whole[MAX_LINE];
    double seconds = 0.0;
    bool timed = false;
    snprintf(whole, sizeof whole, "%s", name);
    bool found = is_file(r, name, &path);
    if (!found && path != NULL && cut_time(name, &seconds)) {
        free(path);
        timed = true;
        found = is_file(r, name, &path);
    }
    nsdf_status status = found ? check_time(r, timed, seconds) : refuse_listed(r, path, timed ? name : whole);
    if (status != NSDF_OK) {
        free(path);
        return status;
    }
    if (timed && r->list->timed_list == NULL && (r->list->timed_list = strdup(r->path)) == NULL) {
        free(path);
        return nsdf_input_no_memory(r->error);
    }
    status = append(r->list, path, r->error);
    if (status == NSDF_OK) {
        r->list->items[r->list->count - 1].seconds = seconds;
        r->list->items[r->list->count - 1].line = r->line;
    }
    return status;
}

static nsdf_status read_line(const list_reader *r, char *line, bool ended) {
    const char *end = memchr(line, '\n', MAX_LINE);
    const char *zero = memchr(line, '\0', MAX_LINE);
    if (end == NULL || (zero < end && !ended)) {
        return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%u: %s", nsdf_show_path(r->path).text, r->line,
                               end == NULL ? "the line is too long for a path"
                                           : "a zero byte: this is not a list of paths");
    }
    char *name = trim(line);
    if (holds_control(name)) {
        return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%u: control characters: this is not a list of paths",
                               nsdf_show_path(r->path).text, r->line);
    }
    return *name != '\0' && *name != '#' ? append_listed(r, name) : NSDF_OK;
}

static nsdf_status read_list(list_reader *r, FILE *file) {
    char line[MAX_LINE];
    nsdf_status status = NSDF_OK;
    for (r->line = 1; status == NSDF_OK; r->line++) {
        memset(line, '\n', sizeof line); /* shows how far fgets came, beyond zero bytes too */
        if (fgets(line, sizeof line, file) == NULL) {
            return ferror(file)
                       ? nsdf_input_fail(r->error, NSDF_IO, "%s: cannot read the file", nsdf_show_path(r->path).text)
                       : NSDF_OK;
        }
        status = read_line(r, line, feof(file) != 0);
    }
    return status;
}

static nsdf_status expand_list(nsdf_path_list *list, const char *path, nsdf_encoder_error *error) {
    size_t first = list->count;
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        return nsdf_input_fail(error, NSDF_IO, "%s: cannot open the list file", nsdf_show_path(path).text);
    }
    list_reader reader = {list, path, first, 0, error};
    nsdf_status status = read_list(&reader, file);
    (void)fclose(file);
    if (status == NSDF_OK && list->count == first) {
        return nsdf_input_fail(error, NSDF_CORRUPT, "empty list file '%s': no paths", nsdf_show_path(path).text);
    }
    return status;
}

/* ---- Inputs ---- */

/* Something that exists is taken for what it is, whatever characters its name has. */
nsdf_status nsdf_expand_input(nsdf_path_list *list, const char *input, nsdf_encoder_error *error) {
    nsdf_number_pattern pattern;
    switch (kind_of(input)) {
    case PATH_FOLDER:
        return expand_folder(list, input, error);
    case PATH_FILE:
        return nsdf_input_has_suffix(input, ".txt") || nsdf_input_has_suffix(input, ".lst")
                   ? expand_list(list, input, error)
                   : append(list, strdup(input), error);
    case PATH_OTHER:
        return nsdf_input_fail(error, NSDF_IO, "'%s' is neither a regular file nor a folder",
                               nsdf_show_path(input).text);
    default:
        break;
    }
    if (nsdf_number_pattern_parse(&pattern, input + folder_length(input))) {
        return expand_pattern(list, input, &pattern, error);
    }
    if (strpbrk(input, "*?[") != NULL) {
        return expand_glob(list, input, error);
    }
    return nsdf_input_fail(error, NSDF_IO, "no such file or folder '%s'", nsdf_show_path(input).text);
}
