/* The renderer's programs, GLSL 3.30. */
#ifndef PLAY_SHADERS_H
#define PLAY_SHADERS_H

extern const char play_depth_vertex[], play_depth_fragment[];           /* the mesh as seen by a light */
extern const char play_surface_vertex[], play_surface_fragment[];       /* the mesh */
extern const char play_ground_map_fragment[];                           /* how dark the ground is, as a map of it */
extern const char play_ground_vertex[], play_ground_fragment[];         /* the ground, from that map */
extern const char play_background_vertex[], play_background_fragment[]; /* behind all; its
                                                                           vertices also serve for maps */
extern const char play_overlay_vertex[], play_overlay_fragment[];       /* flat rectangles in pixels */

#endif
