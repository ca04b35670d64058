// SPDX-License-Identifier: Apache-2.0
// Vertices and boxes of deformable meshes. A vertex is the sum of where its joints take it, in the order of the joints,
// so it gets the same bytes in every cluster; joints that it does not follow have weight 0 and add nothing.
#include "deform.h"

// True if the mesh is deformable. A mesh that is not has a record of zeros.
bool isDeformable(Deformer deformer) { return deformer.joints + deformer.targets > 0; }

// Returns the first bone of a cluster, and the one after its last.
uvec2 bonesOf(Deformer deformer, uint cluster) {
  uint start = deformer.startFirst + cluster - deformer.clusterFirst;
  return uvec2(boneStarts.at[start], boneStarts.at[start + 1]);
}

// Returns a vertex of a deformable mesh moved by the morph targets alone, in the mesh frame: at the start of the scan,
// or at the end of the mesh's motion. `vertex` is its entry in `positions`.
vec3 morphedPosition(Deformer deformer, uint vertex, bool atEnd) {
  uint number = vertex - deformer.vertexFirst;
  vec3 position = restPositions.at[deformer.restFirst + number];
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
  uvec2 run = bonesOf(deformer, cluster);
  for (uint k = run.x; k < run.y; ++k) {
    uint row = deformer.rowFirst + 3 * bones.at[k].joint;
    float weight = boneWeights.at[bones.at[k].weightFirst + vertex - clusters.at[cluster].vertexFirst];
    vec3 there = through(jointRow(row, atEnd), jointRow(row + 1, atEnd), jointRow(row + 2, atEnd), position);
    sum = withShare(sum, there, weight);
  }
  return sum;
}

// Encloses the deformed vertices of a cluster. Each is a mean of the points to which its joints take it, so it lies in
// the box around the boxes of all joints.
void deformedBox(Deformer deformer, uint cluster, out vec3 low, out vec3 high) {
  low = vec3(kCoordinateLimit);
  high = vec3(-kCoordinateLimit);
  uvec2 run = bonesOf(deformer, cluster);
  for (uint k = run.x; k < run.y; ++k) {
    vec3 from = bones.at[k].low + deformer.morphLow, to = bones.at[k].high + deformer.morphHigh;
    vec3 middle = 0.5 * (from + to), extent = 0.5 * (to - from);
    vec4 rowX = vec4(1.0, 0.0, 0.0, 0.0), rowY = vec4(0.0, 1.0, 0.0, 0.0), rowZ = vec4(0.0, 0.0, 1.0, 0.0);
    uint joint = bones.at[k].joint;
    if (joint != kNone) {
      uint row = deformer.rowFirst + 3 * joint;
      rowX = jointRows.at[row];
      rowY = jointRows.at[row + 1];
      rowZ = jointRows.at[row + 2];
    }
    vec2 x = spanThrough(rowX, middle, extent, kBoneMargin), y = spanThrough(rowY, middle, extent, kBoneMargin),
         z = spanThrough(rowZ, middle, extent, kBoneMargin);
    vec3 centre = vec3(x.x, y.x, z.x), size = vec3(x.y, y.y, z.y);
    low = min(low, centre - size);
    high = max(high, centre + size);
  }
}

// Returns the velocity of a vertex of a moving instance, m/s in the sensor's axes; `corner` is where it is at the start
// of the scan, in the sensor's frame, and `vertex` its entry in `positions`. The instance moves as InstanceMotion says,
// and to that comes what the deformation adds, as the instance stands at the end.
vec3 vertexVelocity(InstanceMotion moving, uint instance, vec3 corner, uint cluster, uint vertex) {
  vec3 velocity = velocityOf(moving, corner);
  if (DEFORMED == kDeformsNothing || moving.bound.z == 0.0) return velocity;
  Deformer deformer = deformers.at[instanceMeshes.at[instance]];
  vec3 start = deformedPosition(deformer, cluster, vertex, false);
  precise vec3 change = deformedPosition(deformer, cluster, vertex, true) - start;
  vec3 seen = rotated(instances.at[instance].row0, instances.at[instance].row1, instances.at[instance].row2, change);
  precise vec3 sum = velocity + seen * moving.bound.w + rotated(moving.row0, moving.row1, moving.row2, seen);
  return sum;
}
