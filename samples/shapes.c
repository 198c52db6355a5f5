#include "shapes.h"

#include <math.h>
#include <string.h>

static const double tau = 6.283185307179586;

/* Union with a polynomial blend of the given width (Quilez, "smooth minimum"): its gradient is a convex combination of
 * the two gradients, so the Lipschitz constant does not grow. */
static double blend_union(double a, double b, double width) {
    double h = fmax(width - fabs(a - b), 0);
    return width > 0 ? fmin(a, b) - h * h / (4 * width) : fmin(a, b);
}

/* Squared distance to the segment ab; *along is where the nearest point lies, 0 at a and 1 at b. */
static double segment_distance2(const double p[3], const double *a, const double *b, double *along) {
    double ab2 = 0, pab = 0, d2 = 0;
    for (int c = 0; c < 3; c++) {
        ab2 += (b[c] - a[c]) * (b[c] - a[c]);
        pab += (p[c] - a[c]) * (b[c] - a[c]);
    }
    double t = ab2 > 0 ? fmin(fmax(pab / ab2, 0), 1) : 0;
    for (int c = 0; c < 3; c++) {
        double d = p[c] - a[c] - t * (b[c] - a[c]);
        d2 += d * d;
    }
    *along = t;
    return d2;
}

static double parts_value(const void *user, const double p[3]) {
    const nsdf_shape_pose *pose = user;
    double value = INFINITY;
    for (int i = 0; i < pose->part_count; i++) {
        const nsdf_shape_part *part = &pose->parts[i];
        double along, distance = sqrt(segment_distance2(p, part->a, part->b, &along));
        distance -= part->radius_a + along * (part->radius_b - part->radius_a);
        value = i == 0 ? distance : blend_union(value, distance, part->blend);
    }
    return value;
}

/* Balls on Lissajous curves around the origin: they meet, melt together and part again. */
static void metaballs_pose(double seconds, nsdf_shape_pose *pose) {
    static const double ball[6][7] = {
        /* turns per second and phase for x, y, z; radius */
        {0.31, 0.00, 0.47, 0.10, 0.23, 0.55, 0.30}, {0.43, 0.25, 0.29, 0.60, 0.37, 0.05, 0.26},
        {0.26, 0.50, 0.53, 0.85, 0.41, 0.35, 0.28}, {0.61, 0.75, 0.34, 0.30, 0.19, 0.80, 0.22},
        {0.37, 0.15, 0.23, 0.45, 0.59, 0.65, 0.24}, {0.00, 0.25, 0.17, 0.00, 0.13, 0.20, 0.34}};
    static const double reach[3] = {0.85, 0.60, 0.60};
    pose->part_count = 6;
    for (int i = 0; i < 6; i++) {
        nsdf_shape_part *part = &pose->parts[i];
        for (int c = 0; c < 3; c++)
            part->a[c] = part->b[c] = reach[c] * cos(tau * (ball[i][2 * c] * seconds + ball[i][2 * c + 1]));
        part->radius_a = part->radius_b = ball[i][6];
        part->blend = 0.22;
    }
}

/* Balls that hold the tube's links, for skipping most of them. */
static void thread_beads(nsdf_shape_pose *pose) {
    for (int i = 0; i < NSDF_SHAPE_BEADS; i++) {
        const double(*link)[4] = (const double(*)[4])pose->curve + (size_t)i * NSDF_SHAPE_BEAD;
        double *bead = pose->beads[i];
        for (int c = 0; c < 3; c++)
            bead[c] = (link[0][c] + link[NSDF_SHAPE_BEAD][c]) / 2;
        bead[3] = 0;
        for (int k = 0; k <= NSDF_SHAPE_BEAD; k++) {
            double x = link[k][0] - bead[0], y = link[k][1] - bead[1], z = link[k][2] - bead[2];
            bead[3] = fmax(bead[3], sqrt(x * x + y * y + z * z) + link[k][3]);
        }
    }
}

/* A trefoil tube that turns while its loops breathe; two bulges travel along it. */
static void knot_pose(double seconds, nsdf_shape_pose *pose) {
    double turn = tau * 0.2 * seconds, breath = 0.10 * sin(tau * 0.5 * seconds);
    for (int i = 0; i <= NSDF_SHAPE_CURVE; i++) {
        double u = tau * (i % NSDF_SHAPE_CURVE) / NSDF_SHAPE_CURVE;
        double ring = 0.62 + (0.26 + 0.3 * breath) * cos(3 * u + turn), angle = 2 * u;
        double *point = pose->curve[i];
        point[0] = ring * cos(angle);
        point[1] = ring * sin(angle);
        point[2] = (0.30 + breath) * sin(3 * u + turn);
        point[3] = 0.115 + 0.025 * sin(2 * u - tau * 0.6 * seconds);
    }
    thread_beads(pose);
}

/* The smaller of `value` and the distance to the links of a bead. */
static double bead_value(const nsdf_shape_pose *pose, int bead, const double p[3], double value) {
    for (int i = bead * NSDF_SHAPE_BEAD; i < (bead + 1) * NSDF_SHAPE_BEAD; i++) {
        const double *a = pose->curve[i], *b = pose->curve[i + 1];
        double along, distance = sqrt(segment_distance2(p, a, b, &along));
        value = fmin(value, distance - a[3] - along * (b[3] - a[3]));
    }
    return value;
}

static double curve_value(const void *user, const double p[3]) {
    const nsdf_shape_pose *pose = user;
    double at_least[NSDF_SHAPE_BEADS];
    int nearest = 0;
    for (int i = 0; i < NSDF_SHAPE_BEADS; i++) {
        const double *bead = pose->beads[i];
        double x = p[0] - bead[0], y = p[1] - bead[1], z = p[2] - bead[2];
        at_least[i] = sqrt(x * x + y * y + z * z) - bead[3];
        nearest = at_least[i] < at_least[nearest] ? i : nearest;
    }
    double value = bead_value(pose, nearest, p, INFINITY);
    for (int i = 0; i < NSDF_SHAPE_BEADS; i++)
        if (i != nearest && at_least[i] < value)
            value = bead_value(pose, i, p, value);
    return value;
}

static void wave_pose(double seconds, nsdf_shape_pose *pose) {
    pose->phase = tau * 0.75 * seconds;
}

/* A block with rounded edges whose top is a travelling wave. */
static double wave_value(const void *user, const double p[3]) {
    static const double half[3] = {0.9, 0.45, 0.6}, rounding = 0.08;
    double phase = ((const nsdf_shape_pose *)user)->phase, outside = 0, inside = -INFINITY;
    for (int c = 0; c < 3; c++) {
        double d = fabs(p[c]) - half[c] + rounding;
        outside += fmax(d, 0) * fmax(d, 0);
        inside = fmax(inside, d);
    }
    double block = sqrt(outside) + fmin(inside, 0) - rounding;
    double height = 0.11 * sin(5.0 * p[0] - phase) + 0.06 * sin(4.0 * p[2] + 3.0 * p[0] - 1.3 * phase);
    return -blend_union(-block, height - p[1], 0.1);
}

static const nsdf_shape shapes[] = {
    {"metaballs",
     "six balls that merge and split: parts and holes come and go",
     metaballs_pose,
     parts_value,
     1.0,
     {-1.3, -1.05, -1.05},
     {1.3, 1.05, 1.05}},
    {"walker",
     "a figure walking on the spot, one stride a second, 1.75 m tall",
     nsdf_walker_pose,
     parts_value,
     1.1,
     {-0.6, -0.1, -0.75},
     {0.6, 1.95, 0.75}},
    {"knot",
     "a trefoil tube that turns, breathes and bulges",
     knot_pose,
     curve_value,
     1.1,
     {-1.2, -1.2, -0.65},
     {1.2, 1.2, 0.65}},
    {"wave-box",
     "a block whose top is a travelling wave, with flat sides and an edge",
     wave_pose,
     wave_value,
     1.4,
     {-1.0, -0.55, -0.7},
     {1.0, 0.55, 0.7}},
};

const nsdf_shape *nsdf_shapes(size_t *count) {
    *count = sizeof shapes / sizeof *shapes;
    return shapes;
}

const nsdf_shape *nsdf_shape_find(const char *name) {
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++)
        if (strcmp(shapes[i].name, name) == 0)
            return &shapes[i];
    return NULL;
}

nsdf_implicit_field nsdf_shape_field(const nsdf_shape *shape, const nsdf_shape_pose *pose) {
    nsdf_implicit_field field = {.user = pose, .value = shape->value, .lipschitz = shape->lipschitz};
    memcpy(field.box_min, shape->box_min, sizeof field.box_min);
    memcpy(field.box_max, shape->box_max, sizeof field.box_max);
    return field;
}

double nsdf_shape_extent(const nsdf_shape *shape) {
    double extent = 0;
    for (int c = 0; c < 3; c++)
        extent = fmax(extent, shape->box_max[c] - shape->box_min[c]);
    return extent;
}
