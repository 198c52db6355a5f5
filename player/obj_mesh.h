/* Triangle meshes from the text of OBJ files: positions and faces, all else is skipped. */
#ifndef PLAY_OBJ_MESH_H
#define PLAY_OBJ_MESH_H

#include <stddef.h>

#include "nsdf/decoder.h"

typedef struct play_obj_mesh {
    float *positions, *normals; /* [vertex_count][3]; normals are means of the faces around, by area */
    uint32_t *indices;          /* [triangle_count][3] */
    size_t vertex_count, triangle_count;
    size_t position_capacity, index_capacity; /* numbers, not triples */
} play_obj_mesh;

/* Parses text that ends with '\0', using the storage of *mesh again; polygons are cut into fans.  NULL, or what is
 * wrong, with its line in *line, from 1 on. */
const char *play_obj_parse(play_obj_mesh *mesh, const char *text, unsigned long *line);
void play_obj_free(play_obj_mesh *mesh);

/* Valid until the next call on the mesh. */
nsdf_mesh_view play_obj_view(const play_obj_mesh *mesh);

#endif
