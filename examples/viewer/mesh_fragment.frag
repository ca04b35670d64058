// SPDX-License-Identifier: Apache-2.0
// Lambert's shading of flat triangles, by a sun and by the sky.
#version 460

layout(push_constant) uniform Constants {
  mat4 toClip;
  mat3x4 toWorld;
};
layout(location = 0) in vec3 place;
layout(location = 0) out vec4 shade;

void main() {
  const vec3 sun = normalize(vec3(0.35, -0.55, 0.75));
  vec3 normal = normalize(cross(dFdy(place), dFdx(place)));
  vec3 colour = vec3(toWorld[0].w, toWorld[1].w, toWorld[2].w);
  float light = 0.10 + 0.10 * (0.5 + 0.5 * normal.z) + 0.35 * max(dot(normal, sun), 0);
  shade = vec4(colour * light, 1);
}
