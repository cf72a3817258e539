"""The GLSL of the `egl` backend.

Colours are multiplied as they are stored, sRGB-encoded. For a pure power curve that equals the
product in linear light, and sRGB is close to one, so no conversion is paid for; a light factor L
is linear and enters as L^(1/2.2). Only averages (texture filter, antialiasing) are of encoded
values, as in any renderer without an sRGB framebuffer.

Scenes are not lit: their light is baked into their colours. The alpha of every pixel is the
instance id / 255.
"""

from __future__ import annotations

from affectsim_data.render.lighting import (
    AMBIENT_HIGH,
    AMBIENT_LOW,
    GAMMA,
    KEY_STRENGTH,
    KEY_WRAP,
    OUTLINE,
)

__all__ = ["BODY", "RESOLVE", "SCENE", "SHADOW", "TEXTURED_SCENE"]

_SCENE_VERTEX = """
#version 330
uniform mat4 clip_from_world;
in vec3 position;
in vec4 color;
out vec3 vertex_color;
void main() {
    gl_Position = clip_from_world * vec4(position, 1.0);
    vertex_color = color.rgb;
}
"""

_SCENE_FRAGMENT = """
#version 330
in vec3 vertex_color;
out vec4 pixel;
void main() { pixel = vec4(vertex_color, 0.0); }
"""

_TEXTURED_VERTEX = """
#version 330
uniform mat4 clip_from_world;
in vec3 position;
in vec4 color;
in vec2 uv;
out vec3 vertex_color;
out vec2 vertex_uv;
void main() {
    gl_Position = clip_from_world * vec4(position, 1.0);
    vertex_color = color.rgb;
    vertex_uv = uv;
}
"""

_TEXTURED_FRAGMENT = """
#version 330
uniform sampler2D base;
in vec3 vertex_color;
in vec2 vertex_uv;
out vec4 pixel;
void main() { pixel = vec4(vertex_color * texture(base, vertex_uv).rgb, 0.0); }
"""

# Lit per vertex: bodies have about a triangle per pixel, and fragments stay cheap.
_BODY_VERTEX = f"""
#version 330
const float AMBIENT_LOW = {AMBIENT_LOW}, AMBIENT_HIGH = {AMBIENT_HIGH}, OUTLINE = {OUTLINE};
const float KEY_STRENGTH = {KEY_STRENGTH}, KEY_WRAP = {KEY_WRAP}, GAMMA = {GAMMA};
"""
_BODY_VERTEX += """
layout(std140) uniform Pose { vec4 rows[66]; };
uniform mat4 clip_from_view;
uniform vec3 up_view;
uniform vec3 key_view;
in vec3 position;
in vec3 normal;
in vec4 color;
in uvec4 joints;
in vec4 weights;
out vec3 vertex_color;

vec4 blended(uint row) {
    return weights.x * rows[3u * joints.x + row] + weights.y * rows[3u * joints.y + row]
         + weights.z * rows[3u * joints.z + row] + weights.w * rows[3u * joints.w + row];
}

void main() {
    vec4 x = blended(0u), y = blended(1u), z = blended(2u);
    vec4 rest = vec4(position, 1.0);
    vec3 view = vec3(dot(x, rest), dot(y, rest), dot(z, rest));
    gl_Position = clip_from_view * vec4(view, 1.0);
    vec3 n = normalize(vec3(dot(x.xyz, normal), dot(y.xyz, normal), dot(z.xyz, normal)));
    float sky = mix(AMBIENT_LOW, AMBIENT_HIGH, 0.5 + 0.5 * dot(n, up_view));
    float key = KEY_STRENGTH * max(0.0, (dot(n, key_view) + KEY_WRAP) / (1.0 + KEY_WRAP));
    float facing = mix(OUTLINE, 1.0, abs(dot(n, normalize(view))));
    vertex_color = color.rgb * pow((sky + key) * facing, 1.0 / GAMMA);
}
"""

_BODY_FRAGMENT = """
#version 330
uniform float instance;
in vec3 vertex_color;
out vec4 pixel;
void main() { pixel = vec4(vertex_color, instance); }
"""

# Drawn a little nearer to the eye along each pixel's own ray: in front of its floor, not shifted.
_SHADOW_VERTEX = """
#version 330
uniform mat4 clip_from_view;
uniform mat4 view_from_world;
in vec3 position;
in vec3 disc;
out vec3 vertex_disc;
void main() {
    vec3 view = (view_from_world * vec4(position, 1.0)).xyz;
    view *= 1.0 - 0.03 / max(length(view), 0.06);
    gl_Position = clip_from_view * vec4(view, 1.0);
    vertex_disc = disc;
}
"""

_SHADOW_FRAGMENT = """
#version 330
in vec3 vertex_disc;
out vec4 pixel;
void main() {
    float inside = max(0.0, 1.0 - dot(vertex_disc.xy, vertex_disc.xy));
    pixel = vec4(0.0, 0.0, 0.0, vertex_disc.z * inside * inside);
}
"""

_RESOLVE_VERTEX = """
#version 330
void main() {
    vec2 corner = vec2(float((gl_VertexID & 1) * 4 - 1), float((gl_VertexID >> 1) * 4 - 1));
    gl_Position = vec4(corner, 0.0, 1.0);
}
"""

# Sample 2 i + 1 lies at the centre of pixel i. Its depth and id are the pixel's own; its colour is
# averaged with its neighbours by 1-2-1 weights; nine fetches beat four filtered ones on a CPU.
_RESOLVE_FRAGMENT = """
#version 330
uniform sampler2D color_samples;
uniform sampler2D depth_samples;
uniform ivec2 offset;
uniform vec2 near_far;
layout(location = 0) out vec4 color;
layout(location = 1) out float depth;

vec3 near(ivec2 at, int across, int down) {
    return texelFetch(color_samples, at + ivec2(across, down), 0).rgb;
}

void main() {
    ivec2 at = 2 * (ivec2(gl_FragCoord.xy) + offset) + 1;
    vec3 mean = 0.25 * near(at, 0, 0)
        + 0.125 * (near(at, -1, 0) + near(at, 1, 0) + near(at, 0, -1) + near(at, 0, 1))
        + 0.0625 * (near(at, -1, -1) + near(at, 1, -1) + near(at, -1, 1) + near(at, 1, 1));
    color = vec4(mean, texelFetch(color_samples, at, 0).a);
    // 1 - w keeps its digits far away, where w is close to 1.
    float w = 1.0 - texelFetch(depth_samples, at, 0).r;
    float n = near_far.x, f = near_far.y;
    depth = w > 0.0 ? n * f / (n + w * (f - n)) : uintBitsToFloat(0x7F800000u);
}
"""

SCENE = (_SCENE_VERTEX, _SCENE_FRAGMENT)
"""Vertex colours as they are; vertex shader, fragment shader."""
TEXTURED_SCENE = (_TEXTURED_VERTEX, _TEXTURED_FRAGMENT)
"""Vertex colours times texture."""
BODY = (_BODY_VERTEX, _BODY_FRAGMENT)
"""Skinned, under a sky, a soft key light and a slight darkening towards the outline."""
SHADOW = (_SHADOW_VERTEX, _SHADOW_FRAGMENT)
"""Soft dark discs on the floor."""
RESOLVE = (_RESOLVE_VERTEX, _RESOLVE_FRAGMENT)
"""Samples to pixels: mean colour; instance id and metric depth of the centre."""
