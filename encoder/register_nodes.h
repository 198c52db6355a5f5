/* Following nodes without correspondences: each frame's surface is all that is known. */
#ifndef NSDF_REGISTER_NODES_H
#define NSDF_REGISTER_NODES_H

#include "nodes.h"

/* Non-rigid registration from the frame at rest forwards and backwards, each frame from the one before: nodes go to the
 * nearest points of like normal (point to plane), and points of the frame pull their nearest nodes, while neighbours
 * stay as rigid as possible to each other (Sorkine & Alexa 2007).  Returns 0, or -1 when memory ran out. */
int nsdf_nodes_register(nsdf_nodes *nodes, const nsdf_frames *frames, uint64_t seed, nsdf_workers *workers);

#endif
