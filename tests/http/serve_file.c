/* Serves one file for the tests of commands.
 * usage: http_server FILE MODE [LIMIT]
 * Prints the port, serves until standard input ends, and prints "REQUESTS BYTES". */
#include <stdio.h>
#include <stdlib.h>

#include "http_server.h"

static void *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    char *data = NULL;
    *size = 0;
    if (!file)
        return NULL;
    for (size_t capacity = 1 << 16;; capacity *= 2) {
        char *grown = realloc(data, capacity);
        if (!grown)
            break;
        data = grown;
        *size += fread(data + *size, 1, capacity - *size, file);
        if (*size < capacity)
            break;
    }
    fclose(file);
    return data;
}

int main(int argc, char **argv) {
    size_t size;
    const int mode = argc > 2 ? http_mode_by_name(argv[2]) : -1;
    void *data = mode >= 0 ? read_file(argv[1], &size) : NULL;
    http_server *server =
        data ? http_server_start(data, size, (http_mode)mode, argc > 3 ? strtoull(argv[3], NULL, 10) : 0) : NULL;
    if (!server) {
        fprintf(stderr, "usage: http_server FILE MODE [LIMIT]\n");
        return 2;
    }
    printf("%u\n", http_server_port(server));
    fflush(stdout);
    while (getchar() != EOF)
        ;
    const http_log log = http_server_stop(server);
    printf("%lu %llu\n", (unsigned long)log.requests, (unsigned long long)log.bytes);
    free(data);
    return 0;
}
