/* Prints decoder/mesher_tables.c: make_mesher_tables > decoder/mesher_tables.c
 *
 * For each case the segments on the six faces are joined to loops, and each loop is triangulated with the smallest
 * sum of squared diagonal lengths (vertices at the middles of the edges) among the triangulations without a diagonal
 * in a face.  All arithmetic is on integers, so the result is the same everywhere.  mesher_tables.h says what the
 * numbers mean. */
#include <stdint.h>
#include <stdio.h>

enum { EDGES = 12, MAX_TRIANGLES = 12, NO_TRIANGULATION = 1 << 20 };

typedef struct case_triangles {
    int count;
    int vertex[MAX_TRIANGLES][3];
} case_triangles;

static int edge_between(int corner_a, int corner_b) {
    const int low = corner_a < corner_b ? corner_a : corner_b, bit = corner_a ^ corner_b;
    const int axis = bit == 1 ? 0 : bit == 2 ? 1 : 2;
    const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    return 4 * axis + ((low >> first & 1) | (low >> second & 1) << 1);
}

/* Twice the coordinates of the middle of an edge. */
static void edge_middle(int edge, int middle[3]) {
    const int axis = edge / 4, first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    middle[axis] = 1;
    middle[first] = 2 * (edge & 1);
    middle[second] = 2 * (edge >> 1 & 1);
}

static int edges_share_face(int a, int b) {
    int p[3], q[3];
    edge_middle(a, p);
    edge_middle(b, q);
    for (int i = 0; i < 3; i++)
        if (p[i] != 1 && p[i] == q[i])
            return 1;
    return 0;
}

static int squared_length(int a, int b) {
    int p[3], q[3], sum = 0;
    edge_middle(a, p);
    edge_middle(b, q);
    for (int i = 0; i < 3; i++)
        sum += (p[i] - q[i]) * (p[i] - q[i]);
    return sum;
}

/* Corners of face 2 * axis + side in counter-clockwise order seen from outside the cell. */
static void face_corners(int face, int corner[4]) {
    const int axis = face / 2, side = face & 1, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int base = side << axis;
    corner[0] = base;
    corner[1] = base | (side ? 1 << u : 1 << v);
    corner[2] = base | 1 << u | 1 << v;
    corner[3] = base | (side ? 1 << v : 1 << u);
}

/* On each face, a segment goes round every run of negative corners, from the edge that enters the run to the one that
 * leaves it.  next[edge] is where the segment that starts at the edge ends, or -1. */
static void make_segments(int signs, int next[EDGES]) {
    for (int i = 0; i < EDGES; i++)
        next[i] = -1;
    for (int face = 0; face < 6; face++) {
        int c[4];
        face_corners(face, c);
        for (int i = 0; i < 4; i++) {
            if ((signs >> c[i] & 1) || !(signs >> c[(i + 1) % 4] & 1))
                continue;
            int j = (i + 1) % 4;
            while (signs >> c[(j + 1) % 4] & 1)
                j = (j + 1) % 4;
            next[edge_between(c[i], c[(i + 1) % 4])] = edge_between(c[j], c[(j + 1) % 4]);
        }
    }
}

/* Cheapest triangulation of the part of the loop between i and j; split[i][j] is the third corner at side i-j. */
static int cheapest(const int *loop, int length, int split[EDGES][EDGES]) {
    int cost[EDGES][EDGES];
    for (int span = 1; span < length; span++) {
        for (int i = 0; i + span < length; i++) {
            const int j = i + span, side = span == 1 || span == length - 1;
            cost[i][j] = span == 1 ? 0 : NO_TRIANGULATION;
            split[i][j] = -1;
            for (int k = i + 1; k < j; k++) {
                const int sum = cost[i][k] + cost[k][j];
                if (sum < cost[i][j]) {
                    cost[i][j] = sum;
                    split[i][j] = k;
                }
            }
            if (!side)
                cost[i][j] += edges_share_face(loop[i], loop[j]) ? NO_TRIANGULATION : squared_length(loop[i], loop[j]);
            if (cost[i][j] > NO_TRIANGULATION)
                cost[i][j] = NO_TRIANGULATION;
        }
    }
    return cost[0][length - 1];
}

static void add_triangle(case_triangles *out, int a, int b, int c) {
    out->vertex[out->count][0] = a;
    out->vertex[out->count][1] = b;
    out->vertex[out->count][2] = c;
    out->count++;
}

static void add_part(case_triangles *out, const int *loop, int split[EDGES][EDGES], int i, int j) {
    if (j - i < 2)
        return;
    const int k = split[i][j];
    add_part(out, loop, split, i, k);
    add_triangle(out, loop[i], loop[k], loop[j]);
    add_part(out, loop, split, k, j);
}

/* 0, or -1 if a loop cannot be triangulated without a diagonal in a face. */
static int make_case(int signs, case_triangles *out) {
    int next[EDGES], split[EDGES][EDGES];
    out->count = 0;
    make_segments(signs, next);
    for (int first = 0; first < EDGES; first++) {
        int loop[EDGES], length = 0;
        for (int edge = first; next[edge] >= 0;) {
            const int following = next[edge];
            loop[length++] = edge;
            next[edge] = -1;
            edge = following;
        }
        if (length == 0)
            continue;
        if (cheapest(loop, length, split) >= NO_TRIANGULATION)
            return -1;
        add_part(out, loop, split, 0, length - 1);
    }
    return 0;
}

#ifndef MAKE_MESHER_TABLES_NO_MAIN
static void print_counts(const char *declaration, const int *value, int count) {
    printf("%s = {", declaration);
    for (int i = 0; i < count; i++)
        printf("%s%d,", i % 16 ? " " : "\n    ", value[i]);
    printf("\n};\n\n");
}

int main(void) {
    case_triangles all[256];
    int first[257] = {0};
    for (int i = 0; i < 256; i++) {
        if (make_case(i, &all[i]) != 0)
            return 1;
        first[i + 1] = first[i] + all[i].count;
    }
    printf("/* Made by tests/tools/make_mesher_tables.c; mesher_tables.h says what the numbers mean. */\n"
           "#include \"mesher_tables.h\"\n\n/* clang-format off */\n");
    print_counts("const uint16_t nsdf_mc_first[257]", first, 257);
    printf("const uint8_t nsdf_mc_triangles[][3] = {");
    for (int i = 0, column = 0; i < 256; i++)
        for (int k = 0; k < all[i].count; k++, column++)
            printf("%s{%d, %d, %d},", column % 8 ? " " : "\n    ", all[i].vertex[k][0], all[i].vertex[k][1],
                   all[i].vertex[k][2]);
    printf("\n};\n/* clang-format on */\n");
    return 0;
}
#endif
