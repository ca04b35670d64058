// SPDX-License-Identifier: Apache-2.0
// Vertices and boxes of deformable meshes.
#include "deform.h"

// Returns the mesh of an instance if the mesh is deformable, otherwise kNone.
uint deformableMesh(uint instance) {
  if (!DEFORMED) return kNone;
  uint mesh = instanceMeshes.at[instance];
  return deformers.at[mesh].influences + deformers.at[mesh].targets > 0 ? mesh : kNone;
}

// Returns the position of a vertex of a deformable mesh, in the mesh frame: at the start of the scan, or at the end of
// the motion of the mesh. `vertex` is its entry in `positions`.
vec3 deformedPosition(uint mesh, uint vertex, bool atEnd) {
  uint number = vertex - deformers.at[mesh].vertexFirst;
  vec3 position = restPositions.at[deformers.at[mesh].restFirst + number];
  if (!atEnd && deformers.at[mesh].deformed == 0) return position;
  uint targets = deformers.at[mesh].targets, offset = deformers.at[mesh].offsetFirst + number * targets;
  for (uint k = 0; k < targets; ++k) {
    uint target = deformers.at[mesh].weightFirst + k;
    float weight = atEnd ? endMorphWeights.at[target] : morphWeights.at[target];
    position = morphed(position, morphOffsets.at[offset + k], weight);
  }
  uint count = deformers.at[mesh].influences, first = deformers.at[mesh].influenceFirst + number * count;
  if (count == 0) return position;
  vec3 sum = vec3(0.0);
  for (uint k = 0; k < count; ++k) {
    uvec2 influence = influences.at[first + k];
    uint row = deformers.at[mesh].rowFirst + 3 * influence.x;
    vec4 x, y, z;
    if (atEnd) {
      x = endJointRows.at[row];
      y = endJointRows.at[row + 1];
      z = endJointRows.at[row + 2];
    } else {
      x = jointRows.at[row];
      y = jointRows.at[row + 1];
      z = jointRows.at[row + 2];
    }
    sum = withJoint(sum, x, y, z, position, uintBitsToFloat(influence.y));
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

// Returns the velocity of a vertex of a moving instance, m/s in the sensor's axes; `corner` is where it is at the start
// of the scan, in the sensor's frame, and `vertex` its entry in `positions`. The instance moves as InstanceMotion says,
// and to that comes what the deformation adds, as the instance stands at the end.
vec3 vertexVelocity(InstanceMotion moving, uint instance, vec3 corner, uint vertex) {
  vec3 velocity = velocityOf(moving, corner);
  if (!DEFORMED || moving.bound.z == 0.0) return velocity;
  uint mesh = instanceMeshes.at[instance];
  precise vec3 change = deformedPosition(mesh, vertex, true) - deformedPosition(mesh, vertex, false);
  vec3 seen = rotated(instances.at[instance].row0, instances.at[instance].row1, instances.at[instance].row2, change);
  precise vec3 sum = velocity + seen * moving.bound.w + rotated(moving.row0, moving.row1, moving.row2, seen);
  return sum;
}
