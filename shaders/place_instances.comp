// SPDX-License-Identifier: Apache-2.0
// Before the stages of a recorded scan: takes the transforms of instances from buffers of the caller and composes them
// with the sensor's pose, as InstanceTable does for the others on the host. One invocation per such instance.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#define OUTSIDE_OF_SCANS
#include "common/shared.h"
#include "options.glsl"
#include "bindings.glsl"
#include "limits.glsl"
#include "pairs.glsl"

layout(local_size_x = 64) in;

// Linear part and shift of a transform.
struct Placement {
  mat3 columns;
  vec3 shift;
};

Placement placementOf(TransformSource source, CallerMemory memory, uint number) {
  uint first = number * (source.stride / 4), step = source.byColumns != 0 ? 1 : 4, nextColumn = 5 - step;
  vec3 columns[4];
  for (uint column = 0; column < 4; ++column) {
    uint at = first + column * nextColumn;
    columns[column] = uintBitsToFloat(uvec3(memory.at[at], memory.at[at + step], memory.at[at + 2 * step]));
  }
  return Placement(mat3(columns[0], columns[1], columns[2]), columns[3]);
}

// With the rotation R to the sensor, the linear part M, the instance's origin t in the world's axes as seen from the
// sensor, and the pivot p: R (M x + t) = R M (x - p) + R (M p + t).
Instance composed(TransformSource source, Placement placement, Pairs meshOrigin, uint number) {
  PairsMatrix toSensor = matrixOf(Pairs(source.row0, source.row0Low), Pairs(source.row1, source.row1Low),
                                  Pairs(source.row2, source.row2Low));
  PairsMatrix columns = matrixOf(pairs(placement.columns[0]), pairs(placement.columns[1]), pairs(placement.columns[2]));
  PairsMatrix rows = transposed(columns), turned;
  for (int k = 0; k < 3; ++k) turned.of[k] = combined(rows, toSensor.of[k]);
  Pairs shift = plus(plus(Pairs(source.shift, source.shiftLow), pairs(placement.shift)), combined(columns, meshOrigin));

  // If it flattens the mesh along an axis of the mesh, any number may be the pivot's coordinate along this axis.
  int axis = -1;
  for (int k = 0; k < 3; ++k)
    if (placement.columns[k] == vec3(0.0)) axis = k;
  PairsMatrix filled = columns;
  if (axis >= 0) filled.of[axis] = crossOf(columns.of[(axis + 1) % 3], columns.of[(axis + 2) % 3]);
  // The inverse of the linear part, times the determinant.
  PairsMatrix inverse = transposed(matrixOf(crossOf(filled.of[1], filled.of[2]), crossOf(filled.of[2], filled.of[0]),
                                            crossOf(filled.of[0], filled.of[1])));
  Pairs volume = each(combined(inverse, filled.of[0]), 0);
  vec3 pivot = -over(combined(inverse, shift), volume).high;
  pivot = vec3(axis == 0 ? 0.0 : pivot.x, axis == 1 ? 0.0 : pivot.y, axis == 2 ? 0.0 : pivot.z);
  // Any other transform that flattens the mesh has no inverse.
  float box = length(filled.of[0].high) * length(filled.of[1].high) * length(filled.of[2].high);
  bool usable = abs(volume.high.x) > kFlatVolume * box;
  if (!usable || !inLimits(pivot)) pivot = vec3(0.0);
  Pairs offset = combined(transposed(toSensor), plus(combined(columns, pairs(pivot)), shift));

  return Instance(vec4(turned.of[0].high, pivot.x), vec4(turned.of[1].high, pivot.y), vec4(turned.of[2].high, pivot.z),
                  offset.high, number | uint(usable && axis < 0 && volume.high.x < 0.0) << 31);
}

void place(TransformedInstance entry) {
  TransformSource source = transformSources.at[entry.source];
  Placement placement = placementOf(source, CallerMemory(transformBuffers.at[entry.source].memory), entry.number);
  uint number = instances.at[entry.instance].firstTriangle & 0x7fffffffu;
  if (inLimits(placement.columns[0]) && inLimits(placement.columns[1]) && inLimits(placement.columns[2]) &&
      inLimits(placement.shift)) {
    instances.at[entry.instance] = composed(source, placement, Pairs(entry.origin, entry.originLow), number);
  } else {
    // All of it is at one point, out of range.
    instances.at[entry.instance] = Instance(vec4(0.0), vec4(0.0), vec4(0.0), vec3(kCoordinateLimit), number);
    atomicAdd(unplacedInstances.at[0], 1);
  }
}

void main() {
  useOwnAddresses();
  for (uint i = gl_GlobalInvocationID.x; i < pass.placedCount; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x)
    place(transformedInstances.at[i]);
}
