/* Small moving meshes as connected frames, and their maps. */
#ifndef MOTION_SAMPLES_H
#define MOTION_SAMPLES_H

#include "frames.h"
#include "geometry_shapes.h"
#include "motion.h"

/* x' = linear x + shift of a frame, for the triangles' part that a vertex belongs to. */
typedef struct sample_map {
    double linear[9], shift[3];
} sample_map;
typedef sample_map (*sample_mover)(uint32_t frame, int part);

static inline void sample_apply(const sample_map *m, const double x[3], double out[3]) {
    for (int row = 0; row < 3; row++)
        out[row] =
            m->shift[row] + m->linear[3 * row] * x[0] + m->linear[3 * row + 1] * x[1] + m->linear[3 * row + 2] * x[2];
}

/* Takes *rest over, and moves copies of it; vertices from second_part on move as part 1. */
static inline nsdf_frames sample_frames(nsdf_surface *rest, uint32_t count, uint32_t second_part, sample_mover move) {
    nsdf_frames frames = {.frames = calloc(count, sizeof(nsdf_frame)), .count = count, .capacity = count};
    for (uint32_t f = 0; f < count; f++) {
        nsdf_surface *s = &frames.frames[f].surface;
        *s = shape_empty();
        frames.frames[f].number = f;
        for (uint32_t v = 0; v < rest->vertex_count; v++) {
            const float *p = rest->positions + 3 * (size_t)v;
            const double x[3] = {(double)p[0], (double)p[1], (double)p[2]};
            const sample_map m = move(f, v >= second_part);
            double y[3];
            sample_apply(&m, x, y);
            (void)shape_vertex(s, y[0], y[1], y[2]);
        }
        for (uint32_t t = 0; t < rest->triangle_count; t++)
            shape_triangle(s, rest->indices[3 * (size_t)t], rest->indices[3 * (size_t)t + 1],
                           rest->indices[3 * (size_t)t + 2]);
    }
    nsdf_surface_free(rest);
    return frames;
}

/* By an angle around an axis of length 1, then by a shift (Rodrigues). */
static inline sample_map sample_turn(const double axis[3], double angle, double x, double y, double z) {
    const double c = cos(angle), s = sin(angle);
    sample_map m = {{0}, {x, y, z}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m.linear[3 * i + j] = (i == j ? c : 0.0) + (1.0 - c) * axis[i] * axis[j];
    m.linear[1] -= s * axis[2];
    m.linear[2] += s * axis[1];
    m.linear[3] += s * axis[2];
    m.linear[5] -= s * axis[0];
    m.linear[6] -= s * axis[1];
    m.linear[7] += s * axis[0];
    return m;
}

/* Frame 2 is at rest, the middle one of five. */
enum { SAMPLE_REST = 2, SAMPLE_FRAMES = 5 };

static inline sample_map sample_rigid(uint32_t frame, int part) {
    const double axis[2][3] = {{0.6, 0.0, 0.8}, {0.0, 1.0, 0.0}}, t = (double)frame - SAMPLE_REST;
    return sample_turn(axis[part], part ? -0.5 * t : 0.4 * t, 0.05 * t, part ? -0.03 * t : 0.02 * t, 0.0);
}

static inline sample_map sample_slow_turn(uint32_t frame, int part) {
    const double axis[3] = {0.6, 0.0, 0.8}, t = (double)frame - SAMPLE_REST;
    (void)part;
    return sample_turn(axis, 0.12 * t, 0.03 * t, 0.01 * t, 0.0);
}

static inline sample_map sample_shear(uint32_t frame, int part) {
    const double t = (double)frame - SAMPLE_REST;
    sample_map m = {{1, 0.1 * t, 0, 0, 1, -0.05 * t, 0, 0, 1}, {0.01 * t, 0, 0}};
    (void)part;
    return m;
}

static inline sample_map sample_still(uint32_t frame, int part) {
    sample_map m = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    (void)frame;
    (void)part;
    return m;
}

/* Two balls beside each other that nearly touch. */
static inline nsdf_surface sample_two_balls(uint32_t *second_part) {
    nsdf_surface s = shape_empty();
    shape_add_sphere(&s, 0.2, 14, 28, 0, 0);
    *second_part = s.vertex_count;
    shape_add_sphere(&s, 0.2, 14, 28, 0, 0);
    for (uint32_t v = 0; v < s.vertex_count; v++)
        s.positions[3 * (size_t)v] += v < *second_part ? -0.201f : 0.201f;
    return s;
}

/* A rod whose middle is blended from its two ends. */
static inline nsdf_motion sample_bending_rod(void) {
    enum { BLOCKS = 60, FRAMES = 9 };
    nsdf_motion m = {.block_count = BLOCKS,
                     .frame_count = FRAMES,
                     .centres = calloc(BLOCKS, sizeof *m.centres),
                     .normals = calloc(BLOCKS, sizeof *m.normals),
                     .lives = calloc(BLOCKS, sizeof *m.lives),
                     .poses = calloc(BLOCKS * FRAMES, sizeof *m.poses),
                     .radius = 0.05f};
    for (uint32_t k = 0; k < BLOCKS; k++) {
        const double along = (double)k / (BLOCKS - 1), w = fmin(1.0, fmax(0.0, 3.0 * along - 1.0));
        m.lives[k][1] = FRAMES - 1;
        m.centres[k][0] = (float)(along - 0.5);
        m.centres[k][1] = 0.05f * (float)(k % 2);
        m.centres[k][2] = 0.05f * (float)(k % 3);
        for (uint32_t f = 0; f < FRAMES; f++) {
            nsdf_pose *p = &m.poses[(size_t)f * BLOCKS + k];
            for (int part = 0; part < 2; part++) {
                const sample_map map = sample_rigid(f / 2, part);
                const double x[3] = {(double)m.centres[k][0], (double)m.centres[k][1], (double)m.centres[k][2]};
                double y[3];
                sample_apply(&map, x, y);
                for (int i = 0; i < 9; i++)
                    p->linear[i] += (part ? w : 1.0 - w) * map.linear[i];
                for (int i = 0; i < 3; i++)
                    p->position[i] += (part ? w : 1.0 - w) * y[i];
            }
        }
    }
    return m;
}

/* Blocks that follow connected frames. */
static inline nsdf_motion sample_motion(const nsdf_frames *frames, uint32_t blocks, nsdf_workers *workers) {
    const uint32_t rest = nsdf_rest_frame(frames, 1);
    const double area = nsdf_surface_area(&frames->frames[rest].surface);
    nsdf_nodes nodes;
    nsdf_motion motion;
    assert_int_equal(nsdf_nodes_place(&nodes, frames, rest, blocks < 150 ? 600 : 4 * blocks, 1), 0);
    nsdf_nodes_carry(&nodes, frames);
    assert_int_equal(nsdf_motion_find(&motion, &nodes, blocks, area,
                                      (float)sqrt(5.0 * area / (3.141592653589793 * blocks)), workers),
                     0);
    nsdf_nodes_free(&nodes);
    return motion;
}

static inline void sample_frames_free(nsdf_frames *frames) {
    for (uint32_t f = 0; f < frames->count; f++)
        nsdf_surface_free(&frames->frames[f].surface);
    free(frames->frames);
    memset(frames, 0, sizeof *frames);
}

#endif
