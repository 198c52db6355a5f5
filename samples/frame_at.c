/* Opens an .nsdf file and extracts the surface half a second after its start.
 * Build: cc frame_at.c $(pkg-config --cflags --libs nsdf) -o frame_at */
#include <nsdf/decoder.h>

#include <stdio.h>

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: frame_at FILE.nsdf\n");
        return 2;
    }
    nsdf_decoder *decoder = NULL;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_view view;
    nsdf_error error;
    if (nsdf_open_file(&decoder, argv[1], NULL, &error) != NSDF_OK) {
        fprintf(stderr, "frame_at: %s: %s\n", argv[1], error.message);
        return 1;
    }
    nsdf_status status = nsdf_extract_mesh(decoder, 0.5, NULL, &mesh);
    if (status == NSDF_OK)
        status = nsdf_mesh_get_view(mesh, &view);
    if (status == NSDF_OK)
        printf("%u vertices, %u triangles\n", view.vertex_count, view.triangle_count);
    else
        fprintf(stderr, "frame_at: %s\n", nsdf_status_string(status));
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    return status == NSDF_OK ? 0 : 1;
}
