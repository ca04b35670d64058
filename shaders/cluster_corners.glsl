// SPDX-License-Identifier: Apache-2.0
// Loads a cluster and transforms the corners of its triangles to the sensor's frame. One lane loads each vertex and
// the others get it by shuffle: a software device pays for every lane's load, and a shuffle is one instruction.

// A cluster and its instance, loaded by the first lane and broadcast.
struct LoadedCluster {
  Instance instance;
  uint vertexFirst, vertexCount, triangleFirst, triangleCount;
  uint doubleSided;
  uint material;
  uint number;  // number of the instance
  uint mesh;    // the mesh of the instance if it is deformable, otherwise kNone
  vec2 bound;   // InstanceMotion::bound; only with motion
};

LoadedCluster loadCluster(uint i) {
  LoadedCluster loaded;
  if (gl_SubgroupInvocationID == 0) {
    uvec2 pair = visible.at[i];
    loaded.instance = instances.at[pair.x];
    loaded.number = pair.x;
    loaded.bound = boundOf(pair.x);
    loaded.vertexFirst = clusters.at[pair.y].vertexFirst;
    loaded.triangleFirst = clusters.at[pair.y].triangleFirst;
    loaded.vertexCount = clusters.at[pair.y].vertexCount;
    loaded.triangleCount = clusters.at[pair.y].triangleCount;
    loaded.doubleSided = clusters.at[pair.y].doubleSided;
    loaded.material = clusters.at[pair.y].material;
  }
  loaded.material = subgroupBroadcast(loaded.material, 0);
  loaded.number = subgroupBroadcast(loaded.number, 0);
  loaded.mesh = deformableMesh(loaded.number);
  if (MOTION) loaded.bound = subgroupBroadcast(loaded.bound, 0);
  loaded.instance = fromFirstLane(loaded.instance);
  loaded.vertexFirst = subgroupBroadcast(loaded.vertexFirst, 0);
  loaded.triangleFirst = subgroupBroadcast(loaded.triangleFirst, 0);
  loaded.vertexCount = subgroupBroadcast(loaded.vertexCount, 0);
  loaded.triangleCount = subgroupBroadcast(loaded.triangleCount, 0);
  loaded.doubleSided = subgroupBroadcast(loaded.doubleSided, 0);
  return loaded;
}

// Holds vertices lane, lane + subgroup size, ... of a cluster, or nothing if the cluster has too many for
// kVertexRounds. In town scenes a tenth of the clusters has more than 6 times 8 vertices.
const uint kVertexRounds = 6;
struct Vertices {
  vec3 corners[kVertexRounds];
  uint count;
};

// Later kernels read the positions of deformed vertices, so these are stored.
vec3 positionOf(LoadedCluster loaded, uint vertex) {
  if (loaded.mesh == kNone) return positions.at[vertex];
  vec3 position = deformedPosition(loaded.mesh, vertex, false);
  positions.at[vertex] = position;
  return position;
}

vec3 toSensor(LoadedCluster loaded, uint vertex) {
  vec3 p = toSensor(loaded.instance, positionOf(loaded, loaded.vertexFirst + vertex));
  return INSIDE == kInsideExact ? onLattice(p) : p;
}

bool haveRoom(uint vertexCount) { return vertexCount <= kVertexRounds * gl_SubgroupSize; }

Vertices verticesOf(LoadedCluster loaded) {
  Vertices vertices;
  vertices.count = loaded.vertexCount;
  if (haveRoom(vertices.count)) {
    [[unroll]] for (uint k = 0; k < kVertexRounds; ++k)
      if (k * gl_SubgroupSize < vertices.count)
        vertices.corners[k] = toSensor(loaded, min(k * gl_SubgroupSize + gl_SubgroupInvocationID, vertices.count - 1));
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
