// SPDX-License-Identifier: Apache-2.0
// Equation 2 of the paper: a beam is inside if it lies on the same side of the three planes through the sensor and an
// edge. The test is the cheapest, but not watertight: the normals a x b lose a factor |a||b| / |a - b| in
// precision.

struct EdgeNormals {
  vec3 ab, bc, ca;
};

EdgeNormals edgeNormals(Triangle triangle) {
  return EdgeNormals(cross(triangle.a, triangle.b), cross(triangle.b, triangle.c), cross(triangle.c, triangle.a));
}

// Returns on which side of the edges opposite to a, b and c the beam lies.
vec3 plainSides(EdgeNormals normals, vec3 beam) {
  return vec3(dot(normals.bc, beam), dot(normals.ca, beam), dot(normals.ab, beam));
}

// The supporting plane of equation 3: unit normal in xyz, n . v0 in w.
vec4 supportingPlane(Triangle triangle) {
  vec3 normal = normalize(cross(triangle.b - triangle.a, triangle.c - triangle.a));
  return vec4(normal, dot(normal, triangle.a));
}
