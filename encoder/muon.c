#include "muon.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the gradients of the last twenty steps or so. */
static const float momentum_share = 0.95f;

/* Singular values s, at most 1, become a s + b s^3 + c s^5 five times: between 0.7 and 1.2 for all above 0.01. */
enum { ITERATIONS = 5 };
static const float a_share = 3.4445f, b_share = -4.7750f, c_share = 2.0315f;

/* ---- Memory ---------------------------------------------------------------------------------------------- */

/* Floats of a matrix as fit_kernels.h has panels: columns are points. */
static size_t panels_of(uint32_t size) {
    return (size + NSDF_PANEL - 1) / NSDF_PANEL;
}

static size_t panel_floats(uint32_t size) {
    return panels_of(size) * size * NSDF_PANEL;
}

/* The matrix itself, in panels: X, its transpose, X X^T and its square; by rows: what is multiplied from the left. */
size_t nsdf_muon_scratch(uint32_t size) {
    return 4 * panel_floats(size) + 2 * (((size_t)size * size + 15) / 16 * 16);
}

static int add_matrix(nsdf_muon *muon, size_t offset, uint32_t size) {
    nsdf_muon_matrix *m = &muon->matrices[muon->count++];
    void *scratch = NULL;
    m->offset = offset;
    m->size = size;
    m->momentum = calloc((size_t)size * size, sizeof *m->momentum);
    if (posix_memalign(&scratch, 64, nsdf_muon_scratch(size) * sizeof(float)) == 0)
        m->scratch = memset(scratch, 0, nsdf_muon_scratch(size) * sizeof(float));
    m->ahead = malloc((size_t)size * size * sizeof *m->ahead);
    return m->momentum && m->ahead && m->scratch ? 0 : -1;
}

int nsdf_muon_create(nsdf_muon *muon, const nsdf_model *model, const nsdf_fit_kernels *kernels) {
    memset(muon, 0, sizeof *muon);
    muon->kernels = kernels;
    for (uint32_t l = 0; l < model->desc.layer_count; l++) {
        const uint32_t weights = nsdf_weight_index(&model->desc, l);
        const nsdf_tensor_desc *t = &model->desc.list.tensors[weights];
        if (t->kind != NSDF_TENSOR_CONSTANT || t->rows != t->cols || t->rows < 2)
            continue;
        if (add_matrix(muon, (size_t)model->array_offset[weights][0], t->rows) != 0) {
            nsdf_muon_free(muon);
            return -1;
        }
    }
    return 0;
}

void nsdf_muon_free(nsdf_muon *muon) {
    for (uint32_t i = 0; i < muon->count; i++) {
        free(muon->matrices[i].momentum);
        free(muon->matrices[i].ahead);
        free(muon->matrices[i].scratch);
    }
    muon->count = 0;
}

/* ---- Orthogonalisation ----------------------------------------------------------------------------------- */

/* Columns of panel k. */
static uint32_t panel_width(uint32_t n, size_t k) {
    return n - k * NSDF_PANEL < NSDF_PANEL ? n - (uint32_t)k * NSDF_PANEL : NSDF_PANEL;
}

static void to_panels(uint32_t n, const float *matrix, float *panels) {
    for (size_t k = 0; k < panels_of(n); k++)
        for (uint32_t r = 0; r < n; r++)
            memcpy(panels + (k * n + r) * NSDF_PANEL, matrix + (size_t)r * n + k * NSDF_PANEL,
                   panel_width(n, k) * sizeof *panels);
}

/* The transpose. */
static void to_panels_turned(uint32_t n, const float *matrix, float *panels) {
    for (size_t k = 0; k < panels_of(n); k++)
        for (uint32_t c = 0; c < panel_width(n, k); c++)
            for (uint32_t r = 0; r < n; r++)
                panels[(k * n + r) * NSDF_PANEL + c] = matrix[(k * NSDF_PANEL + c) * n + r];
}

static void to_rows(uint32_t n, const float *panels, float *matrix) {
    for (size_t k = 0; k < panels_of(n); k++)
        for (uint32_t r = 0; r < n; r++)
            memcpy(matrix + (size_t)r * n + k * NSDF_PANEL, panels + (k * n + r) * NSDF_PANEL,
                   panel_width(n, k) * sizeof *panels);
}

static void product(const nsdf_fit_kernels *kernels, uint32_t n, const float *rows, const float *panels, float *out) {
    const size_t panel = (size_t)n * NSDF_PANEL;
    kernels->multiply(rows, n, n, n, panels, panel, out, panel, (uint32_t)panels_of(n));
}

/* Divides by the root of the sum of squares, which no singular value exceeds.  Returns whether it can. */
static int normalise(size_t count, float *matrix) {
    double square = 0.0;
    for (size_t i = 0; i < count; i++)
        square += (double)matrix[i] * (double)matrix[i];
    const float factor = (float)(1.0 / sqrt(square));
    if (!(square > 0.0) || !isfinite(factor))
        return 0;
    for (size_t i = 0; i < count; i++)
        matrix[i] *= factor;
    return 1;
}

/* X becomes a X + (b A + c A A) X with A = X X^T (Newton and Schulz). */
void nsdf_muon_orthogonalise(const nsdf_fit_kernels *kernels, uint32_t n, float *matrix, float *scratch) {
    const size_t panels = panel_floats(n), rounded = ((size_t)n * n + 15) / 16 * 16;
    float *x = scratch, *xt = x + panels, *a = xt + panels, *aa = a + panels, *left = aa + panels;
    float *copy = left + rounded;
    if (!normalise((size_t)n * n, matrix))
        return;
    memcpy(copy, matrix, (size_t)n * n * sizeof *copy);
    for (int i = 0; i < ITERATIONS; i++) {
        to_panels(n, copy, x);
        to_panels_turned(n, copy, xt);
        product(kernels, n, copy, xt, a);
        to_rows(n, a, left);
        product(kernels, n, left, a, aa);
        for (size_t k = 0; k < panels; k++)
            aa[k] = b_share * a[k] + c_share * aa[k];
        to_rows(n, aa, left);
        product(kernels, n, left, x, a);
        for (size_t k = 0; k < panels; k++)
            a[k] += a_share * x[k];
        to_rows(n, a, copy);
    }
    memcpy(matrix, copy, (size_t)n * n * sizeof *copy);
}

/* ---- Steps ----------------------------------------------------------------------------------------------- */

/* Nesterov's momentum; the step's root mean square is the rate, which Adam's never exceeds by much. */
static void step_matrix(void *data, uint32_t index, uint32_t worker) {
    const nsdf_muon *muon = data;
    const nsdf_muon_matrix *m = &muon->matrices[index];
    const size_t count = (size_t)m->size * m->size;
    const float rest = 1.0f - momentum_share, factor = muon->rate * sqrtf((float)m->size);
    float *gradient = muon->gradient + m->offset, *parameters = muon->parameters + m->offset;
    (void)worker;
    for (size_t i = 0; i < count; i++) {
        m->momentum[i] = momentum_share * m->momentum[i] + rest * gradient[i];
        m->ahead[i] = momentum_share * m->momentum[i] + rest * gradient[i];
    }
    nsdf_muon_orthogonalise(muon->kernels, m->size, m->ahead, m->scratch);
    for (size_t i = 0; i < count; i++)
        parameters[i] -= factor * m->ahead[i];
    memset(gradient, 0, count * sizeof *gradient);
}

void nsdf_muon_step(nsdf_muon *muon, nsdf_workers *workers, float *parameters, float *gradient, double rate) {
    muon->gradient = gradient;
    muon->parameters = parameters;
    muon->rate = (float)rate;
    nsdf_workers_run(workers, muon->count, step_matrix, muon);
}
