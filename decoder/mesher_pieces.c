/* Leaves out the pieces of the mesh that are smaller than the encoder says a piece gets: specks and bubbles of the fit.
 * Pieces are found by union and find over the triangles; the root of a set is its first vertex, so that the pieces come
 * in the order of the mesh. */
#include "mesher_internal.h"

#include <string.h>

typedef struct piece_box {
    float low[3], high[3];
    uint32_t kept; /* already as large as it has to be: its box does not go on growing */
} piece_box;

/* ---- Sets of vertices -------------------------------------------------------------------------------------- */

static uint32_t find(uint32_t *parent, uint32_t v) {
    while (parent[v] != v) {
        parent[v] = parent[parent[v]];
        v = parent[v];
    }
    return v;
}

static void unite(uint32_t *parent, uint32_t a, uint32_t b) {
    if (parent[a] == parent[b])
        return;
    a = find(parent, a);
    b = find(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

enum { TRIANGLES_BETWEEN_QUESTIONS = 1 << 15 };

static nsdf_status unite_triangles(const nsdf_mesher *mesher, uint32_t *parent) {
    const nsdf_mesh_storage *storage = mesher->storage;
    nsdf_status status = NSDF_OK;
    for (uint32_t v = 0; v < storage->vertex_count; v++)
        parent[v] = v;
    for (uint32_t i = 0; i < storage->triangle_count && status == NSDF_OK;) {
        const uint32_t end = i + nsdf_min_u32(storage->triangle_count - i, TRIANGLES_BETWEEN_QUESTIONS);
        for (; i < end; i++) {
            const uint32_t *t = storage->indices + 3 * (size_t)i;
            unite(parent, t[0], t[1]);
            unite(parent, t[0], t[2]);
        }
        status = nsdf_mesher_ask(mesher, 0, 1);
    }
    return status;
}

/* ---- Pieces ------------------------------------------------------------------------------------------------ */

static void extend(piece_box *box, const float position[3], float least) {
    float square = 0;
    for (int a = 0; a < 3; a++) {
        box->low[a] = position[a] < box->low[a] ? position[a] : box->low[a];
        box->high[a] = position[a] > box->high[a] ? position[a] : box->high[a];
        square += (box->high[a] - box->low[a]) * (box->high[a] - box->low[a]);
    }
    box->kept = square >= least * least;
}

/* Turns parents into numbers of pieces, and finds the pieces' boxes. */
static nsdf_status number_pieces(nsdf_mesher *mesher, uint32_t *piece, uint32_t *count) {
    const nsdf_mesh_storage *storage = mesher->storage;
    *count = 0;
    for (uint32_t v = 0; v < storage->vertex_count; v++) {
        const float *position = storage->positions + 3 * (size_t)v;
        if (piece[v] == v) {
            const nsdf_status status =
                nsdf_mesher_reserve(mesher, &mesher->pieces, (uint64_t)*count + 1, *count, sizeof(piece_box));
            if (status != NSDF_OK)
                return status;
            piece_box *box = (piece_box *)mesher->pieces.data + *count;
            memcpy(box->low, position, sizeof box->low);
            memcpy(box->high, position, sizeof box->high);
            box->kept = 0;
            piece[v] = (*count)++;
        } else {
            piece[v] = piece[piece[v]]; /* the parent comes before v, and has its number */
            piece_box *box = (piece_box *)mesher->pieces.data + piece[v];
            if (!box->kept)
                extend(box, position, mesher->job->smallest_piece);
        }
    }
    return NSDF_OK;
}

/* How many pieces are to be left out. */
static uint32_t count_dropped(const nsdf_mesher *mesher, uint32_t count) {
    const piece_box *boxes = mesher->pieces.data;
    uint32_t dropped = 0;
    for (uint32_t i = 0; i < count; i++)
        dropped += !boxes[i].kept;
    return dropped;
}

/* ---- Moving up --------------------------------------------------------------------------------------------- */

/* Keeps the vertices of the pieces that stay; map[v] becomes the new number, or NSDF_NO_VERTEX. */
static void move_vertices(nsdf_mesher *mesher, uint32_t *map) {
    nsdf_mesh_storage *storage = mesher->storage;
    const piece_box *boxes = mesher->pieces.data;
    uint8_t *loose = mesher->loose.data;
    uint32_t kept = 0;
    for (uint32_t v = 0; v < storage->vertex_count; v++) {
        if (!boxes[map[v]].kept) {
            map[v] = NSDF_NO_VERTEX;
            continue;
        }
        memmove(storage->positions + 3 * (size_t)kept, storage->positions + 3 * (size_t)v, 3 * sizeof(float));
        loose[kept] = loose[v];
        map[v] = kept++;
    }
    storage->vertex_count = kept;
}

static void move_triangles(nsdf_mesh_storage *storage, const uint32_t *map) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < storage->triangle_count; i++) {
        const uint32_t *from = storage->indices + 3 * (size_t)i;
        if (map[from[0]] == NSDF_NO_VERTEX)
            continue;
        uint32_t *to = storage->indices + 3 * (size_t)kept++;
        for (int k = 0; k < 3; k++)
            to[k] = map[from[k]];
    }
    storage->triangle_count = kept;
}

nsdf_status nsdf_mesher_drop_pieces(nsdf_mesher *mesher) {
    nsdf_mesh_storage *storage = mesher->storage;
    if (!(mesher->job->smallest_piece > 0.0f) || storage->vertex_count == 0)
        return NSDF_OK;
    nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->links, storage->vertex_count, 0, sizeof(uint32_t));
    if (status != NSDF_OK)
        return status;
    uint32_t *links = mesher->links.data, count;
    status = unite_triangles(mesher, links);
    if (status == NSDF_OK)
        status = number_pieces(mesher, links, &count);
    mesher->stats.dropped_pieces = status == NSDF_OK ? count_dropped(mesher, count) : 0;
    if (mesher->stats.dropped_pieces > 0) {
        move_vertices(mesher, links);
        move_triangles(storage, links);
    }
    return status;
}
