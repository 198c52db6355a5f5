/* The marching-cubes table: made by its generator, and such that neighbouring cells fit together. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "mesher_tables.h"
#define MAKE_MESHER_TABLES_NO_MAIN
#include "tools/make_mesher_tables.c"

static int triangle_count(int cell) {
    return nsdf_mc_first[cell + 1] - nsdf_mc_first[cell];
}

static const uint8_t *triangle(int cell, int i) {
    return nsdf_mc_triangles[nsdf_mc_first[cell] + i];
}

/* How often side a-b occurs, in this direction, among a case's triangles. */
static int count_side(int cell, int a, int b) {
    int n = 0;
    for (int i = 0; i < triangle_count(cell); i++)
        for (int k = 0; k < 3; k++)
            n += triangle(cell, i)[k] == a && triangle(cell, i)[(k + 1) % 3] == b;
    return n;
}

static int edge_lies_in_face(int edge, int face) {
    int middle[3];
    edge_middle(edge, middle);
    return middle[face / 2] == 2 * (face & 1);
}

static void table_is_what_the_generator_makes(void **state) {
    (void)state;
    for (int cell = 0; cell < 256; cell++) {
        case_triangles made;
        assert_int_equal(make_case(cell, &made), 0);
        assert_int_equal(made.count, triangle_count(cell));
        for (int i = 0; i < made.count; i++)
            for (int k = 0; k < 3; k++)
                assert_int_equal(made.vertex[i][k], triangle(cell, i)[k]);
    }
}

/* Each edge with a change of sign has a vertex that lies on exactly one fan of triangles; no other edge has one. */
static void every_crossed_edge_is_used_once(void **state) {
    (void)state;
    for (int cell = 0; cell < 256; cell++) {
        for (int low = 0; low < 8; low++) {
            for (int axis = 0; axis < 3; axis++) {
                if (low >> axis & 1)
                    continue;
                const int high = low | 1 << axis, edge = edge_between(low, high);
                int starts = 0; /* sides from this vertex that no other triangle shares: one per loop */
                for (int to = 0; to < EDGES; to++)
                    starts += count_side(cell, edge, to) == 1 && count_side(cell, to, edge) == 0;
                assert_int_equal(starts, (cell >> low & 1) != (cell >> high & 1));
            }
        }
    }
}

/* Inner sides are shared by two triangles in opposite directions and do not lie in a face. */
static void triangles_of_a_case_fit_together(void **state) {
    (void)state;
    for (int cell = 0; cell < 256; cell++) {
        for (int a = 0; a < EDGES; a++) {
            for (int b = 0; b < EDGES; b++) {
                const int there = count_side(cell, a, b), back = count_side(cell, b, a);
                assert_true(there <= 1);
                if (there && back)
                    assert_false(edges_share_face(a, b));
                if (there && !back)
                    assert_true(edges_share_face(a, b));
            }
        }
    }
}

/* The segments that a case has on its upper face along an axis are those that its neighbour has on its lower face,
 * the other way round, for every pair of cases that agree on the corners between them. */
static void neighbouring_cells_agree_on_their_face(void **state) {
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        for (int pattern = 0; pattern < 256 * 256; pattern++) {
            const int lower = pattern & 255, upper = pattern >> 8;
            int agree = 1;
            for (int c = 0; c < 8; c++)
                if (c >> axis & 1)
                    agree &= (lower >> c & 1) == (upper >> (c ^ 1 << axis) & 1);
            if (!agree)
                continue;
            for (int a = 0; a < EDGES; a++) {
                for (int b = 0; b < EDGES; b++) {
                    if (!edge_lies_in_face(a, 2 * axis + 1) || !edge_lies_in_face(b, 2 * axis + 1))
                        continue;
                    int p[3], q[3], corner_a[2] = {0, 0}, corner_b[2] = {0, 0};
                    edge_middle(a, p);
                    edge_middle(b, q);
                    p[axis] = q[axis] = 0; /* the same edges as the upper cell sees them */
                    for (int i = 0; i < 3; i++) {
                        corner_a[0] |= (p[i] == 2) << i;
                        corner_a[1] |= (p[i] >= 1) << i;
                        corner_b[0] |= (q[i] == 2) << i;
                        corner_b[1] |= (q[i] >= 1) << i;
                    }
                    if (a == b)
                        continue;
                    assert_int_equal(count_side(lower, a, b), count_side(upper, edge_between(corner_b[0], corner_b[1]),
                                                                         edge_between(corner_a[0], corner_a[1])));
                }
            }
        }
    }
}

/* Each triangle has its positive corners in front: the nearest corner in front of the middle of a crossed edge is the
 * positive end of that edge for at least one triangle at the vertex, and the volume below the surface grows with the
 * number of negative corners. */
static void triangles_face_the_positive_side(void **state) {
    (void)state;
    for (int cell = 1; cell < 255; cell++) {
        for (int low = 0; low < 8; low++) {
            for (int axis = 0; axis < 3; axis++) {
                const int high = low | 1 << axis;
                if (low == high || (cell >> low & 1) == (cell >> high & 1))
                    continue;
                const int edge = edge_between(low, high), towards = cell >> low & 1 ? 1 : -1;
                int normal = 0; /* of the fan around the vertex, along the edge */
                for (int i = 0; i < triangle_count(cell); i++) {
                    const uint8_t *t = triangle(cell, i);
                    if (t[0] != edge && t[1] != edge && t[2] != edge)
                        continue;
                    int p[3], q[3], r[3];
                    edge_middle(t[0], p);
                    edge_middle(t[1], q);
                    edge_middle(t[2], r);
                    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
                    normal += (q[u] - p[u]) * (r[v] - p[v]) - (q[v] - p[v]) * (r[u] - p[u]);
                }
                assert_true(normal * towards > 0);
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_is_what_the_generator_makes), cmocka_unit_test(every_crossed_edge_is_used_once),
        cmocka_unit_test(triangles_of_a_case_fit_together),  cmocka_unit_test(neighbouring_cells_agree_on_their_face),
        cmocka_unit_test(triangles_face_the_positive_side),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
