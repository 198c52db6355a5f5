#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "compare_shapes.h"
#include "geometry_shapes.h"

static void a_mesh_is_no_distance_from_itself(void **state) {
    (void)state;
    nsdf_surface torus = shape_torus(0.7, 0.3, 40, 17), cube = shape_cube(1.0);
    const nsdf_surface *shapes[2] = {&torus, &cube};
    for (int i = 0; i < 2; i++) {
        world_mesh mesh = world_copy(shapes[i], 3.7, 100.0, -20.0, 7.0);
        nsdf_difference d = compare_meshes(&mesh, &mesh, 3000, NSDF_COMPARE_ALL);
        const nsdf_distances none = {0};
        assert_memory_equal(&d.to_decoded, &none, sizeof none);
        assert_memory_equal(&d.to_reference, &none, sizeof none);
        assert_true(d.hausdorff == 0.0);
        assert_true(d.fmpd == 0.0);
        assert_true((d.reference.roughness > 0.0) == (i == 0)); /* the corners of a cube are all alike */
        assert_memory_equal(&d.reference, &d.decoded, sizeof d.decoded);
        world_free(&mesh);
    }
    nsdf_surface_free(&torus);
    nsdf_surface_free(&cube);
}

/* The facets of a sphere of this fineness are at most 4e-4 of the radius inside of it. */
static void concentric_spheres_are_the_difference_of_radii_apart(void **state) {
    (void)state;
    nsdf_surface sphere = shape_sphere(1.0, 90, 110);
    world_mesh small = world_copy(&sphere, 2.0, 5.0, 5.0, 5.0), large = world_copy(&sphere, 2.2, 5.0, 5.0, 5.0);
    nsdf_difference d = compare_meshes(&small, &large, 5000, 0);
    assert_near(d.to_decoded.mean, 0.2, 1e-3);
    assert_near(d.to_decoded.rms, 0.2, 1e-3);
    assert_near(d.to_decoded.max, 0.2, 1e-3);
    assert_near(d.to_reference.mean, 0.2, 1e-3);
    assert_near(d.to_reference.rms, 0.2, 1e-3);
    assert_near(d.to_reference.max, 0.2, 1e-3);
    assert_near(d.hausdorff, 0.2, 1e-3);
    world_free(&small);
    world_free(&large);
    nsdf_surface_free(&sphere);
}

/* Of a sphere of radius r and the same moved by s < r along z: the distance at polar cosine c is
 * |sqrt(r^2 + s^2 - 2 r s c) - r|; c is uniform over the sphere. */
static void a_moved_sphere_has_the_analytic_distances(void **state) {
    (void)state;
    const double r = 2.0, s = 0.5;
    nsdf_surface sphere = shape_sphere(1.0, 90, 110);
    world_mesh here = world_copy(&sphere, r, 0.0, 0.0, 0.0), there = world_copy(&sphere, r, 0.0, 0.0, s);
    double mean = 0.0, square = 0.0;
    for (int i = 0; i < 100000; i++) {
        double c = (i + 0.5) / 50000.0 - 1.0, distance = fabs(sqrt(r * r + s * s - 2.0 * r * s * c) - r);
        mean += distance / 100000.0;
        square += distance * distance / 100000.0;
    }
    nsdf_difference d = compare_meshes(&here, &there, 20000, 0);
    const nsdf_distances *ways[2] = {&d.to_decoded, &d.to_reference};
    for (int k = 0; k < 2; k++) {
        assert_near(ways[k]->mean, mean, 0.005 * mean);
        assert_near(ways[k]->rms, sqrt(square), 0.005 * sqrt(square));
        assert_near(ways[k]->max, s, 1e-3);
    }
    assert_near(d.hausdorff, s, 1e-3);
    world_free(&here);
    world_free(&there);
    nsdf_surface_free(&sphere);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_is_no_distance_from_itself),
        cmocka_unit_test(concentric_spheres_are_the_difference_of_radii_apart),
        cmocka_unit_test(a_moved_sphere_has_the_analytic_distances),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
