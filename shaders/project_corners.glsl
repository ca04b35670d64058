// SPDX-License-Identifier: Apache-2.0
// The corners of a cluster's triangles in the sensor's frame. Each vertex is loaded once, by one lane, and told to those
// whose triangles have it: a software device pays for every lane's load, and a shuffle is one instruction.

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
