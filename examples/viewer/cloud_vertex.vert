// SPDX-License-Identifier: Apache-2.0
// One point of the cloud: a row of the scan's records.
#version 460

layout(push_constant) uniform Constants {
  mat4 toClip;  // from the sensor's frame
  uint colouring;
  float farRange;  // metres; the last colour of the ranges
  float size;  // pixels
  float near;  // metres from the camera to the near plane
};
layout(location = 0) in vec3 position;
layout(location = 1) in float range;
layout(location = 2) in float intensity;
layout(location = 3) in uint instance;
layout(location = 0) flat out vec3 colour;

// Red, yellow, green, cyan, blue, for 0 to 1.
vec3 rainbow(float x) {
  return clamp(2 - abs(4 * vec3(x, x, x) - vec3(0, 2, 4)), 0, 1);
}

// Violet, orange, pale yellow, for 0 to 1.
vec3 glow(float x) {
  return mix(mix(vec3(0.15, 0.02, 0.55), vec3(1, 0.25, 0.05), smoothstep(0, 0.5, x)), vec3(1, 1, 0.6),
             smoothstep(0.4, 1, x));
}

// A colour of its own for each number: hues at steps of the golden angle.
vec3 distinct(uint number) {
  float hue = fract(0.6180340 * float(number % 4096));
  return clamp(abs(fract(hue + vec3(0, 2, 1) / 3) * 6 - 3) - 1, 0, 1) * 0.85 + 0.15;
}

void main() {
  gl_Position = toClip * vec4(position, 1);
  gl_Position.z -= 0.005 * near;  // as if half a per cent nearer to the camera than the surface on which it lies
  gl_PointSize = size;
  colour = colouring == 0 ? rainbow(clamp(range / farRange, 0, 1))
           : colouring == 1 ? glow(clamp(intensity, 0, 1)) : distinct(instance);
}
