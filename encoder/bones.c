/* A block is matched at its centre and along three axes, at the root mean square distance of a ball's points: errors
 * are those of the affine map over the ball. */
#include "bones.h"

#include "dense_solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 4, CANDIDATES = 8, GROWTH_ROUNDS = 4, FINAL_ROUNDS = 8 };
static const double axis_share = 0.45; /* of the radius: sqrt(1 / 5) */
static const double regular = 1e-7;    /* keeps bones without blocks solvable */
static const double spread = 2.4;      /* radii around a new bone's seed from which no other seed is taken */

typedef struct {
    nsdf_bones *bones;
    nsdf_motion *motion;
    double *errors; /* [block]: squared error summed over frames */
} job;

/* ---- Points ---------------------------------------------------------------------------------------------- */

/* Point n of a block at rest, homogeneous: the centre, or an axis. */
static void rest_point(const nsdf_motion *m, uint32_t block, int n, double y[4]) {
    memset(y, 0, 4 * sizeof *y);
    if (n > 0) {
        y[n - 1] = axis_share * (double)m->radius;
        return;
    }
    for (int k = 0; k < 3; k++)
        y[k] = (double)m->centres[block][k];
    y[3] = 1.0;
}

/* Where it is in a frame. */
static void moved_point(const nsdf_motion *m, uint32_t frame, uint32_t block, int n, double x[3]) {
    const nsdf_pose *p = &m->poses[(size_t)frame * m->block_count + block];
    for (int k = 0; k < 3; k++)
        x[k] = n == 0 ? p->position[k] : axis_share * (double)m->radius * p->linear[3 * k + n - 1];
}

static const double *pose_of(const nsdf_bones *b, uint32_t frame, uint32_t bone) {
    return b->poses + 12 * ((size_t)frame * b->bone_count + bone);
}

/* bone(y) - x */
static void miss(const double *bone, const double y[4], const double x[3], double d[3]) {
    for (int k = 0; k < 3; k++)
        d[k] = bone[4 * k] * y[0] + bone[4 * k + 1] * y[1] + bone[4 * k + 2] * y[2] + bone[4 * k + 3] * y[3] - x[k];
}

/* Squared error of one bone alone, over all frames; where that is above `limit`, perhaps of the first ones only, which
 * is above it too. */
static double error_alone(const nsdf_bones *b, const nsdf_motion *m, uint32_t block, uint32_t bone, double limit) {
    double sum = 0.0;
    for (uint32_t f = 0; f < b->frame_count && !(sum > limit); f++)
        for (int n = 0; n < POINTS; n++) {
            double y[4], x[3], d[3];
            rest_point(m, block, n, y);
            moved_point(m, f, block, n, x);
            miss(pose_of(b, f, bone), y, x, d);
            sum += d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        }
    return sum;
}

/* ---- Poses for given weights ----------------------------------------------------------------------------- */

/* Adds a block's share of the normal equations; the matrix is the same for all frames and coordinates. */
static void add_equations(const nsdf_bones *b, const nsdf_motion *m, uint32_t block, double *matrix, double *right) {
    const size_t size = 4 * (size_t)b->bone_count, columns = 3 * (size_t)b->frame_count;
    for (int n = 0; n < POINTS; n++) {
        double y[4], x[3];
        rest_point(m, block, n, y);
        for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
            const double wi = b->weight[block][i];
            const size_t at = 4 * (size_t)b->bone[block][i];
            for (int j = 0; wi > 0.0 && j < NSDF_BONE_INFLUENCES; j++)
                for (size_t p = 0; p < 4; p++)
                    for (size_t q = 0; q < 4; q++)
                        matrix[(at + p) * size + 4 * (size_t)b->bone[block][j] + q] +=
                            wi * b->weight[block][j] * y[p] * y[q];
            for (uint32_t f = 0; wi > 0.0 && f < b->frame_count; f++) {
                moved_point(m, f, block, n, x);
                for (size_t p = 0; p < 4; p++)
                    for (size_t k = 0; k < 3; k++)
                        right[(at + p) * columns + 3 * (size_t)f + k] += wi * y[p] * x[k];
            }
        }
    }
}

int nsdf_bones_solve_poses(nsdf_bones *b, const nsdf_motion *motion) {
    const size_t size = 4 * (size_t)b->bone_count, columns = 3 * (size_t)b->frame_count;
    double *matrix = calloc(size * size, sizeof *matrix), *right = calloc(size * columns, sizeof *right);
    if (matrix && right) {
        for (uint32_t k = 0; k < b->block_count; k++)
            add_equations(b, motion, k, matrix, right);
        for (size_t i = 0; i < size; i++)
            matrix[i * size + i] += regular;
        nsdf_solve_positive(matrix, size, right, columns);
        for (uint32_t f = 0; f < b->frame_count; f++)
            for (uint32_t i = 0; i < b->bone_count; i++)
                for (size_t n = 0; n < 12; n++)
                    b->poses[12 * ((size_t)f * b->bone_count + i) + n] =
                        right[(4 * (size_t)i + n % 4) * columns + 3 * (size_t)f + n / 4];
    }
    int result = matrix && right ? 0 : -1;
    free(matrix);
    free(right);
    return result;
}

/* ---- Weights for given poses ----------------------------------------------------------------------------- */

/* The bones that fit a block best alone, best first. */
static int best_bones(const nsdf_bones *b, const nsdf_motion *m, uint32_t block, uint32_t chosen[CANDIDATES]) {
    double errors[CANDIDATES];
    int count = 0;
    for (uint32_t i = 0; i < b->bone_count; i++) {
        double e = error_alone(b, m, block, i, count < CANDIDATES ? INFINITY : errors[CANDIDATES - 1]);
        int at = count < CANDIDATES ? count++ : CANDIDATES;
        for (; at > 0 && errors[at - 1] > e; at--)
            if (at < CANDIDATES) {
                errors[at] = errors[at - 1];
                chosen[at] = chosen[at - 1];
            }
        if (at < CANDIDATES) {
            errors[at] = e;
            chosen[at] = i;
        }
    }
    return count;
}

/* gram[i][j] = sum of the products of the candidates' misses: with weights that sum to 1 the blend's squared error is
 * w^T gram w. */
static void gram_matrix(const nsdf_bones *b, const nsdf_motion *m, uint32_t block, const uint32_t *chosen, int count,
                        double gram[CANDIDATES][CANDIDATES]) {
    memset(gram, 0, CANDIDATES * sizeof *gram);
    for (uint32_t f = 0; f < b->frame_count; f++)
        for (int n = 0; n < POINTS; n++) {
            double y[4], x[3], d[CANDIDATES][3];
            rest_point(m, block, n, y);
            moved_point(m, f, block, n, x);
            for (int i = 0; i < count; i++)
                miss(pose_of(b, f, chosen[i]), y, x, d[i]);
            for (int i = 0; i < count; i++)
                for (int j = 0; j < count; j++)
                    gram[i][j] += d[i][0] * d[j][0] + d[i][1] * d[j][1] + d[i][2] * d[j][2];
        }
}

/* The weights of least error on a set of candidates, with sum 1.  Returns the error, or infinity when one is below 0.
 */
static double solve_weights(double gram[CANDIDATES][CANDIDATES], const int *set, int count, double *w) {
    double a[NSDF_BONE_INFLUENCES * NSDF_BONE_INFLUENCES], sum = 0.0, error = 0.0;
    for (int i = 0; i < count; i++) {
        w[i] = 1.0;
        for (int j = 0; j < count; j++)
            a[i * count + j] = gram[set[i]][set[j]] + (i == j ? 1e-12 + 1e-9 * gram[set[i]][set[i]] : 0.0);
    }
    nsdf_solve_positive(a, (size_t)count, w, 1);
    for (int i = 0; i < count; i++)
        sum += w[i];
    for (int i = 0; i < count; i++)
        w[i] /= sum;
    for (int i = 0; i < count; i++) {
        if (!(w[i] >= 0.0))
            return INFINITY;
        for (int j = 0; j < count; j++)
            error += w[i] * w[j] * gram[set[i]][set[j]];
    }
    return error;
}

/* Takes the candidate that helps most, again and again. */
static void choose_weights(void *data, uint32_t block, uint32_t worker) {
    const job *j = data;
    nsdf_bones *b = j->bones;
    uint32_t chosen[CANDIDATES];
    double gram[CANDIDATES][CANDIDATES], best[NSDF_BONE_INFLUENCES] = {1.0};
    int set[NSDF_BONE_INFLUENCES] = {0}, used = 1, count = best_bones(b, j->motion, block, chosen);
    (void)worker;
    gram_matrix(b, j->motion, block, chosen, count, gram);
    double error = gram[0][0];
    for (int grown = 1; grown && used < NSDF_BONE_INFLUENCES;) {
        int trial[NSDF_BONE_INFLUENCES], found = -1;
        double w[NSDF_BONE_INFLUENCES], found_weights[NSDF_BONE_INFLUENCES], least = 0.999 * error;
        memcpy(trial, set, sizeof trial);
        for (int c = 1; c < count; c++) {
            trial[used] = c;
            double e = solve_weights(gram, trial, used + 1, w);
            if (e < least) {
                least = e;
                found = c;
                memcpy(found_weights, w, sizeof w);
            }
        }
        grown = found >= 0;
        if (grown) {
            set[used++] = found;
            error = least;
            memcpy(best, found_weights, sizeof best);
        }
    }
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
        b->bone[block][i] = chosen[i < used ? set[i] : set[0]];
        b->weight[block][i] = i < used ? best[i] : 0.0;
    }
    j->errors[block] = error;
}

/* ---- Growing --------------------------------------------------------------------------------------------- */

/* Every block on the one bone that fits it best. */
static void assign(void *data, uint32_t block, uint32_t worker) {
    const job *j = data;
    nsdf_bones *b = j->bones;
    const double before = error_alone(b, j->motion, block, b->bone[block][0], INFINITY);
    uint32_t best = 0;
    (void)worker;
    j->errors[block] = INFINITY;
    for (uint32_t i = 0; i < b->bone_count; i++) {
        double e = error_alone(b, j->motion, block, i, fmin(before, j->errors[block]));
        if (e < j->errors[block]) {
            j->errors[block] = e;
            best = i;
        }
    }
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
        b->bone[block][i] = best;
        b->weight[block][i] = i == 0;
    }
}

static double rest_distance(const nsdf_motion *m, uint32_t a, uint32_t b) {
    double sum = 0.0;
    for (int k = 0; k < 3; k++) {
        double d = (double)(m->centres[a][k] - m->centres[b][k]);
        sum += d * d;
    }
    return sqrt(sum);
}

/* New bones where the error is largest; blocks near a seed move to it. */
static void seed_bones(job *j, uint32_t count, double *left) {
    nsdf_bones *b = j->bones;
    memcpy(left, j->errors, b->block_count * sizeof *left);
    for (uint32_t n = 0; n < count; n++) {
        uint32_t seed = 0;
        for (uint32_t k = 1; k < b->block_count; k++)
            seed = left[k] > left[seed] ? k : seed;
        const double reach = spread * (double)j->motion->radius;
        for (uint32_t k = 0; k < b->block_count; k++) {
            if (rest_distance(j->motion, k, seed) > reach)
                continue;
            left[k] = -1.0;
            if (rest_distance(j->motion, k, seed) < 0.75 * reach)
                b->bone[k][0] = b->bone_count;
        }
        left[seed] = -1.0;
        b->bone[seed][0] = b->bone_count++;
    }
}

/* Where a block is not there, its bones tell how it would move. */
static void fill_absence(void *data, uint32_t block, uint32_t worker) {
    const job *j = data;
    const nsdf_bones *b = j->bones;
    nsdf_motion *m = j->motion;
    const float *centre = m->centres[block];
    (void)worker;
    for (uint32_t f = 0; f < m->frame_count; f++) {
        if (f >= m->lives[block][0] && f <= m->lives[block][1])
            continue;
        nsdf_pose *pose = &m->poses[(size_t)f * m->block_count + block];
        memset(pose, 0, sizeof *pose);
        for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
            const double *bone = pose_of(b, f, b->bone[block][i]), w = b->weight[block][i];
            for (int row = 0; row < 3; row++) {
                pose->position[row] += w * bone[4 * row + 3];
                for (int k = 0; k < 3; k++) {
                    pose->linear[3 * row + k] += w * bone[4 * row + k];
                    pose->position[row] += w * bone[4 * row + k] * (double)centre[k];
                }
            }
        }
    }
}

static int solve_poses(job *j, nsdf_workers *workers) {
    const int failed = nsdf_bones_solve_poses(j->bones, j->motion);
    if (!failed)
        nsdf_workers_run(workers, j->bones->block_count, fill_absence, j);
    return failed;
}

static int grow(job *j, uint32_t count, nsdf_workers *workers, double *left) {
    nsdf_bones *b = j->bones;
    int failed = solve_poses(j, workers);
    nsdf_workers_run(workers, b->block_count, assign, j);
    while (!failed && b->bone_count < count) {
        uint32_t more = (b->bone_count + 1) / 2;
        seed_bones(j, more < count - b->bone_count ? more : count - b->bone_count, left);
        for (int round = 0; !failed && round < GROWTH_ROUNDS; round++) {
            failed = solve_poses(j, workers);
            if (!failed)
                nsdf_workers_run(workers, b->block_count, assign, j);
        }
    }
    for (int round = 0; !failed && round < FINAL_ROUNDS; round++) {
        nsdf_workers_run(workers, b->block_count, choose_weights, j);
        failed = solve_poses(j, workers);
    }
    return failed;
}

int nsdf_bones_fit(nsdf_bones *bones, nsdf_motion *motion, uint32_t count, nsdf_workers *workers) {
    const size_t k = motion->block_count;
    double *left = calloc(k, sizeof *left);
    memset(bones, 0, sizeof *bones);
    job j = {bones, motion, calloc(k, sizeof(double))};
    bones->block_count = motion->block_count;
    bones->frame_count = motion->frame_count;
    bones->bone_count = 1;
    bones->bone = calloc(k, sizeof *bones->bone);
    bones->weight = calloc(k, sizeof *bones->weight);
    bones->poses = calloc(12 * (size_t)count * motion->frame_count, sizeof *bones->poses);
    int failed = !left || !j.errors || !bones->bone || !bones->weight || !bones->poses;
    for (size_t i = 0; !failed && i < k; i++)
        bones->weight[i][0] = 1.0;
    count = count < motion->block_count ? count : motion->block_count;
    if (!failed)
        failed = grow(&j, count, workers, left);
    for (size_t i = 0; !failed && i < k; i++)
        bones->error += j.errors[i];
    bones->error = sqrt(bones->error / ((double)k * motion->frame_count));
    free(left);
    free(j.errors);
    if (failed)
        nsdf_bones_free(bones);
    return failed ? -1 : 0;
}

void nsdf_bones_free(nsdf_bones *bones) {
    free(bones->bone);
    free(bones->weight);
    free(bones->poses);
    memset(bones, 0, sizeof *bones);
}
