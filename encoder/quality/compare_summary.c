#include "nsdf/compare.h"

#include <math.h>

double nsdf_psnr(double mean_square, double peak) {
    return mean_square > 0.0 ? 10.0 * log10(3.0 * peak * peak / mean_square) : INFINITY;
}

/* Mean squares over the frames, of one direction. */
typedef struct squares {
    double distance, point, normal;
} squares;

static void add_direction(const nsdf_distances *distances, squares *sum, int direction,
                          nsdf_difference_summary *summary) {
    sum->distance += distances->rms * distances->rms;
    sum->point += distances->point_rms * distances->point_rms;
    sum->normal += distances->normal_rms * distances->normal_rms;
    summary->mean[direction] += distances->mean;
    summary->normal_mean[direction] += distances->normal_mean;
    summary->max[direction] = fmax(summary->max[direction], distances->max);
}

static void add_frame(const nsdf_difference *difference, squares sum[2], nsdf_difference_summary *summary) {
    add_direction(&difference->to_decoded, &sum[0], 0, summary);
    add_direction(&difference->to_reference, &sum[1], 1, summary);
    summary->hausdorff_mean += difference->hausdorff;
    summary->hausdorff_max = fmax(summary->hausdorff_max, difference->hausdorff);
    summary->fmpd_mean += difference->fmpd;
    summary->fmpd_max = fmax(summary->fmpd_max, difference->fmpd);
    summary->component_mismatches += difference->reference.components != difference->decoded.components;
    summary->euler_mismatches += difference->reference.euler != difference->decoded.euler;
    const double hidden[2] = {difference->reference.hidden_share, difference->decoded.hidden_share};
    for (int k = 0; k < 2; k++) {
        summary->hidden_mean[k] += hidden[k];
        summary->hidden_max[k] = fmax(summary->hidden_max[k], hidden[k]);
    }
}

nsdf_status nsdf_compare_summarise(const nsdf_difference *differences, uint32_t count, double peak,
                                   nsdf_difference_summary *summary) {
    if (differences == NULL || summary == NULL || count == 0 || !(peak > 0.0)) {
        return NSDF_INVALID_ARGUMENT;
    }
    nsdf_difference_summary s = {.frames = count};
    squares sum[2] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (uint32_t i = 0; i < count; i++) {
        add_frame(&differences[i], sum, &s);
    }
    for (int k = 0; k < 2; k++) {
        s.mean[k] /= count;
        s.normal_mean[k] /= count;
        s.hidden_mean[k] /= count;
        s.rms[k] = sqrt(sum[k].distance / count);
        s.normal_rms[k] = sqrt(sum[k].normal / count);
    }
    s.hausdorff_mean /= count;
    s.fmpd_mean /= count;
    s.psnr_d1 = nsdf_psnr(fmax(sum[0].point, sum[1].point) / count, peak);
    s.psnr_d2 = nsdf_psnr(fmax(sum[0].distance, sum[1].distance) / count, peak);
    *summary = s;
    return NSDF_OK;
}
