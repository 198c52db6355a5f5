#include "gltf_read.h"

#include "input_error.h"

nsdf_status nsdf_gltf_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                            nsdf_encoder_error *error) {
    (void)text;
    (void)size;
    nsdf_file_mesh_clear(mesh);
    return nsdf_input_fail(error, NSDF_UNSUPPORTED_FEATURE, "%s: this program was built without glTF",
                           nsdf_show_path(name).text);
}
