// SPDX-License-Identifier: Apache-2.0
// The triangle as the laser of a row sees it when a column fires.
Triangle seenFrom(Triangle triangle, uint slot, uint column, uint row, vec2 azimuth) {
  ColumnMotion at = columnMotions[column];
  mat3 velocities = mat3(0.0);
  if (motion.instances != 0)
    velocities = mat3(projectedMotions[3 * slot].xyz, projectedMotions[3 * slot + 1].xyz,
                      projectedMotions[3 * slot + 2].xyz);
  vec3 origin = motion.origins > 0.0 ? originOf(row, azimuth) : vec3(0.0);
  triangle.a = inColumn(at, triangle.a, velocities[0]) - origin;
  triangle.b = inColumn(at, triangle.b, velocities[1]) - origin;
  triangle.c = inColumn(at, triangle.c, velocities[2]) - origin;
  return triangle;
}
