// SPDX-License-Identifier: Apache-2.0
// Transforms a projected triangle to the frame of a laser of a moving sensor.

// Transforms the triangle to the column's frame, at the time when the column fires.
Triangle seenFrom(Triangle triangle, uint slot, uint column) {
  if (!triangle.moves && motion.sensor == 0) return triangle;
  ColumnMotion at = columnMotionOf(column);
  if (triangle.moves) {
    triangle.a = inColumn(at, triangle.a, projectedMotions.at[3 * slot].xyz);
    triangle.b = inColumn(at, triangle.b, projectedMotions.at[3 * slot + 1].xyz);
    triangle.c = inColumn(at, triangle.c, projectedMotions.at[3 * slot + 2].xyz);
  } else {
    triangle.a = inColumn(at, triangle.a);
    triangle.b = inColumn(at, triangle.b);
    triangle.c = inColumn(at, triangle.c);
  }
  return triangle;
}

// Moves the origin to the position of the row's laser in its head.
Triangle seenFrom(Triangle triangle, uint row, vec2 azimuth) {
  if (motion.origins == 0.0) return triangle;
  vec3 origin = originOf(row, azimuth);
  triangle.a -= origin;
  triangle.b -= origin;
  triangle.c -= origin;
  return triangle;
}

Triangle seenFrom(Triangle triangle, uint slot, uint column, uint row, vec2 azimuth) {
  return seenFrom(seenFrom(triangle, slot, column), row, azimuth);
}
