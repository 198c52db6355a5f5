/* A walking figure of blended capsules.  The feet lead: an ankle rolls over heel, sole and ball while it moves back
 * with the ground, then swings forward; knees follow by inverse kinematics.  One turn of the phase is one stride (two
 * steps); the left heel strikes at phase 0, the right one at 0.5. */
#include "shapes.h"

#include <math.h>
#include <string.h>

static const double tau = 6.283185307179586;

typedef struct vec {
    double x, y, z;
} vec;

static const double thigh = 0.44, shin = 0.43; /* lengths of the bones */
static const double ground_speed = 0.90;       /* of the feet on the ground, metres per stride */
static const double strike = 0.25;             /* how far ahead of the hips the heel strikes */
static const double toe_off = 0.62;            /* phase at which a foot leaves the ground */
static const vec ankle_rest = {0, 0.085, 0};   /* of a foot flat on the ground, from the point below the ankle */
static const vec heel_rest = {0, 0.038, -0.050};
static const vec ball_rest = {0, 0.034, 0.120};
static const vec toe_rest = {0, 0.030, 0.185};

static vec add(vec a, vec b) {
    return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}

static vec sub(vec a, vec b) {
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static vec mix(vec a, vec b, double t) {
    return (vec){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z)};
}

/* Turns about the x axis: positive angles lift what lies ahead (+z). */
static vec pitch(vec v, double angle) {
    double c = cos(angle), s = sin(angle);
    return (vec){v.x, c * v.y + s * v.z, c * v.z - s * v.y};
}

/* Turns about the y axis: positive angles bring the left side (+x) back. */
static vec yaw(vec v, double angle) {
    double c = cos(angle), s = sin(angle);
    return (vec){c * v.x + s * v.z, v.y, c * v.z - s * v.x};
}

static double fraction(double phase) {
    return phase - floor(phase);
}

/* Angle at a phase by smoothstep between keys {phase, degrees}; the first key is at 0, the last at 1. */
static double key_angle(const double (*keys)[2], double phase) {
    int i = 0;
    while (phase > keys[i + 1][0])
        i++;
    double t = (phase - keys[i][0]) / (keys[i + 1][0] - keys[i][0]);
    double degrees = keys[i][1] + (keys[i + 1][1] - keys[i][1]) * t * t * (3 - 2 * t);
    return degrees * tau / 360;
}

static double foot_pitch(double phase) {
    static const double keys[][2] = {{0, 16}, {0.10, 0}, {0.34, 0}, {0.62, -52}, {0.82, -4}, {0.94, 20}, {1, 16}};
    return key_angle(keys, phase);
}

/* The ankle of a foot on the ground: the sole turns about the heel or the ball, whichever touches. */
static vec stance_ankle(double phase) {
    double angle = foot_pitch(phase);
    vec pivot = angle > 0 ? heel_rest : ball_rest;
    vec ground = {0, 0, strike - ground_speed * phase};
    return add(ground, add(pivot, pitch(sub(ankle_rest, pivot), angle)));
}

/* The ankle through the air: a cubic that leaves and meets the ground's motion at both ends, plus a lift. */
static vec swing_ankle(double phase) {
    const double step = 1e-3, span = 1 - toe_off;
    double t = (phase - toe_off) / span;
    vec from = stance_ankle(toe_off), to = stance_ankle(0);
    vec leave = sub(from, stance_ankle(toe_off - step)), meet = sub(stance_ankle(step), to);
    double scale = span / step;
    double h01 = t * t * (3 - 2 * t), h10 = t * (1 - t) * (1 - t) * scale, h11 = -t * t * (1 - t) * scale;
    vec p = mix(from, to, h01);
    p.y += h10 * leave.y + h11 * meet.y + 0.35 * t * t * (1 - t) * (1 - t);
    p.z += h10 * leave.z + h11 * meet.z;
    return p;
}

/* The middle joint of two bones between `root` and *end, bent towards +z (sign > 0) or -z.  Moves *end within reach. */
static vec bend_joint(vec root, vec *end, double upper, double lower, double sign) {
    vec d = sub(*end, root);
    double length = sqrt(d.x * d.x + d.y * d.y + d.z * d.z), most = 0.998 * (upper + lower);
    if (length > most) {
        *end = mix(root, *end, most / length);
        d = sub(*end, root);
        length = most;
    }
    double along = (upper * upper - lower * lower + length * length) / (2 * length);
    double out = sqrt(fmax(upper * upper - along * along, 0));
    double flat = sqrt(d.y * d.y + d.z * d.z);
    vec side = {0, sign * d.z / flat, -sign * d.y / flat}; /* at right angles to d, in the plane of walking */
    vec joint = mix(root, *end, along / length);
    return (vec){joint.x, joint.y + out * side.y, joint.z + out * side.z};
}

static void add_part(nsdf_shape_pose *pose, vec a, vec b, double radius_a, double radius_b, double blend) {
    nsdf_shape_part *part = &pose->parts[pose->part_count++];
    *part = (nsdf_shape_part){{a.x, a.y, a.z}, {b.x, b.y, b.z}, radius_a, radius_b, blend};
}

static void add_leg(nsdf_shape_pose *pose, double phase, vec hip) {
    double angle = foot_pitch(phase);
    vec ankle = phase < toe_off ? stance_ankle(phase) : swing_ankle(phase);
    ankle.x = 0.8 * hip.x;
    vec knee = bend_joint(hip, &ankle, thigh, shin, 1);
    vec heel = add(ankle, pitch(sub(heel_rest, ankle_rest), angle));
    vec ball = add(ankle, pitch(sub(ball_rest, ankle_rest), angle));
    double toe_pitch = phase < toe_off ? fmax(angle, 0) : angle * fmin(1, (phase - toe_off) / 0.12);
    vec toe = add(ball, pitch(sub(toe_rest, ball_rest), toe_pitch));
    vec calf = mix(knee, ankle, 0.30);
    calf.z -= 0.022;
    vec outside = {hip.x > 0 ? 0.012 : -0.012, 0, 0};
    add_part(pose, hip, knee, 0.088, 0.055, 0.06);
    add_part(pose, knee, ankle, 0.052, 0.036, 0.02);
    add_part(pose, calf, mix(knee, ankle, 0.55), 0.042, 0.030, 0.05);
    add_part(pose, heel, ankle, 0.036, 0.034, 0.03);
    add_part(pose, heel, add(ball, outside), 0.034, 0.034, 0.03);
    add_part(pose, add(ankle, (vec){0, -0.01, 0.01}), ball, 0.034, 0.032, 0.04);
    add_part(pose, add(ball, outside), toe, 0.034, 0.026, 0.02);
}

static void add_arm(nsdf_shape_pose *pose, double phase, vec shoulder) {
    double swing = -0.42 * cos(tau * phase) - 0.03, elbow_bend = 0.42 - 0.24 * cos(tau * phase + 0.4);
    double out = shoulder.x > 0 ? 1 : -1;
    vec elbow = add(shoulder, pitch((vec){out * 0.065, -0.275, 0}, swing));
    vec wrist = add(elbow, pitch((vec){out * 0.010, -0.245, 0}, swing + elbow_bend));
    vec knuckles = add(wrist, pitch((vec){out * -0.008, -0.080, 0.004}, swing + elbow_bend + 0.1));
    vec fingers = add(knuckles, pitch((vec){out * -0.012, -0.060, 0.010}, swing + elbow_bend + 0.45));
    vec thumb = add(wrist, pitch((vec){out * -0.020, -0.075, 0.042}, swing + elbow_bend));
    add_part(pose, shoulder, elbow, 0.056, 0.040, 0.05);
    add_part(pose, elbow, wrist, 0.041, 0.028, 0.02);
    add_part(pose, wrist, knuckles, 0.026, 0.034, 0.02);
    add_part(pose, knuckles, fingers, 0.032, 0.022, 0.02);
    add_part(pose, wrist, thumb, 0.020, 0.015, 0.015);
}

/* Pelvis to head.  The shoulders turn against the hips; the head stays level. */
static void add_trunk(nsdf_shape_pose *pose, vec pelvis, double hip_yaw, double shoulder_yaw, vec *chest) {
    vec hip = yaw((vec){0.066, 0.03, -0.005}, hip_yaw), side = yaw((vec){0.090, 0, 0}, shoulder_yaw);
    vec waist = add(pelvis, (vec){0, 0.19, 0.014}), ribs = add(pelvis, (vec){-0.3 * pelvis.x, 0.36, 0.022});
    *chest = add(pelvis, (vec){-0.5 * pelvis.x, 0.465, 0.026});
    vec neck = add(*chest, (vec){-0.2 * pelvis.x, 0.100, 0.004}), skull = add(neck, (vec){0, 0.165, 0.030});
    vec minus_hip = {-hip.x, hip.y, -hip.z - 0.01};
    add_part(pose, add(pelvis, hip), add(pelvis, minus_hip), 0.105, 0.105, 0);
    add_part(pose, pelvis, waist, 0.115, 0.120, 0.10);
    add_part(pose, add(ribs, side), sub(ribs, side), 0.100, 0.100, 0.14);
    add_part(pose, add(*chest, side), sub(*chest, side), 0.088, 0.088, 0.10);
    add_part(pose, neck, skull, 0.050, 0.050, 0.05);
    add_part(pose, add(skull, (vec){0, 0.035, -0.020}), add(skull, (vec){0, -0.015, 0.012}), 0.094, 0.082, 0.03);
    add_part(pose, add(skull, (vec){0, -0.065, 0.030}), add(skull, (vec){0, -0.040, 0.050}), 0.048, 0.048, 0.05);
    add_part(pose, add(skull, (vec){0, -0.020, 0.090}), add(skull, (vec){0, 0.010, 0.080}), 0.016, 0.010, 0.02);
}

void nsdf_walker_pose(double seconds, nsdf_shape_pose *pose) {
    double phase = fraction(seconds), half = fraction(seconds + 0.5);
    double hip_yaw = -0.10 * cos(tau * phase), shoulder_yaw = 0.16 * cos(tau * phase);
    vec pelvis = {0.018 * cos(tau * (phase - 0.3)), 0.936 + 0.014 * cos(2 * tau * (phase - 0.3)), 0}, chest;
    memset(pose, 0, sizeof *pose);
    add_trunk(pose, pelvis, hip_yaw, shoulder_yaw, &chest);
    vec hip = yaw((vec){0.095, -0.01, 0}, hip_yaw), shoulder = yaw((vec){0.185, 0.015, -0.01}, shoulder_yaw);
    add_leg(pose, phase, add(pelvis, hip));
    add_leg(pose, half, add(pelvis, (vec){-hip.x, hip.y, -hip.z}));
    add_arm(pose, phase, add(chest, shoulder));
    add_arm(pose, half, add(chest, (vec){-shoulder.x, shoulder.y, -shoulder.z}));
}
