/* Output files that appear only when they are complete, and the signals that must not leave parts of them behind.
 *
 * Every temporary file is in one list until it is renamed or removed.  The third signal removes them in its handler,
 * so the list changes only while signals are blocked, and the handler uses nothing but unlink and _exit. */
#include "cli_util.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BUFFER_SIZE = 1 << 18, MOST_SIGNALS = 3 };

typedef struct temporary {
    char *name, *path; /* owned */
} temporary;

static temporary *temporaries;
static size_t temporary_count, temporary_capacity;
static atomic_int signals_so_far; /* written by the handler, read by any thread */
static const int caught[] = {SIGINT, SIGTERM, SIGHUP};
enum { CAUGHT = sizeof caught / sizeof *caught };

/* ---- Signals ----------------------------------------------------------------------------------------------- */

static void on_signal(int number) {
    const int more = number == SIGINT ? 1 : 2;
    if (atomic_fetch_add(&signals_so_far, more) + more < MOST_SIGNALS)
        return;
    for (size_t i = 0; i < temporary_count; i++)
        unlink(temporaries[i].name);
    _exit(NSDF_CLI_FAILURE);
}

static void caught_set(sigset_t *set) {
    sigemptyset(set);
    for (size_t i = 0; i < CAUGHT; i++)
        sigaddset(set, caught[i]);
}

void nsdf_cli_catch_signals(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    caught_set(&action.sa_mask);
    for (size_t i = 0; i < CAUGHT; i++)
        sigaction(caught[i], &action, NULL);
}

int nsdf_cli_interrupts(void) {
    return atomic_load(&signals_so_far);
}

int nsdf_cli_is_interrupted(void *unused) {
    (void)unused;
    return nsdf_cli_interrupts() > 0;
}

static void block_signals(sigset_t *before) {
    sigset_t set;
    caught_set(&set);
    sigprocmask(SIG_BLOCK, &set, before);
}

static void unblock_signals(const sigset_t *before) {
    sigprocmask(SIG_SETMASK, before, NULL);
}

/* ---- The list of temporary files --------------------------------------------------------------------------- */

static int remember(char *name, char *path) {
    sigset_t before;
    int result = 0;
    block_signals(&before);
    if (temporary_count == temporary_capacity) {
        const size_t capacity = 2 * temporary_capacity + 16;
        temporary *grown = realloc(temporaries, capacity * sizeof *grown);
        if (grown) {
            temporaries = grown;
            temporary_capacity = capacity;
        } else {
            result = -1;
        }
    }
    if (result == 0)
        temporaries[temporary_count++] = (temporary){name, path};
    unblock_signals(&before);
    return result;
}

static void forget_all(void) {
    sigset_t before;
    block_signals(&before);
    for (size_t i = 0; i < temporary_count; i++) {
        free(temporaries[i].name);
        free(temporaries[i].path);
    }
    free(temporaries);
    temporaries = NULL;
    temporary_count = temporary_capacity = 0;
    unblock_signals(&before);
}

void nsdf_cli_abort(void) {
    for (size_t i = 0; i < temporary_count; i++)
        unlink(temporaries[i].name);
    forget_all();
}

int nsdf_cli_commit(void) {
    for (size_t i = 0; i < temporary_count; i++) {
        if (rename(temporaries[i].name, temporaries[i].path) == 0)
            continue;
        nsdf_cli_error("cannot write '%s': %s", temporaries[i].path, strerror(errno));
        for (size_t k = 0; k < i; k++)
            unlink(temporaries[k].path);
        nsdf_cli_abort();
        return -1;
    }
    forget_all();
    return 0;
}

/* ---- Files ------------------------------------------------------------------------------------------------- */

static char *duplicate(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    if (copy)
        strcpy(copy, text);
    return copy;
}

/* "folder/name" -> "folder/.name.tmp-PID" */
static char *temporary_name(const char *path) {
    const char *slash = strrchr(path, '/');
    const int folder = slash ? (int)(slash + 1 - path) : 0;
    const size_t size = strlen(path) + 32;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s.%s.tmp-%ld", folder, path, path + folder, (long)getpid());
    return name;
}

static void release(nsdf_cli_file *file) {
    free(file->path);
    free(file->buffer);
    memset(file, 0, sizeof *file);
    file->descriptor = -1;
}

/* Creates the temporary file and puts it into the list; errno says why not.  The name must be in the list as soon as
 * the file exists. */
static int open_temporary(nsdf_cli_file *file, const char *path) {
    sigset_t before;
    char *name = temporary_name(path), *copy = duplicate(path);
    block_signals(&before);
    file->descriptor = name && copy ? open(name, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666) : -1;
    const int why = name && copy ? errno : ENOMEM;
    int result = file->descriptor < 0 ? -1 : remember(name, copy);
    if (result != 0 && file->descriptor >= 0) {
        unlink(name);
        close(file->descriptor);
    }
    unblock_signals(&before);
    if (result == 0)
        return 0;
    free(name);
    free(copy);
    return errno = file->descriptor < 0 ? why : ENOMEM, -1;
}

int nsdf_cli_is_folder(const char *path) {
    struct stat about;
    return stat(path, &about) == 0 && S_ISDIR(about.st_mode);
}

/* Pipes and devices cannot be replaced by a rename and are written to directly. */
static int open_output(nsdf_cli_file *file, const char *path) {
    struct stat existing;
    if (strcmp(path, "-") == 0) {
        file->descriptor = STDOUT_FILENO;
        return 0;
    }
    if (stat(path, &existing) != 0 || S_ISREG(existing.st_mode))
        return open_temporary(file, path);
    file->descriptor = open(path, O_WRONLY | O_CLOEXEC);
    return file->descriptor < 0 ? -1 : 0;
}

int nsdf_cli_file_open(nsdf_cli_file *file, const char *path) {
    memset(file, 0, sizeof *file);
    file->descriptor = -1;
    file->path = duplicate(path);
    file->buffer = malloc(BUFFER_SIZE);
    if (!file->path || !file->buffer)
        errno = ENOMEM;
    else if (open_output(file, path) == 0)
        return 0;
    nsdf_cli_error("cannot write '%s': %s", path, strerror(errno));
    release(file);
    return -1;
}

void nsdf_cli_file_drop(nsdf_cli_file *file) {
    if (file->descriptor >= 0 && file->descriptor != STDOUT_FILENO)
        close(file->descriptor);
    release(file);
}

static int write_out(nsdf_cli_file *file, const unsigned char *data, size_t size) {
    while (size > 0 && !file->failure) {
        const ssize_t done = write(file->descriptor, data, size);
        if (done < 0 && errno == EINTR && nsdf_cli_interrupts() == 0)
            continue;
        if (done < 0) {
            file->failure = errno;
        } else {
            data += done;
            size -= (size_t)done;
        }
    }
    return file->failure ? -1 : 0;
}

static int flush_buffer(nsdf_cli_file *file) {
    const size_t used = file->used;
    file->used = 0;
    return write_out(file, file->buffer, used);
}

int nsdf_cli_file_write(void *user, const void *data, size_t size) {
    nsdf_cli_file *file = user;
    if (file->failure)
        return -1;
    if (size > BUFFER_SIZE - file->used && flush_buffer(file) != 0)
        return -1;
    if (size > BUFFER_SIZE)
        return write_out(file, data, size);
    memcpy(file->buffer + file->used, data, size);
    file->used += size;
    return 0;
}

int nsdf_cli_file_close(nsdf_cli_file *file) {
    const int is_stdout = file->descriptor == STDOUT_FILENO;
    flush_buffer(file);
    if (!is_stdout && close(file->descriptor) != 0 && !file->failure)
        file->failure = errno;
    const int result = file->failure ? -1 : 0;
    if (file->failure)
        nsdf_cli_error("cannot write '%s': %s", is_stdout ? "standard output" : file->path, strerror(file->failure));
    release(file);
    return result;
}

/* Without this the name, unlike the bytes, might not outlive a loss of power. */
static void sync_folder(const char *path) {
    const char *slash = strrchr(path, '/');
    char *folder = duplicate(path);
    if (folder && slash)
        folder[slash + 1 - path] = '\0';
    const int descriptor = folder ? open(slash ? folder : ".", O_RDONLY | O_CLOEXEC) : -1;
    if (descriptor >= 0) {
        (void)fsync(descriptor);
        close(descriptor);
    }
    free(folder);
}

/* Renames the temporary file that was opened last for `path`, or removes it after a failure, and forgets it.  Returns
 * 0 or an errno.  Signals are blocked: the handler must not remove what has its name by now. */
static int settle_temporary(const char *path, int failure) {
    sigset_t before;
    size_t at = temporary_count;
    block_signals(&before);
    while (at > 0 && strcmp(temporaries[at - 1].path, path) != 0)
        at--;
    if (at > 0) {
        const temporary t = temporaries[at - 1];
        if (!failure && rename(t.name, t.path) != 0)
            failure = errno;
        if (failure)
            unlink(t.name);
        temporaries[at - 1] = temporaries[--temporary_count];
        free(t.name);
        free(t.path);
    }
    unblock_signals(&before);
    return failure;
}

int nsdf_cli_file_publish(nsdf_cli_file *file) {
    flush_buffer(file);
    if (!file->failure && fsync(file->descriptor) != 0)
        file->failure = errno;
    file->failure = settle_temporary(file->path, file->failure);
    if (!file->failure)
        sync_folder(file->path);
    return nsdf_cli_file_close(file);
}

/* ---- Text ----------------------------------------------------------------------------------------------- */

void nsdf_cli_file_print(nsdf_cli_file *file, const char *format, ...) {
    char text[512];
    va_list args;
    va_start(args, format);
    const int n = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (n > 0)
        (void)nsdf_cli_file_write(file, text, (size_t)n < sizeof text ? (size_t)n : sizeof text - 1);
}

void nsdf_cli_file_print_json(nsdf_cli_file *file, const char *text) {
    nsdf_cli_file_print(file, "\"");
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        if (*c == '"' || *c == '\\')
            nsdf_cli_file_print(file, "\\%c", *c);
        else if (*c < 0x20)
            nsdf_cli_file_print(file, "\\u%04x", *c);
        else
            (void)nsdf_cli_file_write(file, c, 1);
    }
    nsdf_cli_file_print(file, "\"");
}
