#include "gltf_read.h"

#include "input_error.h"

static nsdf_status refuse(const char *name, nsdf_file_mesh *mesh, nsdf_encoder_error *error) {
    nsdf_file_mesh_clear(mesh);
    return nsdf_input_fail(error, NSDF_UNSUPPORTED_FEATURE, "%s: this program was built without glTF",
                           nsdf_show_path(name).text);
}

nsdf_status nsdf_gltf_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                            nsdf_encoder_error *error) {
    (void)text;
    (void)size;
    return refuse(name, mesh, error);
}

nsdf_status nsdf_gltf_film_open(nsdf_gltf_film **film, const char *name, const char *text, size_t size,
                                nsdf_encoder_error *error) {
    (void)name;
    (void)text;
    (void)size;
    (void)error;
    *film = NULL;
    return NSDF_OK;
}

void nsdf_gltf_film_free(nsdf_gltf_film *film) {
    (void)film;
}

nsdf_gltf_film_info nsdf_gltf_film_describe(const nsdf_gltf_film *film) {
    const nsdf_gltf_film_info none = {NULL, 0, 0, 0, ""};
    (void)film;
    return none;
}

nsdf_status nsdf_gltf_film_mesh(const nsdf_gltf_film *film, double seconds, double slack, nsdf_file_mesh *mesh,
                                nsdf_encoder_error *error) {
    (void)film;
    (void)seconds;
    (void)slack;
    return refuse("", mesh, error);
}
