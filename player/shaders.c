#include "shaders.h"

#define VERSION "#version 330 core\n"

/* ---- Depth ----------------------------------------------------------------------------------------------- */

const char play_depth_vertex[] = VERSION "layout(location = 0) in vec3 position;\n"
                                         "uniform mat4 clip_of_world;\n"
                                         "void main() { gl_Position = clip_of_world * vec4(position, 1.0); }\n";

const char play_depth_fragment[] = VERSION "void main() {}\n";

/* How much of the key light reaches a point, from a grid of nine depths, each of which hardware compares with its four
 * nearest (percentage closer filtering, Reeves et al. 1987).  The map ends behind the box, the ground does not: all of
 * it that is farther from the light lies behind everything. */
#define SHADOW                                                                                                         \
    "uniform sampler2DShadow shadow;\n"                                                                                \
    "uniform mat4 light_of_world;\n"                                                                                   \
    "uniform float shadow_softness;\n"                                                                                 \
    "float lit(vec3 point, float bias) {\n"                                                                            \
    "    vec3 p = (light_of_world * vec4(point, 1.0)).xyz * 0.5 + 0.5;\n"                                              \
    "    if (any(lessThan(p.xy, vec2(0.0))) || any(greaterThan(p.xy, vec2(1.0)))) return 1.0;\n"                       \
    "    p.z = min(p.z, 1.0);\n"                                                                                       \
    "    float sum = 0.0;\n"                                                                                           \
    "    for (int i = -1; i <= 1; i++)\n"                                                                              \
    "        for (int j = -1; j <= 1; j++)\n"                                                                          \
    "            sum += texture(shadow, vec3(p.xy + shadow_softness * vec2(i, j), p.z - bias));\n"                     \
    "    return sum / 9.0;\n"                                                                                          \
    "}\n"

/* ---- The surface ----------------------------------------------------------------------------------------- */

const char play_surface_vertex[] = VERSION "layout(location = 0) in vec3 position;\n"
                                           "layout(location = 1) in vec3 normal;\n"
                                           "layout(location = 2) in float warmth;\n"
                                           "uniform mat4 clip_of_world;\n"
                                           "out vec3 at;\n"
                                           "out vec3 direction;\n"
                                           "out float heat;\n"
                                           "void main() {\n"
                                           "    at = position;\n"
                                           "    direction = normal;\n"
                                           "    heat = warmth;\n"
                                           "    gl_Position = clip_of_world * vec4(position, 1.0);\n"
                                           "}\n";

/* Key light with shadow, fill light from the other side, light from the sky and off the ground, a soft highlight and a
 * rim; in linear colours.  mode: 0 smooth, 1 flat, 2 normals as colours, 3 one colour (lines, ghosts).  Heat is lit
 * less, so that its colours can be read. */
const char play_surface_fragment[] =
    VERSION SHADOW "in vec3 at;\n"
                   "in vec3 direction;\n"
                   "in float heat;\n"
                   "uniform int mode, heated;\n"
                   "uniform vec4 colour;\n"
                   "uniform vec3 ramp[9];\n"
                   "uniform vec3 eye, key, fill, up;\n"
                   "out vec4 pixel;\n"
                   "void main() {\n"
                   "    if (mode == 3) { pixel = vec4(pow(colour.rgb, vec3(1.0 / 2.2)), colour.a); return; }\n"
                   "    vec3 v = normalize(eye - at);\n"
                   "    vec3 n = mode == 1 ? normalize(cross(dFdx(at), dFdy(at))) : normalize(direction) * "
                   "(gl_FrontFacing ? 1.0 : -1.0);\n"
                   "    if (mode == 2) { pixel = vec4(n * 0.5 + 0.5, 1.0); return; }\n"
                   "    float towards = dot(n, key);\n"
                   "    float shine = towards > 0.0 ? towards * lit(at, 0.0015 + 0.004 * (1.0 - towards)) : 0.0;\n"
                   "    float sky = 0.5 + 0.5 * dot(n, up);\n"
                   "    vec3 light = shine * vec3(1.02, 0.98, 0.92) + max(dot(n, fill), 0.0) * vec3(0.16, 0.18, 0.22)\n"
                   "               + mix(vec3(0.10, 0.09, 0.08), vec3(0.22, 0.24, 0.28), sky);\n"
                   "    vec3 h = normalize(key + v);\n"
                   "    float gloss = 0.10 * pow(max(dot(n, h), 0.0), 40.0) * step(0.0001, shine);\n"
                   "    float rim = 0.10 * pow(1.0 - max(dot(n, v), 0.0), 4.0) * sky;\n"
                   "    vec3 c = colour.rgb * light + gloss + rim;\n"
                   "    if (heated != 0) {\n"
                   "        float step = clamp(heat, 0.0, 1.0) * 8.0;\n"
                   "        int low = min(int(step), 7);\n"
                   "        vec3 hue = pow(mix(ramp[low], ramp[low + 1], step - float(low)), vec3(2.2));\n"
                   "        c = hue * mix(light, vec3(1.0), 0.5);\n"
                   "    }\n"
                   "    pixel = vec4(pow(min(c, vec3(1.0)), vec3(1.0 / 2.2)), colour.a);\n"
                   "}\n";

/* ---- The ground ------------------------------------------------------------------------------------------ */

/* Shadow, and darkening where the surface is near above: heights come from the depths of a view from below.  Drawn to a
 * map of the ground, since it takes many readings for each point. */
const char play_ground_map_fragment[] =
    VERSION SHADOW "in vec2 at;\n"
                   "uniform sampler2D below;\n"
                   "uniform vec3 corner, along, across;\n"
                   "uniform float reach_below;\n"
                   "out vec4 dark;\n"
                   "float contact(vec2 p) {\n"
                   "    float sum = 0.0, weights = 0.0;\n"
                   "    for (int i = -2; i <= 2; i++)\n"
                   "        for (int j = -2; j <= 2; j++) {\n"
                   "            float w = exp(-0.25 * float(i * i + j * j));\n"
                   "            float h = 2.0 * texture(below, p + vec2(i, j) / 80.0).r;\n"
                   "            sum += w * exp(-h * 14.0);\n"
                   "            weights += w;\n"
                   "        }\n"
                   "    return sum / weights;\n"
                   "}\n"
                   "void main() {\n"
                   "    vec3 point = corner + at.x * along + at.y * across;\n"
                   "    float shade = 0.34 * (1.0 - lit(point, 0.001));\n"
                   "    float near = 0.5 * contact(0.5 + (at - 0.5) * reach_below);\n"
                   "    dark = vec4(1.0 - (1.0 - shade) * (1.0 - near));\n"
                   "}\n";

const char play_ground_vertex[] = VERSION "layout(location = 0) in vec3 position;\n"
                                          "uniform mat4 clip_of_world;\n"
                                          "out vec2 place;\n"
                                          "void main() {\n"
                                          "    place = vec2(gl_VertexID & 1, gl_VertexID >> 1);\n"
                                          "    gl_Position = clip_of_world * vec4(position, 1.0);\n"
                                          "}\n";

/* What is not dark is not drawn, so that the ground has no edge. */
const char play_ground_fragment[] = VERSION "in vec2 place;\n"
                                            "uniform sampler2D map;\n"
                                            "out vec4 pixel;\n"
                                            "void main() {\n"
                                            "    float fade = 1.0 - smoothstep(0.55, 1.0, length(place * 2.0 - 1.0));\n"
                                            "    pixel = vec4(0.10, 0.11, 0.13, fade * texture(map, place).r);\n"
                                            "}\n";

/* ---- Background ------------------------------------------------------------------------------------------ */

const char play_background_vertex[] = VERSION "out vec2 at;\n"
                                              "void main() {\n"
                                              "    at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n"
                                              "    gl_Position = vec4(at * 2.0 - 1.0, 1.0, 1.0);\n"
                                              "}\n";

const char play_background_fragment[] = VERSION "in vec2 at;\n"
                                                "uniform vec4 colour, top;\n"
                                                "out vec4 pixel;\n"
                                                "void main() { pixel = mix(colour, top, clamp(at.y, 0.0, 1.0)); }\n";

/* ---- Overlay --------------------------------------------------------------------------------------------- */

const char play_overlay_vertex[] = VERSION "layout(location = 0) in vec2 position;\n"
                                           "layout(location = 1) in vec4 paint;\n"
                                           "uniform vec2 size;\n"
                                           "out vec4 tint;\n"
                                           "void main() {\n"
                                           "    tint = paint;\n"
                                           "    vec2 p = position / size * 2.0 - 1.0;\n"
                                           "    gl_Position = vec4(p.x, -p.y, 0.0, 1.0);\n"
                                           "}\n";

const char play_overlay_fragment[] = VERSION "in vec4 tint;\n"
                                             "out vec4 pixel;\n"
                                             "void main() { pixel = tint; }\n";
