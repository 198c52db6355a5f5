/* Sources: one callback interface for all; files by pread, so that reads need no seek and no buffer. */
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif
#ifndef _FILE_OFFSET_BITS
#define _FILE_OFFSET_BITS 64
#endif
#include "source.h"
#include "status.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Some systems refuse to read 2 GiB or more at once. */
enum { MAX_READ = 1 << 30 };

void nsdf_source_memory(nsdf_source *source, const void *data, size_t size) {
    memset(source, 0, sizeof *source);
    source->memory = data;
    source->io.size = size;
}

void nsdf_source_callbacks(nsdf_source *source, const nsdf_io *io) {
    memset(source, 0, sizeof *source);
    source->io = *io;
}

static int descriptor_of(const void *user) {
    return (int)(intptr_t)user;
}

static int file_read_at(void *user, uint64_t offset, void *dst, size_t size) {
    char *out = dst;
    while (size > 0) {
        size_t part = size < (size_t)MAX_READ ? size : (size_t)MAX_READ;
        ssize_t got = pread(descriptor_of(user), out, part, (off_t)offset);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return -1;
        out += got;
        offset += (uint64_t)got;
        size -= (size_t)got;
    }
    return 0;
}

static void file_close(void *user) {
    close(descriptor_of(user));
}

/* Not strerror: its texts follow the locale. */
static nsdf_status fail_system(nsdf_error *error, const char *what, int code) {
    const char *reason = code == ENOENT                      ? "no such file"
                         : code == EACCES || code == EPERM   ? "permission denied"
                         : code == EMFILE || code == ENFILE  ? "too many open files"
                         : code == ENAMETOOLONG              ? "the name is too long"
                         : code == ENOTDIR || code == EISDIR ? "a folder is a file, or the other way round"
                                                             : "system error";
    return nsdf_fail(error, NSDF_IO, 0, 0, "%s: %s (%d)", what, reason, code);
}

nsdf_status nsdf_source_file(nsdf_source *source, const char *path, nsdf_error *error) {
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
        return fail_system(error, "the file cannot be opened", errno);
    struct stat about;
    if (fstat(descriptor, &about) != 0) {
        int code = errno;
        close(descriptor);
        return fail_system(error, "the file's size cannot be read", code);
    }
    if (!S_ISREG(about.st_mode)) {
        close(descriptor);
        return nsdf_fail(error, NSDF_IO, 0, 0, "not a regular file: only those can be read at any place");
    }
    memset(source, 0, sizeof *source);
    source->io.user = (void *)(intptr_t)descriptor;
    source->io.read_at = file_read_at;
    source->io.size = (uint64_t)about.st_size;
    source->close = file_close;
    return NSDF_OK;
}

void nsdf_source_close(nsdf_source *source) {
    if (source->close)
        source->close(source->io.user);
    memset(source, 0, sizeof *source);
}

nsdf_status nsdf_source_read(const nsdf_source *source, uint64_t offset, void *dst, size_t size, nsdf_error *error) {
    if (offset > source->io.size || size > source->io.size - offset)
        return nsdf_fail(error, NSDF_TRUNCATED, 0, source->io.size, "the file ends at byte %llu, expected %llu bytes",
                         (unsigned long long)source->io.size, (unsigned long long)(offset + size));
    if (size == 0)
        return NSDF_OK;
    if (source->memory) {
        memcpy(dst, source->memory + offset, size);
        return NSDF_OK;
    }
    if (source->io.read_at(source->io.user, offset, dst, size) != 0)
        return nsdf_fail(error, NSDF_IO, 0, offset, "reading %llu bytes at byte %llu failed", (unsigned long long)size,
                         (unsigned long long)offset);
    return NSDF_OK;
}
