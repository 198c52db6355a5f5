/* What is wrong with the input, and what is done about it, in words. */
#ifndef ENC_DIRT_H
#define ENC_DIRT_H

#include "cli_util.h"
#include "nsdf/mesh_report.h"

#include <stddef.h>

/* One line: what is done about `frames` frames; "" where nothing is to be said.  asked = the thickness of sheets comes
 * from --shell.  Returns text. */
const char *enc_explain_dirt(const nsdf_mesh_report *report, uint64_t frames, int asked, char *text, size_t size);

/* One line: what is wrong with a frame as it came; "clean" where nothing is. */
const char *enc_name_dirt(const nsdf_mesh_report *report, char *text, size_t size);

/* As a JSON object on one line. */
void enc_put_dirt(nsdf_cli_file *file, const nsdf_mesh_report *report);

#endif
