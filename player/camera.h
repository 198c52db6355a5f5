/* Where the viewer is: on a sphere around a target.  Knows nothing of OpenGL. */
#ifndef PLAY_CAMERA_H
#define PLAY_CAMERA_H

#include "matrix.h"

typedef struct play_box {
    double low[3], high[3];
} play_box;

/* Which way is up in a file: +x, -x, +y, ... */
typedef enum play_up {
    PLAY_UP_X,
    PLAY_UP_Y,
    PLAY_UP_Z,
    PLAY_UP_NEGATIVE_X,
    PLAY_UP_NEGATIVE_Y,
    PLAY_UP_NEGATIVE_Z
} play_up;

typedef struct play_camera {
    play_up up;
    double azimuth, elevation; /* degrees; at 0 and 0, up being y, the viewer is in front: z grows towards him */
    double zoom;               /* 1 = the box just fits */
    double angle;              /* of view, across the shorter side; degrees */
    play_vec3 target;
    double distance; /* at zoom 1 */
    double reach;    /* radius of a sphere around the box's middle that holds it and its shadow */
    play_vec3 middle;
} play_camera;

/* What a camera sees; axes are unit vectors of the world. */
typedef struct play_eye {
    play_vec3 position, right, up, back;
    double tangent_x, tangent_y, near, far;
    play_mat4 clip_of_world;
} play_eye;

/* The axes at azimuth 0: right, up, towards the viewer. */
void play_up_axes(play_up up, play_vec3 axes[3]);
/* "y", "+y", "-z", ...: 0, or -1. */
int play_up_parse(const char *text, play_up *up);

/* A camera at azimuth 25, elevation 12 that shows the whole box at this shape of picture (width / height). */
play_camera play_camera_make(const play_box *box, play_up up, double aspect);
/* Moves target and distance so that the box just fits, from where the viewer is; zoom becomes 1. */
void play_camera_fit(play_camera *camera, const play_box *box, double aspect);

/* By angles in degrees; the elevation stays within +-89. */
void play_camera_orbit(play_camera *camera, double azimuth, double elevation);
/* By parts of the picture's shorter side. */
void play_camera_pan(play_camera *camera, double right, double up);
/* The zoom stays within 0.05 to 50. */
void play_camera_zoom(play_camera *camera, double factor);

play_eye play_camera_eye(const play_camera *camera, double aspect);

/* Towards the key light, which stands at the viewer's left, above him and in front: a unit vector. */
play_vec3 play_key_light(const play_eye *eye, play_vec3 up);

/* Where a point of the world is in a picture: x to the right, y down, both from 0 to 1 within it. */
void play_eye_project(const play_eye *eye, const double point[3], double *x, double *y);

#endif
