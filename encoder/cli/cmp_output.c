#include "cmp_output.h"

#include <math.h>
#include <stdio.h>

static int measured(const cmp_result *r, uint32_t bit) {
    return (r->options->compare.measures & bit) != 0;
}

/* A distance in the units of the output. */
static double scaled(const cmp_result *r, double world) {
    return r->options->world ? world : world / r->diagonal;
}

static double psnr_d1(const cmp_result *r, const nsdf_difference *d) {
    const double rms = fmax(d->to_decoded.point_rms, d->to_reference.point_rms);
    return nsdf_psnr(rms * rms, r->peak);
}

static double psnr_d2(const cmp_result *r, const nsdf_difference *d) {
    const double rms = fmax(d->to_decoded.rms, d->to_reference.rms);
    return nsdf_psnr(rms * rms, r->peak);
}

/* ---- One frame as named values -------------------------------------------------------------------------- */

typedef struct field {
    const char *name;
    double value; /* counts are whole numbers */
    int known;
} field;

enum { MOST_FIELDS = 32 };

typedef struct fields {
    field items[MOST_FIELDS];
    int count;
} fields;

static void add(fields *f, const char *name, double value, int known) {
    f->items[f->count++] = (field){name, value, known};
}

static void add_distances(const cmp_result *r, const nsdf_difference *d, fields *f) {
    add(f, "mean_to_dec", scaled(r, d->to_decoded.mean), 1);
    add(f, "mean_to_ref", scaled(r, d->to_reference.mean), 1);
    add(f, "rms_to_dec", scaled(r, d->to_decoded.rms), 1);
    add(f, "rms_to_ref", scaled(r, d->to_reference.rms), 1);
    add(f, "max_to_dec", scaled(r, d->to_decoded.max), 1);
    add(f, "max_to_ref", scaled(r, d->to_reference.max), 1);
    add(f, "hausdorff", scaled(r, d->hausdorff), 1);
    add(f, "psnr_d1", psnr_d1(r, d), measured(r, NSDF_COMPARE_POINTS));
    add(f, "psnr_d2", psnr_d2(r, d), 1);
    add(f, "normal_to_dec", d->to_decoded.normal_mean, measured(r, NSDF_COMPARE_NORMALS));
    add(f, "normal_to_ref", d->to_reference.normal_mean, measured(r, NSDF_COMPARE_NORMALS));
    add(f, "fmpd", d->fmpd, measured(r, NSDF_COMPARE_FMPD));
}

static int leaves_out(const cmp_result *r, uint32_t mesh) {
    return (r->options->compare.outer & mesh) != 0;
}

/* Shares of the area; there with --outer only. */
static void add_hidden(const cmp_result *r, const nsdf_difference *d, fields *f) {
    if (leaves_out(r, NSDF_COMPARE_REFERENCE))
        add(f, "ref_hidden", d->reference.hidden_share, 1);
    if (leaves_out(r, NSDF_COMPARE_DECODED))
        add(f, "dec_hidden", d->decoded.hidden_share, 1);
}

static void add_hidden_summary(const cmp_result *r, fields *f) {
    if (leaves_out(r, NSDF_COMPARE_REFERENCE)) {
        add(f, "ref_hidden_mean", r->summary.hidden_mean[0], 1);
        add(f, "ref_hidden_max", r->summary.hidden_max[0], 1);
    }
    if (leaves_out(r, NSDF_COMPARE_DECODED)) {
        add(f, "dec_hidden_mean", r->summary.hidden_mean[1], 1);
        add(f, "dec_hidden_max", r->summary.hidden_max[1], 1);
    }
}

static void add_shapes(const cmp_result *r, const nsdf_difference *d, fields *f) {
    const int known = measured(r, NSDF_COMPARE_SHAPES);
    add(f, "ref_components", d->reference.components, known);
    add(f, "dec_components", d->decoded.components, known);
    add(f, "ref_euler", (double)d->reference.euler, known);
    add(f, "dec_euler", (double)d->decoded.euler, known);
    add(f, "ref_open_edges", d->reference.open_edges, known);
    add(f, "dec_open_edges", d->decoded.open_edges, known);
    add(f, "ref_volume", d->reference.volume, known);
    add(f, "dec_volume", d->decoded.volume, known);
}

static fields fields_of(const cmp_result *r, uint32_t i) {
    const nsdf_difference *d = &r->differences[i];
    fields f = {.count = 0};
    add(&f, "frame", r->frames[i], 1);
    add(&f, "ref_vertices", d->reference.vertices, 1);
    add(&f, "ref_triangles", d->reference.triangles, 1);
    add(&f, "dec_vertices", d->decoded.vertices, 1);
    add(&f, "dec_triangles", d->decoded.triangles, 1);
    add_distances(r, d, &f);
    add_shapes(r, d, &f);
    add_hidden(r, d, &f);
    return f;
}

static fields summary_fields(const cmp_result *r) {
    const nsdf_difference_summary *s = &r->summary;
    const int normals = measured(r, NSDF_COMPARE_NORMALS), fmpd = measured(r, NSDF_COMPARE_FMPD);
    const int shapes = measured(r, NSDF_COMPARE_SHAPES);
    fields f = {.count = 0};
    add(&f, "frames", s->frames, 1);
    add(&f, "mean_to_dec", scaled(r, s->mean[0]), 1);
    add(&f, "mean_to_ref", scaled(r, s->mean[1]), 1);
    add(&f, "mean", scaled(r, fmax(s->mean[0], s->mean[1])), 1);
    add(&f, "rms_to_dec", scaled(r, s->rms[0]), 1);
    add(&f, "rms_to_ref", scaled(r, s->rms[1]), 1);
    add(&f, "max_to_dec", scaled(r, s->max[0]), 1);
    add(&f, "max_to_ref", scaled(r, s->max[1]), 1);
    add(&f, "hausdorff_max", scaled(r, s->hausdorff_max), 1);
    add(&f, "hausdorff_mean", scaled(r, s->hausdorff_mean), 1);
    add(&f, "psnr_d1", s->psnr_d1, measured(r, NSDF_COMPARE_POINTS));
    add(&f, "psnr_d2", s->psnr_d2, 1);
    add(&f, "normal_to_dec", s->normal_mean[0], normals);
    add(&f, "normal_to_ref", s->normal_mean[1], normals);
    add(&f, "fmpd_max", s->fmpd_max, fmpd);
    add(&f, "fmpd_mean", s->fmpd_mean, fmpd);
    add(&f, "component_mismatches", s->component_mismatches, shapes);
    add(&f, "euler_mismatches", s->euler_mismatches, shapes);
    add_hidden_summary(r, &f);
    return f;
}

/* ---- CSV ------------------------------------------------------------------------------------------------ */

static void write_csv(const cmp_result *r, nsdf_cli_file *file) {
    for (uint32_t i = 0; i < r->count; i++) {
        const fields f = fields_of(r, i);
        for (int k = 0; i == 0 && k < f.count; k++)
            nsdf_cli_file_print(file, "%s%s", k ? "," : "", f.items[k].name);
        if (i == 0)
            nsdf_cli_file_print(file, "\n");
        for (int k = 0; k < f.count; k++) {
            nsdf_cli_file_print(file, "%s", k ? "," : "");
            if (f.items[k].known)
                nsdf_cli_file_print(file, "%.9g", f.items[k].value);
        }
        nsdf_cli_file_print(file, "\n");
    }
}

/* ---- JSON ----------------------------------------------------------------------------------------------- */

/* JSON has no infinity; what was not measured is null, too. */
static void put_field(nsdf_cli_file *file, const field *f) {
    if (f->known && isfinite(f->value))
        nsdf_cli_file_print(file, "\"%s\": %.9g", f->name, f->value);
    else
        nsdf_cli_file_print(file, "\"%s\": null", f->name);
}

static void write_json(const cmp_result *r, nsdf_cli_file *file) {
    const cmp_options *o = r->options;
    nsdf_cli_file_print(file, "{\n  \"reference\": ");
    nsdf_cli_file_print_json(file, o->reference);
    nsdf_cli_file_print(file, ",\n  \"decoded\": ");
    nsdf_cli_file_print_json(file, o->decoded);
    nsdf_cli_file_print(file, ",\n  \"units\": \"%s\",\n  \"diagonal\": %.9g,\n  \"peak\": %.9g,\n",
                        o->world ? "world" : "diagonal", r->diagonal, r->peak);
    nsdf_cli_file_print(file, "  \"samples\": %lu,\n  \"seed\": %llu,\n  \"fmpd_c\": 8,\n  \"frames\": [\n",
                        (unsigned long)o->compare.samples, (unsigned long long)o->compare.seed);
    for (uint32_t i = 0; i < r->count; i++) {
        const fields f = fields_of(r, i);
        nsdf_cli_file_print(file, "    {");
        for (int k = 0; k < f.count; k++) {
            nsdf_cli_file_print(file, "%s", k ? ", " : "");
            put_field(file, &f.items[k]);
        }
        nsdf_cli_file_print(file, "}%s\n", i + 1 < r->count ? "," : "");
    }
    nsdf_cli_file_print(file, "  ],\n  \"summary\": {\n");
    const fields f = summary_fields(r);
    for (int k = 0; k < f.count; k++) {
        nsdf_cli_file_print(file, "    ");
        put_field(file, &f.items[k]);
        nsdf_cli_file_print(file, "%s\n", k + 1 < f.count ? "," : "");
    }
    nsdf_cli_file_print(file, "  }\n}\n");
}

/* ---- Table ---------------------------------------------------------------------------------------------- */

/* Right-aligned; empty when not measured. */
static void put_cell(nsdf_cli_file *file, int width, const char *format, double value, int known)
    __attribute__((format(printf, 3, 0)));

static void put_cell(nsdf_cli_file *file, int width, const char *format, double value, int known) {
    char text[32] = "-";
    if (known)
        snprintf(text, sizeof text, format, value);
    nsdf_cli_file_print(file, " %*s", width, text);
}

static void write_rows(const cmp_result *r, nsdf_cli_file *file) {
    nsdf_cli_file_print(file, "%6s %9s %9s %9s %9s %9s %7s %7s %7s %7s %5s %5s\n", "frame", "mean>dec", "mean>ref",
                        "rms>dec", "rms>ref", "hausd.", "D1 dB", "D2 dB", "norm.", "FMPD", "comp.", "Euler");
    for (uint32_t i = 0; i < r->count; i++) {
        const nsdf_difference *d = &r->differences[i];
        const int shapes = measured(r, NSDF_COMPARE_SHAPES);
        nsdf_cli_file_print(file, "%6lu %9.3g %9.3g %9.3g %9.3g %9.3g", (unsigned long)r->frames[i],
                            scaled(r, d->to_decoded.mean), scaled(r, d->to_reference.mean),
                            scaled(r, d->to_decoded.rms), scaled(r, d->to_reference.rms), scaled(r, d->hausdorff));
        put_cell(file, 7, "%.2f", psnr_d1(r, d), measured(r, NSDF_COMPARE_POINTS));
        put_cell(file, 7, "%.2f", psnr_d2(r, d), 1);
        put_cell(file, 7, "%.2f", fmax(d->to_decoded.normal_mean, d->to_reference.normal_mean),
                 measured(r, NSDF_COMPARE_NORMALS));
        put_cell(file, 7, "%.4f", d->fmpd, measured(r, NSDF_COMPARE_FMPD));
        put_cell(file, 5, "%.0f", d->decoded.components, shapes);
        put_cell(file, 5, "%.0f", (double)d->decoded.euler, shapes);
        nsdf_cli_file_print(
            file, "%s\n",
            shapes && (d->decoded.components != d->reference.components || d->decoded.euler != d->reference.euler)
                ? " *"
                : "");
    }
}

static void write_hidden(const cmp_result *r, uint32_t mesh, const char *name, double mean, double most,
                         nsdf_cli_file *file) {
    if (leaves_out(r, mesh))
        nsdf_cli_file_print(file, "hidden surface of %s left out: %.3g %% of its area on average, %.3g %% at most\n",
                            name, 100.0 * mean, 100.0 * most);
}

static void write_summary(const cmp_result *r, nsdf_cli_file *file) {
    const nsdf_difference_summary *s = &r->summary;
    nsdf_cli_file_print(file, "\n%lu frame%s, %lu points each way; distances %s (diagonal %.6g, peak %.6g)\n",
                        (unsigned long)s->frames, s->frames == 1 ? "" : "s", (unsigned long)r->options->compare.samples,
                        r->options->world ? "in world units" : "as fractions of the diagonal", r->diagonal, r->peak);
    write_hidden(r, NSDF_COMPARE_REFERENCE, "REF", s->hidden_mean[0], s->hidden_max[0], file);
    write_hidden(r, NSDF_COMPARE_DECODED, "DEC", s->hidden_mean[1], s->hidden_max[1], file);
    nsdf_cli_file_print(file, "%-28s %12s %12s\n", "", "to decoded", "to reference");
    nsdf_cli_file_print(file, "%-28s %12.4g %12.4g\n", "mean", scaled(r, s->mean[0]), scaled(r, s->mean[1]));
    nsdf_cli_file_print(file, "%-28s %12.4g %12.4g\n", "root mean square", scaled(r, s->rms[0]), scaled(r, s->rms[1]));
    nsdf_cli_file_print(file, "%-28s %12.4g %12.4g\n", "largest", scaled(r, s->max[0]), scaled(r, s->max[1]));
    if (measured(r, NSDF_COMPARE_NORMALS))
        nsdf_cli_file_print(file, "%-28s %12.3f %12.3f\n", "normals, mean degrees", s->normal_mean[0],
                            s->normal_mean[1]);
    nsdf_cli_file_print(file, "%-28s %12.4g %12.4g\n", "Hausdorff, max and average", scaled(r, s->hausdorff_max),
                        scaled(r, s->hausdorff_mean));
    if (measured(r, NSDF_COMPARE_POINTS))
        nsdf_cli_file_print(file, "%-28s %12.2f\n", "PSNR D1, dB", s->psnr_d1);
    nsdf_cli_file_print(file, "%-28s %12.2f\n", "PSNR D2, dB", s->psnr_d2);
    if (measured(r, NSDF_COMPARE_FMPD))
        nsdf_cli_file_print(file, "%-28s %12.4f %12.4f  (c = 8)\n", "FMPD, max and average", s->fmpd_max, s->fmpd_mean);
    if (measured(r, NSDF_COMPARE_SHAPES))
        nsdf_cli_file_print(file, "%-28s %12lu %12lu  of %lu frames (* above)\n", "other components, other Euler",
                            (unsigned long)s->component_mismatches, (unsigned long)s->euler_mismatches,
                            (unsigned long)s->frames);
}

void cmp_output_write(const cmp_result *result, nsdf_cli_file *file) {
    switch (result->options->format) {
    case CMP_CSV:
        write_csv(result, file);
        break;
    case CMP_JSON:
        write_json(result, file);
        break;
    default:
        write_rows(result, file);
        write_summary(result, file);
        break;
    }
}
