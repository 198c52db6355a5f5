/* make_gltf KIND OUT.glb: writes a small glTF file of make_gltf.h; without arguments it lists the kinds. */
#include "make_gltf.h"

int main(int argc, char **argv) {
    unsigned char *bytes = NULL;
    if (argc != 3) {
        for (size_t i = 0; i < sizeof gltf_kinds / sizeof *gltf_kinds; i++)
            puts(gltf_kinds[i]);
        return argc == 1 ? EXIT_SUCCESS : EXIT_FAILURE;
    }
    const size_t size = gltf_make(argv[1], &bytes);
    FILE *file = size > 0 ? fopen(argv[2], "wb") : NULL;
    const int written = file && fwrite(bytes, 1, size, file) == size;
    const int closed = file && fclose(file) == 0;
    free(bytes);
    if (!written || !closed)
        fprintf(stderr, "make_gltf: cannot write %s to %s\n", argv[1], argv[2]);
    return written && closed ? EXIT_SUCCESS : EXIT_FAILURE;
}
