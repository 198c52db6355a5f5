/* What a program decodes: a file, or a URL. */
#ifndef NSDF_CLI_INPUT_H
#define NSDF_CLI_INPUT_H

#include "nsdf/decoder.h"

enum { NSDF_CLI_TIMEOUT = 20 }; /* seconds, the default */

typedef struct nsdf_cli_input nsdf_cli_input;

/* Opens a file or a URL.  `timeout` in seconds, for URLs.  NULL after a failure, with *error saying why. */
nsdf_cli_input *nsdf_cli_input_open(const char *name, uint32_t timeout, nsdf_error *error);
/* A decoder of it; there may be several, and they must be closed before the input. */
nsdf_status nsdf_cli_input_decoder(nsdf_cli_input *input, nsdf_decoder **decoder, const nsdf_decoder_options *options,
                                   nsdf_error *error);
/* Puts the network's reason into an error of reading. */
void nsdf_cli_input_explain(nsdf_cli_input *input, nsdf_error *error);
const char *nsdf_cli_input_name(const nsdf_cli_input *input);
/* Whether it is a URL, of which programs read no more than they need. */
int nsdf_cli_input_is_remote(const nsdf_cli_input *input);
/* Lets a read that waits for the network fail; from any thread. */
void nsdf_cli_input_cancel(nsdf_cli_input *input);
/* Seconds that reads have waited for the network so far. */
double nsdf_cli_input_waited(nsdf_cli_input *input);
/* Says that these bytes will be read in `seconds`: they are fetched ahead, without waiting, if there is not much more
 * time than the network needs for them. */
void nsdf_cli_input_ahead(nsdf_cli_input *input, uint64_t offset, uint64_t size, double seconds);
/* Prints what was transferred, if it is a URL: at verbosity `level` and above. */
void nsdf_cli_input_report(nsdf_cli_input *input, int level);
/* NULL-safe. */
void nsdf_cli_input_close(nsdf_cli_input *input);

#endif
