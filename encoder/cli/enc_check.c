#include "enc_check.h"

#include "cli_util.h"
#include "enc_dirt.h"
#include "enc_frames.h"

#include <stdio.h>
#include <string.h>

enum { TEXT = 800 };

/* ---- Frames ------------------------------------------------------------------------------------------------- */

typedef struct {
    const enc_options *options;
    nsdf_sequence *sequence;
    nsdf_cli_file file;
    nsdf_mesh_report sum;
    uint32_t checked, refused;
    uint32_t missing; /* frames without a file */
} checker;

/* Returns 1 when the frame can be encoded; otherwise *error says why not. */
static int check_frame(checker *c, uint32_t frame, nsdf_mesh_report *report, nsdf_encoder_error *error) {
    nsdf_input_mesh mesh;
    if (nsdf_sequence_load(c->sequence, frame, &mesh, error) != NSDF_OK)
        return 0; /* names the file */
    if (nsdf_encoder_check_mesh(&c->options->encoder, &mesh, report, error) == NSDF_OK)
        return 1;
    char message[sizeof error->message], name[400];
    nsdf_sequence_name_frame(c->sequence, frame, name, sizeof name);
    memcpy(message, error->message, sizeof message);
    snprintf(error->message, sizeof error->message, "%.120s: %.110s", name,
             strncmp(message, "frame 0: ", 9) == 0 ? message + 9 : message);
    return 0;
}

static void print_frame(checker *c, uint32_t frame, const nsdf_mesh_report *report, const nsdf_encoder_error *error) {
    char wrong[TEXT], done[TEXT], name[400];
    if (error) {
        nsdf_cli_file_print(&c->file, "%s: cannot be encoded\n", error->message);
        return;
    }
    enc_name_dirt(report, wrong, sizeof wrong);
    enc_explain_dirt(report, 1, c->options->encoder.shell > 0.0, done, sizeof done);
    nsdf_sequence_name_frame(c->sequence, frame, name, sizeof name);
    nsdf_cli_file_print(&c->file, "%s: %llu vertices, %llu triangles, %llu piece%s; %s%s%s\n", name,
                        (unsigned long long)report->vertices, (unsigned long long)report->triangles,
                        (unsigned long long)report->components, report->components == 1 ? "" : "s", wrong,
                        *done ? " -> " : "", done);
}

static void put_frame(checker *c, uint32_t frame, const nsdf_mesh_report *report, const nsdf_encoder_error *error) {
    nsdf_cli_file_print(&c->file, "%s\n    {\"frame\": %u, \"file\": ", c->checked > 1 ? "," : "", frame);
    nsdf_cli_file_print_json(&c->file, nsdf_sequence_frame_path(c->sequence, frame));
    if (error) {
        nsdf_cli_file_print(&c->file, ", \"encodable\": false, \"error\": ");
        nsdf_cli_file_print_json(&c->file, error->message);
    } else {
        nsdf_cli_file_print(&c->file, ", \"encodable\": true, \"mesh\": ");
        enc_put_dirt(&c->file, report);
    }
    nsdf_cli_file_print(&c->file, "}");
}

static void visit(checker *c, uint32_t frame) {
    nsdf_mesh_report report = {0};
    nsdf_encoder_error error;
    const int good = check_frame(c, frame, &report, &error);
    c->checked++;
    c->refused += !good;
    if (good)
        nsdf_join_reports(&c->sum, &report);
    if (c->options->check == ENC_CHECK_JSON)
        put_frame(c, frame, &report, good ? NULL : &error);
    else if (!c->options->quiet)
        print_frame(c, frame, &report, good ? NULL : &error);
}

/* ---- All ---------------------------------------------------------------------------------------------------- */

static void print_summary(checker *c, const char *missing) {
    const uint32_t good = c->checked - c->refused;
    char done[TEXT];
    if (c->refused > 0)
        nsdf_cli_file_print(&c->file, "%u of %u frames cannot be encoded", c->refused, c->checked);
    else
        nsdf_cli_file_print(&c->file, "%u frame%s can be encoded, %llu of them not clean", c->checked,
                            c->checked == 1 ? "" : "s", (unsigned long long)c->sum.dirty);
    enc_explain_dirt(&c->sum, good, c->options->encoder.shell > 0.0, done, sizeof done);
    if (*done)
        nsdf_cli_file_print(&c->file, "; of each: %s", done);
    nsdf_cli_file_print(&c->file, "\n");
    if (*missing)
        nsdf_cli_file_print(&c->file, "%s\n", missing);
}

static void put_summary(checker *c) {
    char missing[TEXT];
    nsdf_sequence_missing(c->sequence, missing, sizeof missing);
    nsdf_cli_file_print(&c->file, "\n  ],\n  \"frame_count\": %u, \"refused\": %u, \"missing\": ", c->checked,
                        c->refused);
    nsdf_cli_file_print_json(&c->file, missing);
    nsdf_cli_file_print(&c->file, ", \"interpolated\": %u", c->missing);
    nsdf_cli_file_print(&c->file, ", \"encodable\": %s,\n  \"mesh\": ", c->refused ? "false" : "true");
    enc_put_dirt(&c->file, &c->sum);
    nsdf_cli_file_print(&c->file, "\n}\n");
}

int enc_check(const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list) {
    checker c = {.options = options, .sequence = sequence};
    char missing[TEXT];
    c.missing = enc_explain_missing(sequence, missing, sizeof missing);
    const int json = options->check == ENC_CHECK_JSON;
    if (nsdf_cli_file_open(&c.file, options->output ? options->output : "-") != 0)
        return NSDF_CLI_FAILURE;
    if (json)
        nsdf_cli_file_print(&c.file, "{\"frames\": [");
    for (uint32_t i = 0; i < list->count && nsdf_cli_interrupts() == 0; i++) {
        nsdf_cli_progress("checking %u of %u", i + 1, list->count);
        visit(&c, list->numbers[i]);
    }
    if (json)
        put_summary(&c);
    else
        print_summary(&c, missing);
    if (nsdf_cli_interrupts() > 0) {
        nsdf_cli_file_drop(&c.file);
        return NSDF_CLI_FAILURE;
    }
    if (nsdf_cli_file_close(&c.file) != 0 || nsdf_cli_commit() != 0)
        return NSDF_CLI_FAILURE;
    return c.refused ? NSDF_CLI_FAILURE : NSDF_CLI_SUCCESS;
}
