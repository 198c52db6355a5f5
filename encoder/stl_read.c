#include "stl_read.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "input_error.h"
#include "obj_number.h"

enum { HEADER = 84, TRIANGLE = 50, NORMAL = 12 };

typedef struct reader {
    const char *name, *at, *start;
    uint64_t line; /* 0 in binary files */
    nsdf_file_mesh *mesh;
    nsdf_encoder_error *error;
} reader;

static nsdf_status fail(const reader *r, const char *what) {
    nsdf_shown_path shown = nsdf_show_path(r->name);
    if (r->line == 0) {
        return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s: byte %llu: %s", shown.text,
                               (unsigned long long)(r->at - r->start), what);
    }
    return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%llu: %s", shown.text, (unsigned long long)r->line, what);
}

static nsdf_status add_corner(reader *r, const double xyz[3], nsdf_corners *corners) {
    if (!isfinite(xyz[0]) || !isfinite(xyz[1]) || !isfinite(xyz[2])) {
        return fail(r, "a coordinate is not a finite number");
    }
    const uint32_t vertex = r->mesh->vertex_count;
    nsdf_status status = nsdf_file_mesh_add_vertex(r->mesh, xyz, r->name, r->error);
    return status == NSDF_OK ? nsdf_file_mesh_add_corner(r->mesh, corners, vertex, r->name, r->error) : status;
}

/* ---- Binary ---- */

static uint32_t read_u32(const char *at) {
    const unsigned char *b = (const unsigned char *)at;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static double read_float(const char *at) {
    const uint32_t bits = read_u32(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

static bool is_binary(const char *text, size_t size) {
    return size >= HEADER && (size - HEADER) % TRIANGLE == 0 && (size - HEADER) / TRIANGLE == read_u32(text + 80);
}

static nsdf_status read_binary(reader *r, size_t size) {
    for (size_t i = 0; i < (size - HEADER) / TRIANGLE; i++) {
        nsdf_corners corners = {0};
        for (size_t k = 0; k < 3; k++) {
            double xyz[3];
            r->at = r->start + HEADER + i * TRIANGLE + NORMAL + 12 * k;
            for (size_t axis = 0; axis < 3; axis++) {
                xyz[axis] = read_float(r->at + 4 * axis);
            }
            nsdf_status status = add_corner(r, xyz, &corners);
            if (status != NSDF_OK) {
                return status;
            }
        }
    }
    return NSDF_OK;
}

/* ---- Ascii ---- */

static void skip_blanks(reader *r) {
    for (; *r->at == ' ' || *r->at == '\t' || *r->at == '\r' || *r->at == '\n'; r->at++) {
        r->line += *r->at == '\n';
    }
}

static bool is_end_of_word(char c) {
    return c == '\0' || c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* Takes the next word if it is this one, in any case. */
static bool take(reader *r, const char *word) {
    skip_blanks(r);
    size_t n = 0;
    while (word[n] != '\0' && (r->at[n] | 0x20) == word[n]) {
        n++;
    }
    if (word[n] != '\0' || !is_end_of_word(r->at[n])) {
        return false;
    }
    r->at += n;
    return true;
}

static nsdf_status read_corner(reader *r, nsdf_corners *corners) {
    double xyz[3];
    for (int k = 0; k < 3; k++) {
        skip_blanks(r);
        const char *end = nsdf_read_number(r->at, &xyz[k]);
        if (end == NULL || !is_end_of_word(*end)) {
            return fail(r, "a vertex needs three finite coordinates");
        }
        r->at = end;
    }
    return add_corner(r, xyz, corners);
}

/* From "facet" to the end of the line, for the normal. */
static nsdf_status read_facet(reader *r) {
    nsdf_corners corners = {0};
    r->at += strcspn(r->at, "\n");
    if (!take(r, "outer") || !take(r, "loop")) {
        return fail(r, "expected 'outer loop'");
    }
    while (take(r, "vertex")) {
        nsdf_status status = corners.count < 3 ? read_corner(r, &corners) : fail(r, "a facet of more than 3 corners");
        if (status != NSDF_OK) {
            return status;
        }
    }
    if (corners.count != 3 || !take(r, "endloop") || !take(r, "endfacet")) {
        return fail(r, "expected three times 'vertex', then 'endloop' and 'endfacet'");
    }
    return NSDF_OK;
}

/* A file may have several solids, one after the other; their names may be anything. */
static nsdf_status read_ascii(reader *r) {
    r->line = 1;
    while (true) {
        if (take(r, "facet")) {
            nsdf_status status = read_facet(r);
            if (status != NSDF_OK) {
                return status;
            }
        } else if (take(r, "solid") || take(r, "endsolid")) {
            r->at += strcspn(r->at, "\n");
        } else if (*r->at == '\0') {
            return NSDF_OK;
        } else {
            return fail(r, "expected 'facet', 'endsolid' or 'solid': this is no STL file, or it is cut off");
        }
    }
}

nsdf_status nsdf_stl_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                           nsdf_encoder_error *error) {
    reader r = {.name = name, .at = text, .start = text, .mesh = mesh, .error = error};
    nsdf_file_mesh_clear(mesh);
    nsdf_status status = is_binary(text, size) ? read_binary(&r, size) : read_ascii(&r);
    if (status == NSDF_OK && r.line > 0 && r.at != text + size) {
        status = fail(&r, "a zero byte: this is neither binary STL of its size nor text");
    }
    status = status == NSDF_OK ? nsdf_file_mesh_finish(mesh, name, error) : status;
    if (status != NSDF_OK) {
        mesh->triangle_count = 0;
    }
    return status;
}
