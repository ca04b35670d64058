// SPDX-License-Identifier: Apache-2.0
// Vertices and boxes of deformable meshes.
#include "deform.h"

// Returns the mesh of an instance if the mesh is deformable, otherwise kNone.
uint deformableMesh(uint instance) {
  if (!DEFORMED) return kNone;
  uint mesh = instanceMeshes.at[instance];
  return deformers.at[mesh].influences + deformers.at[mesh].targets > 0 ? mesh : kNone;
}

// Returns the position of a vertex of a deformable mesh, in the mesh frame; `vertex` is its entry in `positions`.
vec3 deformedPosition(uint mesh, uint vertex) {
  uint number = vertex - deformers.at[mesh].vertexFirst;
  vec3 position = restPositions.at[deformers.at[mesh].restFirst + number];
  if (deformers.at[mesh].deformed == 0) return position;
  uint targets = deformers.at[mesh].targets, offset = deformers.at[mesh].offsetFirst + number * targets;
  for (uint k = 0; k < targets; ++k)
    position = morphed(position, morphOffsets.at[offset + k], morphWeights.at[deformers.at[mesh].weightFirst + k]);
  uint count = deformers.at[mesh].influences, first = deformers.at[mesh].influenceFirst + number * count;
  if (count == 0) return position;
  vec3 sum = vec3(0.0);
  for (uint k = 0; k < count; ++k) {
    uvec2 influence = influences.at[first + k];
    uint row = deformers.at[mesh].rowFirst + 3 * influence.x;
    sum = withJoint(sum, jointRows.at[row], jointRows.at[row + 1], jointRows.at[row + 2], position,
                    uintBitsToFloat(influence.y));
  }
  return sum;
}

// Encloses the deformed vertices of a cluster. Each is a mean of the points to which its joints take it, so it lies in
// the box around the boxes of all joints. The margin covers rounding, that of the weights' sum included.
void deformedBox(uint mesh, uint cluster, out vec3 low, out vec3 high) {
  low = vec3(kCoordinateLimit);
  high = vec3(-kCoordinateLimit);
  uint start = deformers.at[mesh].startFirst + cluster - deformers.at[mesh].clusterFirst;
  uint end = boneStarts.at[start + 1];
  vec3 morphLow = deformers.at[mesh].morphLow, morphHigh = deformers.at[mesh].morphHigh;
  for (uint k = boneStarts.at[start]; k < end; ++k) {
    vec3 from = bones.at[k].low + morphLow, to = bones.at[k].high + morphHigh;
    vec3 middle = 0.5 * (from + to), extent = 0.5 * (to - from), reach = abs(middle) + extent;
    uint joint = bones.at[k].joint;
    if (joint != kNone) {
      uint row = deformers.at[mesh].rowFirst + 3 * joint;
      vec4 x = jointRows.at[row], y = jointRows.at[row + 1], z = jointRows.at[row + 2];
      vec3 shift = vec3(x.w, y.w, z.w);
      reach = vec3(dot(abs(x.xyz), reach), dot(abs(y.xyz), reach), dot(abs(z.xyz), reach)) + abs(shift);
      extent = vec3(dot(abs(x.xyz), extent), dot(abs(y.xyz), extent), dot(abs(z.xyz), extent));
      middle = vec3(dot(x.xyz, middle), dot(y.xyz, middle), dot(z.xyz, middle)) + shift;
    }
    extent += 2e-5 * reach;
    low = min(low, middle - extent);
    high = max(high, middle + extent);
  }
}
