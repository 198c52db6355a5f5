/* Feeds files to a fuzz target, each from a heap block of exactly its size: seeds, and inputs that once were findings.
 * usage: fuzz_replay_NAME FILE_OR_FOLDER... */
#include "fuzz_target.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>

static int replay_file(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END))
        return -1;
    const long size = ftell(file);
    uint8_t *data = size >= 0 ? malloc(size ? (size_t)size : 1) : NULL;
    rewind(file);
    const int failed = !data || fread(data, 1, (size_t)size, file) != (size_t)size;
    fclose(file);
    if (!failed)
        LLVMFuzzerTestOneInput(data, (size_t)size);
    free(data);
    return failed ? -1 : 0;
}

/* Files replayed; -1 when one cannot be read. */
static long replay(const char *path) {
    DIR *folder = opendir(path);
    long count = 0;
    if (!folder)
        return replay_file(path) ? -1 : 1;
    for (const struct dirent *entry; count >= 0 && (entry = readdir(folder));) {
        char name[1024];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        count = replay_file(name) ? -1 : count + 1;
    }
    closedir(folder);
    return count;
}

int main(int argc, char **argv) {
    long total = 0;
    for (int i = 1; i < argc; i++) {
        const long count = replay(argv[i]);
        if (count < 0) {
            fprintf(stderr, "fuzz_replay: %s: cannot be read\n", argv[i]);
            return EXIT_FAILURE;
        }
        total += count;
    }
    printf("%ld inputs replayed\n", total);
    return total > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
