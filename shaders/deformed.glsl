// SPDX-License-Identifier: Apache-2.0
// Vertices and boxes of deformable meshes. A vertex is the sum of where its joints take it, in the order of the joints,
// so it gets the same bytes in every cluster; joints that it does not follow have weight 0 and add nothing.
#include "deform.h"

// Returns the mesh of an instance if the mesh is deformable, otherwise kNone.
uint deformableMesh(uint instance) {
  if (!DEFORMED) return kNone;
  uint mesh = instanceMeshes.at[instance];
  return deformers.at[mesh].joints + deformers.at[mesh].targets > 0 ? mesh : kNone;
}

// Returns the first bone of a cluster, and the one after its last.
uvec2 bonesOf(uint mesh, uint cluster) {
  uint start = deformers.at[mesh].startFirst + cluster - deformers.at[mesh].clusterFirst;
  return uvec2(boneStarts.at[start], boneStarts.at[start + 1]);
}

// Returns a vertex of a deformable mesh moved by the morph targets alone, in the mesh frame: at the start of the scan,
// or at the end of the mesh's motion. `vertex` is its entry in `positions`.
vec3 morphedPosition(uint mesh, uint vertex, bool atEnd) {
  uint number = vertex - deformers.at[mesh].vertexFirst;
  vec3 position = restPositions.at[deformers.at[mesh].restFirst + number];
  uint targets = atEnd || deformers.at[mesh].deformed != 0 ? deformers.at[mesh].targets : 0;
  for (uint k = 0; k < targets; ++k) {
    uint target = deformers.at[mesh].weightFirst + k;
    float weight = atEnd ? endMorphWeights.at[target] : morphWeights.at[target];
    position = morphed(position, morphOffsets.at[deformers.at[mesh].offsetFirst + k * deformers.at[mesh].vertices + number], weight);
  }
  return position;
}

bool followsJoints(uint mesh, bool atEnd) {
  return deformers.at[mesh].joints > 0 && (atEnd || deformers.at[mesh].deformed != 0);
}

// Returns the deformed position of a vertex of a cluster.
vec3 deformedPosition(uint mesh, uint cluster, uint vertex, bool atEnd) {
  vec3 position = morphedPosition(mesh, vertex, atEnd);
  if (!followsJoints(mesh, atEnd)) return position;
  vec3 sum = vec3(0.0);
  uvec2 run = bonesOf(mesh, cluster);
  for (uint k = run.x; k < run.y; ++k) {
    uint row = deformers.at[mesh].rowFirst + 3 * bones.at[k].joint;
    float weight = boneWeights.at[bones.at[k].weightFirst + vertex - clusters.at[cluster].vertexFirst];
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
    sum = withJoint(sum, x, y, z, position, weight);
  }
  return sum;
}

// Encloses the deformed vertices of a cluster. Each is a mean of the points to which its joints take it, so it lies in
// the box around the boxes of all joints. The margin covers rounding, that of the weights' sum included.
void deformedBox(uint mesh, uint cluster, out vec3 low, out vec3 high) {
  low = vec3(kCoordinateLimit);
  high = vec3(-kCoordinateLimit);
  uvec2 run = bonesOf(mesh, cluster);
  vec3 morphLow = deformers.at[mesh].morphLow, morphHigh = deformers.at[mesh].morphHigh;
  for (uint k = run.x; k < run.y; ++k) {
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
vec3 vertexVelocity(InstanceMotion moving, uint instance, vec3 corner, uint cluster, uint vertex) {
  vec3 velocity = velocityOf(moving, corner);
  if (!DEFORMED || moving.bound.z == 0.0) return velocity;
  uint mesh = instanceMeshes.at[instance];
  vec3 start = deformedPosition(mesh, cluster, vertex, false);
  precise vec3 change = deformedPosition(mesh, cluster, vertex, true) - start;
  vec3 seen = rotated(instances.at[instance].row0, instances.at[instance].row1, instances.at[instance].row2, change);
  precise vec3 sum = velocity + seen * moving.bound.w + rotated(moving.row0, moving.row1, moving.row2, seen);
  return sum;
}
