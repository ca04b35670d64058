// SPDX-License-Identifier: Apache-2.0
// Loads a cluster and transforms the corners of its triangles to the sensor's frame. One lane loads each vertex and
// the others get it by shuffle, which is one instruction. On a CPU a load takes many.

// A cluster and its instance, the same for all lanes.
struct LoadedCluster {
  Instance instance;
  uint vertexFirst, vertexCount, triangleFirst, triangleCount;
  uint doubleSided;
  uint material;
  uint number;   // number of the instance
  uint cluster;  // number of the cluster
  Deformer deformer;  // of the mesh
  vec2 bound;   // InstanceMotion::bound; only with motion
};

// Clusters that the subgroup processes one after the other. Each lane has loaded one, so that the subgroup waits for
// memory once, not once per cluster.
struct Batch {
  uint count, done;  // the clusters of the batch, and those that have been processed
  uvec2 pair;        // the lane's instance and cluster
  uint vertexFirst, triangleFirst, doubleSided, material;
  uint counts;  // vertices, and triangles << 16
};

// Each lane loads the cluster in an entry of `visible`.
void loadBatch(uint entry, inout Batch batch) {
  batch.pair = visible.at[entry];
  batch.vertexFirst = clusters.at[batch.pair.y].vertexFirst;
  batch.triangleFirst = clusters.at[batch.pair.y].triangleFirst;
  batch.counts = clusters.at[batch.pair.y].vertexCount | clusters.at[batch.pair.y].triangleCount << 16;
  batch.doubleSided = clusters.at[batch.pair.y].doubleSided;
  batch.material = clusters.at[batch.pair.y].material;
}

// Makes `loaded` the next cluster of a batch. The instance is loaded only if the cluster before belongs to another one,
// which is rare, because neighbouring clusters mostly share an instance.
void loadNext(inout Batch batch, inout LoadedCluster loaded) {
  uint lane = batch.done++;
  uint number = subgroupShuffle(batch.pair.x, lane), counts = subgroupShuffle(batch.counts, lane);
  if (number != loaded.number) {
    loaded.instance = instanceAt(number);
    if (DEFORMED != kDeformsNothing) loaded.deformer = deformerOf(number);
    if (MOTION) {
      if (subgroupElect()) loaded.bound = boundOf(number);
      loaded.bound = subgroupBroadcastFirst(loaded.bound);
    }
  }
  loaded.number = number;
  loaded.cluster = subgroupShuffle(batch.pair.y, lane);
  loaded.vertexFirst = subgroupShuffle(batch.vertexFirst, lane);
  loaded.triangleFirst = subgroupShuffle(batch.triangleFirst, lane);
  loaded.vertexCount = counts & 0xffff;
  loaded.triangleCount = counts >> 16;
  loaded.doubleSided = subgroupShuffle(batch.doubleSided, lane);
  loaded.material = subgroupShuffle(batch.material, lane);
}

// Holds vertices lane, lane + subgroup size, ... of a cluster, or nothing if the cluster has too many for
// kVertexRounds. In town scenes a tenth of the clusters has more than 6 times 8 vertices. A pipeline is made for
// the size of its subgroups: more rounds than a cluster needs only cost registers.
layout(constant_id = 23) const uint kVertexRounds = 6;
const uint kMostVertexRounds = 6;
struct Vertices {
  vec3 corners[kMostVertexRounds];
  uint count;
};

vec3 toSensor(LoadedCluster loaded, vec3 position) {
  vec3 p = toSensor(loaded.instance, position);
  return INSIDE == kInsideExact ? onLattice(p) : p;
}

bool isDeformable(LoadedCluster loaded) { return DEFORMED != kDeformsNothing && isDeformable(loaded.deformer); }

vec3 toSensor(LoadedCluster loaded, uint number) {
  uint vertex = loaded.vertexFirst + number;
  if (!isDeformable(loaded)) return toSensor(loaded, positions.at[vertex]);
  vec3 position = deformedPosition(loaded.deformer, loaded.cluster, vertex, false);
  if (DEFORMED == kDeformsAndStores) positions.at[vertex] = position;
  return toSensor(loaded, position);
}

bool haveRoom(uint vertexCount) { return vertexCount <= kVertexRounds * gl_SubgroupSize; }

uint vertexNumber(LoadedCluster loaded, uint round) {
  return min(round * gl_SubgroupSize + gl_SubgroupInvocationID, loaded.vertexCount - 1);
}

// Deforms the vertices of a cluster as deformedPosition() does, and transforms them. Each lane loads the map of a bone,
// and the others get it by shuffle.
void deformVertices(LoadedCluster loaded, inout Vertices vertices) {
  vec3 position[kMostVertexRounds], sum[kMostVertexRounds];
  [[unroll]] for (uint k = 0; k < kVertexRounds; ++k) {
    if (k * gl_SubgroupSize < loaded.vertexCount)
      position[k] = morphedPosition(loaded.deformer, loaded.vertexFirst + vertexNumber(loaded, k), false);
    sum[k] = vec3(0.0);
  }
  if (followsJoints(loaded.deformer, false)) {
    ClusterBones own = bonesOf(loaded.deformer, loaded.cluster);
    for (uint first = 0; first < own.count; first += gl_SubgroupSize) {
      uint bone = bones.at[own.first + min(first + gl_SubgroupInvocationID, own.count - 1)];
      uint row = loaded.deformer.rowFirst + 3 * jointOf(bone);
      vec4 x = jointRows.at[row], y = jointRows.at[row + 1], z = jointRows.at[row + 2];
      for (uint i = 0; i < own.influences; ++i) {
        [[unroll]] for (uint k = 0; k < kVertexRounds; ++k)
          if (k * gl_SubgroupSize < loaded.vertexCount) {
            uint weight = boneWeights.at[own.weightFirst + vertexNumber(loaded, k) * own.influences + i];
            uint lane = boneOf(weight) - first;
            bool here = lane < gl_SubgroupSize;
            lane &= gl_SubgroupSize - 1;
            vec4 toldX = subgroupShuffle(x, lane), toldY = subgroupShuffle(y, lane), toldZ = subgroupShuffle(z, lane);
            sum[k] = withShare(sum[k], through(toldX, toldY, toldZ, position[k]), here ? shareOf(weight) : 0.0);
          }
      }
    }
    [[unroll]] for (uint k = 0; k < kVertexRounds; ++k) position[k] = sum[k];
  }
  [[unroll]] for (uint k = 0; k < kVertexRounds; ++k)
    if (k * gl_SubgroupSize < loaded.vertexCount) {
      if (DEFORMED == kDeformsAndStores) positions.at[loaded.vertexFirst + vertexNumber(loaded, k)] = position[k];
      vertices.corners[k] = toSensor(loaded, position[k]);
    }
}

// Returns the vertex of a round of a cluster that is not deformed. The loop over rounds stands in each caller: in a
// function with inout Vertices, Intel's compiler takes 14 % more instructions and twice the spills.
vec3 loadedVertex(LoadedCluster loaded, uint round) {
  return toSensor(loaded, positions.at[loaded.vertexFirst + vertexNumber(loaded, round)]);
}

Vertices verticesOf(LoadedCluster loaded) {
  Vertices vertices;
  vertices.count = loaded.vertexCount;
  if (!haveRoom(vertices.count)) return vertices;
  if (isDeformable(loaded)) {
    deformVertices(loaded, vertices);
  } else {
    [[unroll]] for (uint k = 0; k < kVertexRounds; ++k)
      if (k * gl_SubgroupSize < vertices.count) vertices.corners[k] = loadedVertex(loaded, k);
  }
  return vertices;
}

vec3 cornerOf(Vertices vertices, uint number) {
  uint lane = number & (gl_SubgroupSize - 1), round = number / gl_SubgroupSize;
  vec3 corner = subgroupShuffle(vertices.corners[0], lane);
  [[unroll]] for (uint k = 1; k < kVertexRounds; ++k)
    if (k * gl_SubgroupSize < vertices.count) {
      vec3 other = subgroupShuffle(vertices.corners[k], lane);
      corner = round == k ? other : corner;
    }
  return corner;
}

// The vertex numbers of a triangle's corners. A mirroring instance reverses the winding, so its last two corners are
// swapped.
uvec3 numbersOf(LoadedCluster loaded, uint packed) {
  bool mirrored = mirrors(loaded.instance);
  return uvec3(packed, packed >> (mirrored ? 16 : 8), packed >> (mirrored ? 8 : 16)) & 0xff;
}

// All lanes of the subgroup must call this.
mat3 cornersOf(LoadedCluster loaded, Vertices vertices, uvec3 numbers) {
  if (haveRoom(vertices.count))
    return mat3(cornerOf(vertices, numbers.x), cornerOf(vertices, numbers.y), cornerOf(vertices, numbers.z));
  return mat3(toSensor(loaded, numbers.x), toSensor(loaded, numbers.y), toSensor(loaded, numbers.z));
}
