/* What the command-line programs share: messages, numbers, progress, signals, and output files that appear only when
 * they are complete.  Exit codes: 0 success, 1 failure, 2 wrong usage. */
#ifndef NSDF_CLI_UTIL_H
#define NSDF_CLI_UTIL_H

#include <stddef.h>
#include <stdint.h>

#include "nsdf/decoder.h"

enum { NSDF_CLI_SUCCESS = 0, NSDF_CLI_FAILURE = 1, NSDF_CLI_USAGE = 2 };

#if defined(__GNUC__)
#define NSDF_CLI_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define NSDF_CLI_PRINTF(text, first)
#endif

/* ---- Messages: always to stderr, each line prefixed with the program's name ------------------------------- */

/* Call first in main; the name is borrowed. */
void nsdf_cli_begin(const char *program);
/* -1 = quiet (errors only), 0 = normal, 1 and above = verbose. */
void nsdf_cli_set_verbosity(int level);
int nsdf_cli_verbosity(void);

void nsdf_cli_error(const char *format, ...) NSDF_CLI_PRINTF(1, 2);   /* always */
void nsdf_cli_warn(const char *format, ...) NSDF_CLI_PRINTF(1, 2);    /* unless quiet; "warning: " in front */
void nsdf_cli_say(const char *format, ...) NSDF_CLI_PRINTF(1, 2);     /* unless quiet */
void nsdf_cli_verbose(const char *format, ...) NSDF_CLI_PRINTF(1, 2); /* with -v */
/* Prints the error with "(try --help)" behind it and returns NSDF_CLI_USAGE. */
int nsdf_cli_usage_error(const char *format, ...) NSDF_CLI_PRINTF(1, 2);
/* "FILE: message in chunk SEGM at byte 812 (status)"; parts that the error does not have, or that would say nothing
 * new, are left out. */
void nsdf_cli_nsdf_error(const char *file, const nsdf_error *error);

/* Fills *error with what a call on the handle that answered `status` left there. */
void nsdf_cli_get_error(const nsdf_decoder *decoder, nsdf_status status, nsdf_error *error);

/* A line that overwrites itself; shown on a terminal only, and not when quiet.  The other functions here end it. */
void nsdf_cli_progress(const char *format, ...) NSDF_CLI_PRINTF(1, 2);

/* ---- Numbers: the whole text must be the number.  0, or -1 with *out untouched ----------------------------- */

int nsdf_cli_parse_u32(const char *text, uint32_t min, uint32_t max, uint32_t *out);
int nsdf_cli_parse_u64(const char *text, uint64_t *out);
int nsdf_cli_parse_double(const char *text, double *out); /* finite */
/* Bytes, with an optional suffix k, M or G (1024, 1024^2, 1024^3). */
int nsdf_cli_parse_bytes(const char *text, uint64_t *out);
/* "30", "29.97" or "60000/1001", positive, as an exact fraction in lowest terms. */
int nsdf_cli_parse_rational(const char *text, uint32_t *num, uint32_t *den);

/* ---- Time ---------------------------------------------------------------------------------------------------- */

/* Seconds of a clock that only goes forward. */
double nsdf_cli_clock(void);

/* ---- Signals ----------------------------------------------------------------------------------------------- */

/* From here on SIGINT, SIGTERM and SIGHUP are counted instead of ending the program.  At the third the handler
 * removes the temporary files and ends it with exit code 1. */
void nsdf_cli_catch_signals(void);
/* Interrupts so far; SIGTERM and SIGHUP count as two, so that `>= 1` means "finish early" and `>= 2` "give up". */
int nsdf_cli_interrupts(void);
/* Whether there was any, as a cancel callback of the decoder. */
int nsdf_cli_is_interrupted(void *unused);

/* ---- Output files: written under a temporary name in the same folder, renamed when all is well --------------- */

typedef struct nsdf_cli_file {
    int descriptor; /* -1 when closed */
    int failure;    /* errno of the first failure, 0 if none */
    char *path;     /* owned */
    size_t used;    /* bytes in the buffer */
    unsigned char *buffer;
} nsdf_cli_file;

/* Opens a temporary file for `path`; "-" writes to stdout, a pipe or a device is written to directly.  0, or -1 after
 * printing why. */
int nsdf_cli_file_open(nsdf_cli_file *file, const char *path);
/* A nsdf_write_fn: user is the nsdf_cli_file.  0, or -1; the cause is kept for nsdf_cli_file_close. */
int nsdf_cli_file_write(void *user, const void *data, size_t size);
/* The same for text, up to 511 bytes at a time; and for a JSON string in quotes. */
void nsdf_cli_file_print(nsdf_cli_file *file, const char *format, ...) NSDF_CLI_PRINTF(2, 3);
void nsdf_cli_file_print_json(nsdf_cli_file *file, const char *text);
/* Writes what is buffered and closes; the file keeps its temporary name until nsdf_cli_commit.  0, or -1 after
 * printing the first failure since opening. */
int nsdf_cli_file_close(nsdf_cli_file *file);
/* As nsdf_cli_file_close, but what was written is on the disk and has its name at once: until then the file that was
 * there before stays.  0, or -1 after printing why, with the temporary file removed. */
int nsdf_cli_file_publish(nsdf_cli_file *file);
/* Closes without writing what is buffered, silently; harmless when closed.  nsdf_cli_abort removes the file. */
void nsdf_cli_file_drop(nsdf_cli_file *file);

/* Whether the path leads to a folder. */
int nsdf_cli_is_folder(const char *path);

/* Renames all closed files to their names.  0, or -1 after printing why, with none of them left. */
int nsdf_cli_commit(void);
/* Removes all temporary files; harmless when there are none. */
void nsdf_cli_abort(void);

#endif
