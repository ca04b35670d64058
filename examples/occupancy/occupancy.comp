// SPDX-License-Identifier: Apache-2.0
// Counts the points of a scan in the cells of a map, straight from the buffer that the scan has filled.
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 64) in;

// A row of the scan, as main.cpp has laid it out.
struct Point {
  float x, y, z;
};
layout(buffer_reference, scalar) readonly buffer Points { Point at[]; };
layout(buffer_reference, scalar) readonly buffer Header { uint rows; };
layout(buffer_reference, scalar) buffer Cells { uint at[]; };

layout(push_constant, scalar) uniform Constants {
  Points points;
  Header header;
  Cells cells;
  uint width;      // cells in a row and in a column of the map
  float cellSize;  // metres; the sensor is in the middle of the map
};

void main() {
  uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  for (uint i = gl_GlobalInvocationID.x; i < header.rows; i += stride) {
    Point point = points.at[i];
    ivec2 cell = ivec2(floor(vec2(point.x, point.y) / cellSize)) + int(width) / 2;
    if (all(greaterThanEqual(cell, ivec2(0))) && all(lessThan(cell, ivec2(width))))
      atomicAdd(cells.at[cell.y * width + cell.x], 1);
  }
}
