// SPDX-License-Identifier: Apache-2.0
// A cluster and the corners of its triangles in the sensor's frame. Each vertex is loaded once, by one lane, and told to
// those whose triangles have it: a software device pays for every lane's load, and a shuffle is one instruction.

// Where a cluster is: its instance and itself, loaded by one lane for all of them.
struct Place {
  Instance instance;
  uint vertexFirst, vertexCount, triangleFirst, triangleCount;
  bool doubleSided;
  uint material;  // only with a footprint
  uint number;  // its number; only with motion
};

Place placeOf(uint i) {
  Place place;
  place.material = 0;
  float vertices, triangles;
  if (gl_SubgroupInvocationID == 0) {
    uvec2 pair = visible[i];
    place.instance = instances[pair.x];
    place.number = pair.x;
    vertices = clusters[pair.y].low.w;
    triangles = clusters[pair.y].high.w;
#ifdef FOOTPRINT
    place.material = clusterMaterials[pair.y];
#endif
  }
  place.material = subgroupBroadcast(place.material, 0);
  place.number = subgroupBroadcast(place.number, 0);
  place.instance = fromFirstLane(place.instance);
  uint word = floatBitsToUint(subgroupBroadcast(vertices, 0));
  place.vertexFirst = word & (kChunkVertices - 1);
  place.vertexCount = word >> 25;
  word = floatBitsToUint(subgroupBroadcast(triangles, 0));
  place.triangleFirst = word & (kChunkTriangles - 1);
  place.triangleCount = word >> 24 & 127;
  place.doubleSided = (word >> 31) != 0;
  return place;
}

// Vertices lane, lane + subgroup size, ... of a cluster; none if it has more than there is room for. Of towns a tenth has
// more than 6 times 8.
const uint kVertexRounds = 6;
struct Vertices {
  vec3 at[kVertexRounds];
  uint count;
};

vec3 toSensor(Place place, uint vertex) {
  vec3 p = toSensor(place.instance, positions[place.vertexFirst + vertex]);
  return INSIDE == kInsideExact ? snapToLattice(p) : p;
}

bool haveRoom(uint vertexCount) { return vertexCount <= kVertexRounds * gl_SubgroupSize; }

Vertices verticesOf(Place place) {
  Vertices vertices;
  vertices.count = place.vertexCount;
  if (haveRoom(vertices.count)) {
    [[unroll]] for (uint k = 0; k < kVertexRounds; ++k)
      if (k * gl_SubgroupSize < vertices.count)
        vertices.at[k] = toSensor(place, min(k * gl_SubgroupSize + gl_SubgroupInvocationID, vertices.count - 1));
  }
  return vertices;
}

vec3 cornerOf(Vertices vertices, uint number) {
  uint lane = number & (gl_SubgroupSize - 1), round = number / gl_SubgroupSize;
  vec3 corner = subgroupShuffle(vertices.at[0], lane);
  [[unroll]] for (uint k = 1; k < kVertexRounds; ++k)
    if (k * gl_SubgroupSize < vertices.count) {
      vec3 other = subgroupShuffle(vertices.at[k], lane);
      corner = round == k ? other : corner;
    }
  return corner;
}

// The numbers of a triangle's corners, those of a mirroring instance swapped back to their winding.
uvec3 numbersOf(Place place, uint packed) {
  bool mirrored = mirrors(place.instance);
  return uvec3(packed, packed >> (mirrored ? 16 : 8), packed >> (mirrored ? 8 : 16)) & 0xff;
}

// Every lane must ask.
mat3 cornersOf(Place place, Vertices vertices, uvec3 numbers) {
  if (haveRoom(vertices.count))
    return mat3(cornerOf(vertices, numbers.x), cornerOf(vertices, numbers.y), cornerOf(vertices, numbers.z));
  return mat3(toSensor(place, numbers.x), toSensor(place, numbers.y), toSensor(place, numbers.z));
}
