#include "nsdf_ref_parts.h"

#include <math.h>

/* Section 10.6. */

static ref_tensor read_moving(ref_reader *r, ref_part *part, uint32_t rows, uint32_t cols) {
    const ref_tensor t = ref_read_tensor(r, part, rows, cols);
    ref_demand(r, t.kind <= 1, "poses or coefficients are neither constant nor spline");
    return t;
}

static ref_tensor read_constant(ref_reader *r, ref_part *part, uint32_t rows, uint32_t cols) {
    const ref_tensor t = ref_read_tensor(r, part, rows, cols);
    ref_demand(r, t.kind == 0, "a tensor of blocks is not constant");
    return t;
}

void ref_read_blocks(ref_reader *r, ref_part *part) {
    ref_blocks *b = &part->blocks;
    part->entropy = ref_take_uint(r, 1);
    b->degree = ref_take_uint(r, 1);
    b->influences = ref_take_uint(r, 1);
    b->bone_count = ref_take_uint(r, 2);
    b->block_count = ref_take_uint(r, 4);
    b->fade = ref_take_f32(r);
    ref_demand(r, part->entropy <= 3, "the entropy back end is out of range");
    ref_demand(r, b->degree <= 3, "the degree is out of range");
    ref_demand(r, b->influences >= 1 && b->influences <= 8, "influences are out of range");
    ref_demand(r, b->bone_count >= 1 && b->bone_count <= 1024, "the number of bones is out of range");
    ref_demand(r, b->block_count >= 1 && b->block_count <= 65536, "the number of blocks is out of range");
    ref_demand(r, b->fade >= 0.0f && b->fade <= 1.0f, "fade is out of range");
    b->centres = read_constant(r, part, b->block_count, 3);
    b->radii = read_constant(r, part, b->block_count, 1);
    b->lives = read_constant(r, part, b->block_count, 2);
    b->bones = read_constant(r, part, b->block_count, b->influences);
    b->weights = read_constant(r, part, b->block_count, b->influences);
    b->anchors = read_constant(r, part, b->bone_count, 4);
    b->poses = read_moving(r, part, b->bone_count, 12);
    for (uint32_t d = 0; d <= b->degree; d++)
        b->coefficients[d] = read_moving(r, part, b->block_count, (d + 1) * (d + 2) / 2);
}

static double constant(const ref_tensor *t, uint32_t row, uint32_t col) {
    return ref_element(t, row, col, 0.0);
}

void ref_check_blocks(const ref_reader *r, const ref_part *part) {
    const ref_blocks *b = &part->blocks;
    for (uint32_t k = 0; k < b->block_count; k++) {
        ref_demand(r, constant(&b->radii, k, 0) > 0.0, "a radius is not positive");
        for (uint32_t i = 0; i < b->influences; i++) {
            const double bone = constant(&b->bones, k, i);
            ref_demand(r, bone >= 0.0 && bone <= b->bone_count - 1.0 && bone == floor(bone), "there is no such bone");
        }
    }
    for (uint32_t i = 0; i < b->bone_count; i++)
        ref_demand(r, constant(&b->anchors, i, 3) > 0.0, "an extent is not positive");
}

/* Section 11.2. */

static double life(const ref_blocks *b, uint32_t k, double u) {
    const double from = constant(&b->lives, k, 0), to = constant(&b->lives, k, 1), fade = (double)b->fade;
    if (!(from <= u && u <= to))
        return 0.0;
    const double in = from <= 0.0 || fade == 0.0 ? 1.0 : (u - from) / fade;
    const double out = to >= 1.0 || fade == 0.0 ? 1.0 : (to - u) / fade;
    return fmin(1.0, fmin(in, out));
}

/* A_k and c_k. */
static void motion(const ref_blocks *b, uint32_t k, double u, double a[3][3], double c[3]) {
    for (int row = 0; row < 3; row++)
        c[row] = a[row][0] = a[row][1] = a[row][2] = 0.0;
    for (uint32_t i = 0; i < b->influences; i++) {
        const uint32_t bone = (uint32_t)constant(&b->bones, k, i);
        const double weight = constant(&b->weights, k, i), extent = constant(&b->anchors, bone, 3);
        for (uint32_t row = 0; row < 3; row++) {
            c[row] += weight * ref_element(&b->poses, bone, 4 * row + 3, u);
            for (uint32_t col = 0; col < 3; col++) {
                const double m = ref_element(&b->poses, bone, 4 * row + col, u) / extent;
                a[row][col] += weight * m;
                c[row] += weight * m * (constant(&b->centres, k, col) - constant(&b->anchors, bone, col));
            }
        }
    }
}

static double determinant(double a[3][3]) {
    double sum = 0.0;
    for (int i = 0; i < 3; i++)
        sum += a[0][i] * (a[1][(i + 1) % 3] * a[2][(i + 2) % 3] - a[1][(i + 2) % 3] * a[2][(i + 1) % 3]);
    return sum;
}

/* False if there is no inverse in finite numbers. */
static bool invert(double a[3][3], double inverse[3][3]) {
    const double det = determinant(a);
    bool finite = true;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int r1 = (j + 1) % 3, r2 = (j + 2) % 3, c1 = (i + 1) % 3, c2 = (i + 2) % 3;
            inverse[i][j] = (a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1]) / det;
            finite = finite && isfinite(inverse[i][j]);
        }
    return finite;
}

/* A block at one time: U_k, c_k, r_k and l_k. */
typedef struct placed {
    double map[3][3], centre[3], radius, life;
} placed;

/* False if the block is not there. */
static bool place(const ref_blocks *b, uint32_t k, double u, placed *at) {
    double a[3][3];
    at->life = life(b, k, u);
    at->radius = constant(&b->radii, k, 0);
    if (!(at->life > 0.0))
        return false;
    motion(b, k, u, a, at->centre);
    if (!invert(a, at->map))
        return false;
    for (int i = 0; i < 9; i++)
        at->map[i / 3][i % 3] /= at->radius;
    return true;
}

/* u_k */
static void to_block(const placed *at, const double x[3], double local[3]) {
    for (int i = 0; i < 3; i++) {
        local[i] = 0.0;
        for (int j = 0; j < 3; j++)
            local[i] += at->map[i][j] * (x[j] - at->centre[j]);
    }
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double base(uint32_t degree, double t) {
    switch (degree) {
    case 0:
        return 1.0;
    case 1:
        return t;
    case 2:
        return t * t - 1.0 / 9.0;
    default:
        return t * t * t - 3.0 / 11.0 * t;
    }
}

static double polynomial(const ref_blocks *b, uint32_t k, double u, const double p[3]) {
    double sum = 0.0;
    for (uint32_t d = 0; d <= b->degree; d++)
        for (uint32_t i = 0, col = 0; i <= d; i++)
            for (uint32_t j = 0; j <= i; j++, col++) /* degrees d - i, i - j and j */
                sum +=
                    ref_element(&b->coefficients[d], k, col, u) * base(d - i, p[0]) * base(i - j, p[1]) * base(j, p[2]);
    return sum;
}

/* P_0 to P_3 and their slopes at 0. */
static const double base_at_0[4] = {1.0, 0.0, -1.0 / 9.0, 0.0};
static const double slope_at_0[4] = {0.0, 1.0, 0.0, -3.0 / 11.0};

/* g_k */
static void gradient_at_0(const ref_blocks *b, uint32_t k, double u, double g[3]) {
    g[0] = g[1] = g[2] = 0.0;
    for (uint32_t d = 0; d <= b->degree; d++)
        for (uint32_t i = 0, col = 0; i <= d; i++)
            for (uint32_t j = 0; j <= i; j++, col++) {
                const double c = ref_element(&b->coefficients[d], k, col, u);
                g[0] += c * slope_at_0[d - i] * base_at_0[i - j] * base_at_0[j];
                g[1] += c * base_at_0[d - i] * slope_at_0[i - j] * base_at_0[j];
                g[2] += c * base_at_0[d - i] * base_at_0[i - j] * slope_at_0[j];
            }
}

/* The block's term of s. */
static double wind(const ref_blocks *b, uint32_t k, double u, placed *at, const double x[3]) {
    const double away[3] = {at->centre[0] - x[0], at->centre[1] - x[1], at->centre[2] - x[2]};
    double g[3], m[3];
    gradient_at_0(b, k, u, g);
    const double length = sqrt(dot(g, g));
    if (!(length > 0.0))
        return 0.0;
    for (int i = 0; i < 3; i++)
        m[i] = at->life * (at->map[0][i] * g[0] + at->map[1][i] * g[1] + at->map[2][i] * g[2]) /
               (20.0 * length * determinant(at->map));
    return dot(m, away) / pow(dot(away, away) + 1e-12, 1.5);
}

static double outside(const ref_blocks *b, const double x[3], double u) {
    double least = 64.0 * 64.0, size = 64.0, s = 0.0;
    for (uint32_t k = 0; k < b->block_count; k++) {
        placed at;
        if (!place(b, k, u, &at))
            continue;
        const double away[3] = {x[0] - at.centre[0], x[1] - at.centre[1], x[2] - at.centre[2]};
        if (dot(away, away) < least) {
            least = dot(away, away);
            size = fmax(sqrt(least) - at.radius / 2.0, at.radius / 4.0);
        }
        s += wind(b, k, u, &at, x);
    }
    return s > 0.5 ? -size : size;
}

double ref_evaluate_blocks(const ref_part *part, const double point[3], double u) {
    const ref_blocks *b = &part->blocks;
    double weights = 0.0, sum = 0.0;
    bool inside = false;
    for (uint32_t k = 0; k < b->block_count; k++) {
        placed at;
        double p[3];
        if (!place(b, k, u, &at))
            continue;
        to_block(&at, point, p);
        if (dot(p, p) < 1.0) {
            const double weight = at.life * pow(1.0 - dot(p, p), 2.0);
            inside = true;
            weights += weight;
            sum += weight * polynomial(b, k, u, p);
        }
    }
    return inside ? sum / weights : outside(b, point, u);
}
