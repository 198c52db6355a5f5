/* One pass over the text.  Every scan stops at the zero byte that ends it, so no other bounds are needed.  Faces may
 * use vertices that follow: indices that lie ahead are noted with their line and checked at the end, and polygons are
 * fans until then, because cutting them well needs the positions. */
#include "obj_read.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "input_error.h"
#include "obj_number.h"
#include "obj_polygon.h"

#define MAX_FILE_SIZE (INT64_C(1) << 32)
#define MAX_COUNT INT32_MAX /* of vertices, and of triangles */
#define PROBED_BYTES 4096
#define SHOWN_TOKEN 24

typedef struct ahead {
    int64_t index; /* as written */
    uint64_t line;
} ahead;

typedef struct polygon_note {
    uint32_t triangle, corners; /* its first triangle */
} polygon_note;

typedef struct reader {
    const char *name;
    const char *at;
    uint64_t line;
    nsdf_obj_mesh *mesh;
    nsdf_encoder_error *error;
    ahead *aheads;
    polygon_note *polygons;
    size_t ahead_count, ahead_capacity, polygon_count, polygon_capacity;
} reader;

void nsdf_obj_mesh_free(nsdf_obj_mesh *mesh) {
    if (mesh != NULL) {
        free(mesh->positions);
        free(mesh->indices);
        *mesh = (nsdf_obj_mesh){0};
    }
}

/* ---- Characters ---- */

static bool is_line_end(char c) {
    return c == '\n' || c == '\r' || c == '\0';
}

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

static const char *after_line_end(const char *p) {
    return p[0] == '\r' && p[1] == '\n' ? p + 2 : p + 1;
}

static bool is_continuation(const char *p) {
    return p[0] == '\\' && (p[1] == '\n' || p[1] == '\r');
}

/* Blanks, and line ends that a backslash hides. */
static void skip_blanks(reader *r) {
    while (is_blank(*r->at) || is_continuation(r->at)) {
        if (*r->at == '\\') {
            r->at = after_line_end(r->at + 1);
            r->line++;
        } else {
            r->at++;
        }
    }
}

static bool is_token_end(const char *p) {
    return is_blank(*p) || is_line_end(*p) || is_continuation(p);
}

static void skip_to_line_end(reader *r) {
    while (!is_line_end(*r->at)) {
        if (is_continuation(r->at)) {
            skip_blanks(r);
        } else {
            r->at++;
        }
    }
}

/* ---- Messages ---- */

/* The word at the cursor, for a message; unprintable characters become '?'. */
static void copy_token(const char *at, char token[SHOWN_TOKEN + 4]) {
    size_t n = 0;
    for (; n < SHOWN_TOKEN && !is_token_end(at + n); n++) {
        token[n] = at[n] >= ' ' && at[n] <= '~' ? at[n] : '?';
    }
    strcpy(token + n, is_token_end(at + n) ? "" : "...");
}

static nsdf_status fail_at(const reader *r, uint64_t line, const char *what) {
    nsdf_shown_path shown = nsdf_show_path(r->name);
    return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%llu: %s", shown.text, (unsigned long long)line, what);
}

/* `before`, the word at the cursor in quotes, `after`. */
static nsdf_status fail_token(const reader *r, const char *before, const char *after) {
    nsdf_shown_path shown = nsdf_show_path(r->name);
    char token[SHOWN_TOKEN + 4];
    copy_token(r->at, token);
    return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%llu: %s '%s'%s", shown.text, (unsigned long long)r->line,
                           before, token, after);
}

static nsdf_status fail_range(const reader *r, uint64_t line, int64_t index, const char *so_far) {
    nsdf_shown_path shown = nsdf_show_path(r->name);
    return nsdf_input_fail(r->error, NSDF_CORRUPT,
                           "%s:%llu: face index %lld is out of range (the file has %u vertices%s)", shown.text,
                           (unsigned long long)line, (long long)index, r->mesh->vertex_count, so_far);
}

/* ---- Growing arrays ---- */

/* The array with room for `wanted` elements, or NULL. */
static void *reserve(void *array, size_t *capacity, size_t wanted, size_t size) {
    if (wanted <= *capacity) {
        return array;
    }
    size_t larger = *capacity + *capacity / 2 + 256;
    larger = larger < wanted ? wanted : larger;
    void *moved = larger <= SIZE_MAX / size ? realloc(array, larger * size) : NULL;
    if (moved != NULL) {
        *capacity = larger;
    }
    return moved;
}

static nsdf_status add_triangle(reader *r, uint32_t a, uint32_t b, uint32_t c) {
    nsdf_obj_mesh *m = r->mesh;
    if (m->triangle_count == MAX_COUNT) {
        return nsdf_input_fail(r->error, NSDF_LIMIT, "%s: too many triangles", nsdf_show_path(r->name).text);
    }
    uint32_t *indices =
        reserve(m->indices, &m->triangle_capacity, (size_t)m->triangle_count + 1, 3 * sizeof *m->indices);
    if (indices == NULL) {
        return nsdf_input_no_memory(r->error);
    }
    m->indices = indices;
    uint32_t *to = &indices[3 * (size_t)m->triangle_count++];
    to[0] = a;
    to[1] = b;
    to[2] = c;
    return NSDF_OK;
}

static nsdf_status note_polygon(reader *r, uint32_t first_triangle, uint32_t corners) {
    polygon_note *notes = reserve(r->polygons, &r->polygon_capacity, r->polygon_count + 1, sizeof *notes);
    if (notes == NULL) {
        return nsdf_input_no_memory(r->error);
    }
    r->polygons = notes;
    notes[r->polygon_count++] = (polygon_note){first_triangle, corners};
    return NSDF_OK;
}

static nsdf_status note_ahead(reader *r, int64_t index) {
    ahead *aheads = reserve(r->aheads, &r->ahead_capacity, r->ahead_count + 1, sizeof *aheads);
    if (aheads == NULL) {
        return nsdf_input_no_memory(r->error);
    }
    r->aheads = aheads;
    aheads[r->ahead_count++] = (ahead){index, r->line};
    return NSDF_OK;
}

/* ---- Records ---- */

static bool looks_infinite_or_nan(const char *at) {
    static const char *const words[] = {"nan", "inf"};
    at += *at == '-' || *at == '+';
    for (size_t w = 0; w < sizeof words / sizeof words[0]; w++) {
        int k = 0;
        while (k < 3 && (at[k] | 0x20) == words[w][k]) {
            k++;
        }
        if (k == 3) {
            return true;
        }
    }
    return false;
}

static nsdf_status read_coordinate(reader *r, double *value) {
    skip_blanks(r);
    if (is_line_end(*r->at) || *r->at == '#') {
        return fail_at(r, r->line, "a vertex needs three coordinates");
    }
    const char *end = nsdf_read_number(r->at, value);
    if (end == NULL || !is_token_end(end)) {
        return looks_infinite_or_nan(r->at) ? fail_token(r, "coordinate", " is not a finite number")
                                            : fail_token(r, "malformed coordinate", ", expected a number");
    }
    if (!isfinite(*value)) {
        return fail_token(r, "coordinate", " is too large");
    }
    r->at = end;
    return NSDF_OK;
}

static nsdf_status read_vertex(reader *r) {
    nsdf_obj_mesh *m = r->mesh;
    if (m->vertex_count == MAX_COUNT) {
        return nsdf_input_fail(r->error, NSDF_LIMIT, "%s: too many vertices", nsdf_show_path(r->name).text);
    }
    double *positions = reserve(m->positions, &m->vertex_capacity, (size_t)m->vertex_count + 1, 3 * sizeof *positions);
    if (positions == NULL) {
        return nsdf_input_no_memory(r->error);
    }
    m->positions = positions;
    for (size_t k = 0; k < 3; k++) {
        nsdf_status status = read_coordinate(r, &positions[3 * (size_t)m->vertex_count + k]);
        if (status != NSDF_OK) {
            return status;
        }
    }
    m->vertex_count++;
    return NSDF_OK;
}

/* What may follow an index: /vt, //vn or /vt/vn; texture and normal indices are not looked at. */
static const char *skip_attributes(const char *p) {
    for (int i = 0; i < 2 && *p == '/'; i++) {
        int64_t unused;
        const char *end = nsdf_read_integer(++p, &unused);
        p = end != NULL ? end : p;
    }
    return p;
}

/* Reads one corner; vertices are numbered from 0 here. */
static nsdf_status read_corner(reader *r, uint32_t *vertex) {
    int64_t index;
    const char *end = nsdf_read_integer(r->at, &index);
    end = end != NULL ? skip_attributes(end) : NULL;
    if (end == NULL || !is_token_end(end)) {
        return fail_token(r, "malformed face index", ", expected v, v/vt, v//vn or v/vt/vn");
    }
    if (index == 0) {
        return fail_at(r, r->line, "face index 0: indices start at 1");
    }
    int64_t known = r->mesh->vertex_count, wanted = index > 0 ? index - 1 : known + index;
    if (wanted < 0) {
        return fail_range(r, r->line, index, " so far");
    }
    r->at = end;
    *vertex = (uint32_t)wanted;
    return wanted >= known ? note_ahead(r, index) : NSDF_OK;
}

static nsdf_status read_face(reader *r) {
    uint32_t first = 0, previous = 0, vertex = 0, corners = 0, first_triangle = r->mesh->triangle_count;
    uint64_t line = r->line;
    for (skip_blanks(r); !is_line_end(*r->at) && *r->at != '#'; skip_blanks(r)) {
        nsdf_status status = read_corner(r, &vertex);
        if (status == NSDF_OK && corners >= 2) {
            status = add_triangle(r, first, previous, vertex);
        }
        if (status != NSDF_OK) {
            return status;
        }
        first = corners == 0 ? vertex : first;
        previous = vertex;
        corners++;
    }
    if (corners < 3) {
        return fail_at(r, line, "a face needs at least three vertices");
    }
    return corners > 3 ? note_polygon(r, first_triangle, corners) : NSDF_OK;
}

static nsdf_status read_line(reader *r) {
    skip_blanks(r);
    char record = *r->at;
    nsdf_status status = NSDF_OK;
    if ((record == 'v' || record == 'f') && (is_token_end(r->at + 1) || r->at[1] == '#')) {
        r->at++;
        status = record == 'v' ? read_vertex(r) : read_face(r);
        if (status == NSDF_OK) {
            skip_to_line_end(r);
        }
    } else {
        while (!is_line_end(*r->at)) {
            r->at++;
        }
    }
    return status;
}

/* ---- Files ---- */

/* Whether the start holds characters that text does not: quick for archives, images and other binary files. */
static bool looks_binary(const char *text, size_t size) {
    for (size_t i = 0; i < size && i < PROBED_BYTES; i++) {
        unsigned char c = (unsigned char)text[i];
        if (c < ' ' && !is_blank(text[i]) && c != '\n' && c != '\r' && c != 0x1a) {
            return true;
        }
    }
    return false;
}

static nsdf_status read_lines(reader *r, const char *end) {
    while (r->at < end) {
        nsdf_status status = read_line(r);
        if (status != NSDF_OK) {
            return status;
        }
        if (*r->at == '\0') {
            return r->at == end ? NSDF_OK : fail_at(r, r->line, "a zero byte: this is not an OBJ text file");
        }
        r->at = after_line_end(r->at);
        r->line++;
    }
    return NSDF_OK;
}

static nsdf_status finish(reader *r) {
    nsdf_obj_mesh *m = r->mesh;
    nsdf_shown_path shown = nsdf_show_path(r->name);
    if (m->vertex_count == 0) {
        return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s: no vertices", shown.text);
    }
    if (m->triangle_count == 0) {
        return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s: no faces", shown.text);
    }
    for (size_t i = 0; i < r->ahead_count; i++) {
        if (r->aheads[i].index > (int64_t)m->vertex_count) {
            return fail_range(r, r->aheads[i].line, r->aheads[i].index, "");
        }
    }
    for (size_t i = 0; i < r->polygon_count; i++) {
        const polygon_note *note = &r->polygons[i];
        nsdf_improve_fan(m->positions, &m->indices[3 * (size_t)note->triangle], note->corners);
    }
    return NSDF_OK;
}

nsdf_status nsdf_obj_parse(const char *name, const char *text, size_t size, nsdf_obj_mesh *mesh,
                           nsdf_encoder_error *error) {
    reader r = {.name = name, .at = text, .line = 1, .mesh = mesh, .error = error};
    mesh->vertex_count = 0;
    mesh->triangle_count = 0;
    if (looks_binary(text, size)) {
        return nsdf_input_fail(error, NSDF_CORRUPT, "%s: not an OBJ text file (it holds binary data)",
                               nsdf_show_path(name).text);
    }
    if (strncmp(text, "\xef\xbb\xbf", 3) == 0) {
        r.at += 3; /* byte order mark */
    }
    nsdf_status status = read_lines(&r, text + size);
    status = status == NSDF_OK ? finish(&r) : status;
    if (status != NSDF_OK) {
        mesh->triangle_count = 0;
    }
    free(r.aheads);
    free(r.polygons);
    return status;
}

static nsdf_status read_all(int file, const char *path, char *text, size_t size, nsdf_encoder_error *error) {
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

static nsdf_status read_open_file(int file, const char *path, nsdf_obj_mesh *mesh, nsdf_encoder_error *error) {
    nsdf_shown_path shown = nsdf_show_path(path);
    struct stat info;
    if (fstat(file, &info) != 0 || !S_ISREG(info.st_mode)) {
        return nsdf_input_fail(error, NSDF_IO, "%s: not a regular file", shown.text);
    }
    if ((int64_t)info.st_size > MAX_FILE_SIZE || (uint64_t)info.st_size >= SIZE_MAX) {
        return nsdf_input_fail(error, NSDF_LIMIT, "%s: too large (OBJ files of up to 4 GiB are read)", shown.text);
    }
    size_t size = (size_t)info.st_size;
    char *text = malloc(size + 1);
    if (text == NULL) {
        return nsdf_input_no_memory(error);
    }
    nsdf_status status = read_all(file, path, text, size, error);
    if (status == NSDF_OK) {
        status = nsdf_obj_parse(path, text, size, mesh, error);
    }
    free(text);
    return status;
}

nsdf_status nsdf_obj_read(const char *path, nsdf_obj_mesh *mesh, nsdf_encoder_error *error) {
    mesh->vertex_count = 0;
    mesh->triangle_count = 0;
    int file = open(path, O_RDONLY | O_NONBLOCK); /* opening a pipe must not wait for a writer */
    if (file < 0) {
        const char *why = errno == ENOENT   ? "no such file"
                          : errno == EACCES ? "no permission to read it"
                                            : "cannot open it";
        return nsdf_input_fail(error, NSDF_IO, "%s: %s", nsdf_show_path(path).text, why);
    }
    nsdf_status status = read_open_file(file, path, mesh, error);
    (void)close(file);
    return status;
}
