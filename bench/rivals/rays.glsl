// SPDX-License-Identifier: Apache-2.0
// Inputs (struct Rays of vulkan_rival.hpp) and outputs of the ray shaders.
#extension GL_EXT_buffer_reference : require

layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Floats { float at[]; };
layout(buffer_reference, std430, buffer_reference_align = 8) readonly buffer Placements { uvec2 at[]; };
layout(buffer_reference, std430, buffer_reference_align = 4) writeonly buffer Words { uint at[]; };

layout(push_constant) uniform Rays {
  vec4 toScene[3];        // sensor frame -> the structure's frame
  Floats directions;      // 3 per beam, unit, sensor frame
  Placements placements;  // per entry of the top structure: its first triangle and its instance
  Words hits;             // ranges, then triangles, then instances
  float rangeMin, rangeMax;
  uint columns, channels;
};

layout(set = 0, binding = 0) uniform accelerationStructureEXT scene;

const uint kNone = 0xffffffffu;
const uint kNaN = 0x7fc00000u;

vec3 origin() { return vec3(toScene[0].w, toScene[1].w, toScene[2].w); }

vec3 direction(uint beam) {
  const vec3 d = vec3(directions.at[3 * beam], directions.at[3 * beam + 1], directions.at[3 * beam + 2]);
  return vec3(dot(toScene[0].xyz, d), dot(toScene[1].xyz, d), dot(toScene[2].xyz, d));
}

void writeHit(uint beam, uint range, uint triangle, uint instance) {
  const uint beams = columns * channels;
  hits.at[beam] = range;
  hits.at[beams + beam] = triangle;
  hits.at[2 * beams + beam] = instance;
}

void writeMiss(uint beam) { writeHit(beam, kNaN, kNone, kNone); }

void writeHit(uint beam, float range, uint entry, uint primitive) {
  const uvec2 placement = placements.at[entry];
  writeHit(beam, floatBitsToUint(range), placement.x + primitive, placement.y);
}
