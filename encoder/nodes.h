/* Points of the moving surface, followed through all frames: what blocks are placed on and moved by. */
#ifndef NSDF_NODES_H
#define NSDF_NODES_H

#include "frames.h"
#include "random.h"
#include "workers.h"

typedef struct nsdf_nodes {
    uint32_t count, frame_count;
    uint32_t placed;         /* of them in the order of farthest points; the others were added later */
    uint32_t rest;           /* frame on which the nodes were placed */
    float (*positions)[3];   /* [frame_count][count], normalised */
    float (*normals)[3];     /* [frame_count][count]: outward */
    uint8_t *support;        /* [frame_count][count]: whether there is surface at the node */
    uint32_t *triangle;      /* [count]: of the surface at rest */
    float (*barycentric)[2]; /* [count]: weights of its second and third corner */
    uint32_t *start, *next;  /* node i's neighbours: next[start[i]] to next[start[i + 1] - 1]; mutual */
    float spacing;           /* about the distance between neighbours at rest */
} nsdf_nodes;

void nsdf_nodes_free(nsdf_nodes *nodes);

/* Places about `count` nodes on frame `rest`, in the order of farthest points: the first k of them are spread evenly
 * for any k.  Frames are oriented and normalised.  Makes the graph; positions are those at rest only.  Returns 0, or -1
 * when memory ran out or the surface has no area. */
int nsdf_nodes_place(nsdf_nodes *nodes, const nsdf_frames *frames, uint32_t rest, uint32_t count, uint64_t seed);

static inline float *nsdf_node_normal(const nsdf_nodes *nodes, uint32_t frame, uint32_t node) {
    return nodes->normals[(size_t)frame * nodes->count + node];
}

static inline float *nsdf_node_at(const nsdf_nodes *nodes, uint32_t frame, uint32_t node) {
    return nodes->positions[(size_t)frame * nodes->count + node];
}

/* Whether all frames have the same triangles, but those that close holes, on as many vertices: vertices then are taken
 * for the same points of the moving surface. */
int nsdf_frames_connected(const nsdf_frames *frames);

/* Moves the nodes with their triangles: for connected frames.  Neighbours that come apart are no neighbours. */
void nsdf_nodes_carry(nsdf_nodes *nodes, const nsdf_frames *frames);

/* nodes_cover.c: finds support: the outside of the frame's surface near the node, with a like normal.  Returns 0, or -1
 * when memory ran out. */
int nsdf_nodes_find_support(nsdf_nodes *nodes, const nsdf_frames *frames, nsdf_workers *workers);

/* Adds nodes where a frame shows surface that has none, as it does after parts have come apart; they move with the
 * nodes around them.  Their support is found, and all have a graph again.  Returns 0, or -1 when memory ran out. */
int nsdf_nodes_cover(nsdf_nodes *nodes, const nsdf_frames *frames, uint64_t seed, nsdf_workers *workers);

/* nodes.c, for nodes_cover.c. */

/* Up to `most` of the candidates in the order of farthest points, ending with the first whose squared distance to those
 * before it is below `least`; *last gets that distance of the last one.  Returns how many. */
uint32_t nsdf_nodes_choose_farthest(float (*candidates)[3], uint32_t count, uint32_t most, float least, float *nearest,
                                    uint32_t *chosen, float *last);
/* The graph of the nodes as they are. */
int nsdf_nodes_build_graph(nsdf_nodes *nodes);
/* Neighbours that come apart on some frame are no neighbours. */
void nsdf_nodes_cut_graph(nsdf_nodes *nodes);

/* The frame to place nodes on: the middle one if connected, else one near the middle that shows much surface. */
uint32_t nsdf_rest_frame(const nsdf_frames *frames, int connected);

#endif
