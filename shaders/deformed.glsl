// SPDX-License-Identifier: Apache-2.0
// Vertices and boxes of deformable meshes. A vertex is the sum of where its joints take it, in the order of the joints,
// so it gets the same bytes in every cluster.
#include "common/deform.h"

// True if the mesh is deformable. A mesh that is not has a record of zeros.
bool isDeformable(Deformer deformer) { return deformer.joints + deformer.targets > 0; }

ClusterBones bonesOf(Deformer deformer, uint cluster) {
  return clusterBones.at[deformer.bonesFirst + cluster - deformer.clusterFirst];
}

// Returns a vertex of a deformable mesh moved by the morph targets alone, in the mesh frame: at the start of the scan,
// or at the end of the mesh's motion. `vertex` is its entry in `positions`.
vec3 morphedPosition(Deformer deformer, uint vertex, bool atEnd) {
  uint number = vertex - deformer.vertexFirst;
  vec3 position = restPositions.at[deformer.restFirst + number];
  if (deformer.targets == 0) return position;
  uint targets = atEnd || deformer.deformed != 0 ? deformer.targets : 0;
  for (uint k = 0; k < targets; ++k) {
    uint target = deformer.weightFirst + k;
    float weight = atEnd ? endMorphWeights.at[target] : morphWeights.at[target];
    position = withShare(position, morphOffsets.at[deformer.offsetFirst + k * deformer.vertices + number], weight);
  }
  return position;
}

bool followsJoints(Deformer deformer, bool atEnd) {
  return deformer.joints > 0 && (atEnd || deformer.deformed != 0);
}

// endJointRows is there only if a mesh is deformed during the scan.
vec4 jointRow(uint row, bool atEnd) {
  if (atEnd) return endJointRows.at[row];
  return jointRows.at[row];
}

// Returns the deformed position of a vertex of a cluster.
vec3 deformedPosition(Deformer deformer, uint cluster, uint vertex, bool atEnd) {
  vec3 position = morphedPosition(deformer, vertex, atEnd);
  if (!followsJoints(deformer, atEnd)) return position;
  vec3 sum = vec3(0.0);
  ClusterBones own = bonesOf(deformer, cluster);
  uint first = own.weightFirst + (vertex - clusters.at[cluster].vertexFirst) * own.influences;
  for (uint k = first; k < first + own.influences; ++k) {
    uint weight = boneWeights.at[k];
    uint row = deformer.rowFirst + 3 * jointOf(bones.at[own.first + boneOf(weight)]);
    vec3 there = through(jointRow(row, atEnd), jointRow(row + 1, atEnd), jointRow(row + 2, atEnd), position);
    sum = withShare(sum, there, shareOf(weight));
  }
  return sum;
}

// Encloses the deformed vertices of a cluster. Each is a mean of the points to which its joints take it. All follow a
// joint with at least its least weight in the cluster; with the weight that is left they may follow any of the joints.
void deformedBox(Deformer deformer, uint cluster, out vec3 low, out vec3 high) {
  vec3 from = clusters.at[cluster].low + deformer.morphLow, to = clusters.at[cluster].high + deformer.morphHigh;
  vec3 middle = 0.5 * (from + to), extent = 0.5 * (to - from);
  if (deformer.joints == 0) {
    vec3 size = extent + kBoneMargin * (abs(middle) + extent);
    low = middle - size;
    high = middle + size;
    return;
  }
  vec3 leastLow = vec3(0.0), leastHigh = vec3(0.0);
  float left = 1.0;
  low = vec3(kCoordinateLimit);
  high = vec3(-kCoordinateLimit);
  ClusterBones own = bonesOf(deformer, cluster);
  for (uint k = own.first; k < own.first + own.count; ++k) {
    uint bone = bones.at[k], row = deformer.rowFirst + 3 * jointOf(bone);
    vec2 x = spanThrough(jointRows.at[row], middle, extent, kBoneMargin),
         y = spanThrough(jointRows.at[row + 1], middle, extent, kBoneMargin),
         z = spanThrough(jointRows.at[row + 2], middle, extent, kBoneMargin);
    vec3 centre = vec3(x.x, y.x, z.x), size = vec3(x.y, y.y, z.y);
    float least = leastShareOf(bone);
    leastLow += least * (centre - size);
    leastHigh += least * (centre + size);
    left -= least;
    low = min(low, centre - size);
    high = max(high, centre + size);
  }
  low = leastLow + left * low;
  high = leastHigh + left * high;
}

// Returns where a vertex of a cluster is in the mesh frame at the start of the scan.
vec3 startOf(Deformer deformer, uint cluster, uint vertex) {
  return isDeformable(deformer) ? deformedPosition(deformer, cluster, vertex, false) : positions.at[vertex];
}

// Returns the velocity of a vertex of a moving instance, m/s in the sensor's axes; `vertex` is its entry in `positions`.
// The instance moves as InstanceMotion says, and to that comes what the deformation adds, as the instance stands at the
// end.
vec3 vertexVelocity(InstanceMotion moving, uint instance, uint cluster, uint vertex) {
  if (DEFORMED == kDeformsNothing) return velocityOf(moving, positions.at[vertex]);
  Deformer deformer = deformers.at[instanceMeshes.at[instance]];
  vec3 start = startOf(deformer, cluster, vertex);
  vec3 velocity = velocityOf(moving, start);
  if (moving.bound.z == 0.0) return velocity;
  precise vec3 change = deformedPosition(deformer, cluster, vertex, true) - start;
  vec3 seen = rotated(instances.at[instance].row0, instances.at[instance].row1, instances.at[instance].row2, change);
  precise vec3 sum = velocity + seen * moving.bound.w + rotated(moving.row0, moving.row1, moving.row2, change);
  return sum;
}
