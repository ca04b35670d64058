// SPDX-License-Identifier: Apache-2.0
// One vertex of the scene.
#version 460

layout(push_constant) uniform Constants {
  mat4 toClip;
  mat3x4 toWorld;  // the linear part; w of its columns is the colour
};
layout(location = 0) in vec3 position;
layout(location = 0) out vec3 place;  // in the directions of the world, up to a shift

void main() {
  gl_Position = toClip * vec4(position, 1);
  place = mat3(toWorld) * position;
}
