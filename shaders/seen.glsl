// SPDX-License-Identifier: Apache-2.0
// Transforms a projected triangle to the frame of a laser of a moving sensor.

// Transforms the triangle to the frame of the sensor at a time. Corners of a triangle that moves have velocities.
Triangle seenAt(Triangle triangle, mat3 velocities, ColumnMotion at) {
  if (triangle.moves) {
    triangle.a = inColumn(at, triangle.a, velocities[0]);
    triangle.b = inColumn(at, triangle.b, velocities[1]);
    triangle.c = inColumn(at, triangle.c, velocities[2]);
  } else {
    triangle.a = inColumn(at, triangle.a);
    triangle.b = inColumn(at, triangle.b);
    triangle.c = inColumn(at, triangle.c);
  }
  return triangle;
}

Triangle seenAt(Triangle triangle, uint slot, ColumnMotion at) {
  mat3 velocities = mat3(0.0);
  if (triangle.moves)
    velocities = mat3(projectedMotions.at[3 * slot].xyz, projectedMotions.at[3 * slot + 1].xyz,
                      projectedMotions.at[3 * slot + 2].xyz);
  return seenAt(triangle, velocities, at);
}

// Transforms the triangle to the frame of the sensor when the beam in a column of a row fires.
Triangle seenFrom(Triangle triangle, uint slot, uint row, uint column) {
  if (!MOTION || atRest(triangle.moves)) return triangle;
  return seenAt(triangle, slot, columnMotionOf(row, column));
}

// True if the inside test needs only the corners turned to the beam. Lasers away from the origin then shift those,
// which is cheaper: a laser's origin turns with the beam.
#define SHIFTS_TURNED (INSIDE == kInsideWatertight && RANGE == kRangeEdgeWeights && (EFFECTS & kFootprint) == 0)

Triangle seenFromPoint(Triangle triangle, vec3 origin) {
  triangle.a -= origin;
  triangle.b -= origin;
  triangle.c -= origin;
  return triangle;
}

// Moves the origin to the position of the row's laser in its head, unless turnedFrom() does.
Triangle seenFrom(Triangle triangle, uint row, vec2 azimuth) {
  if (!ORIGINS) return triangle;
  if (SHIFTS_TURNED) return triangle;
  return seenFromPoint(triangle, originOf(row, azimuth));
}

Turned shifted(Turned turned, vec3 laser) {
  precise Turned result = Turned(turned.p - laser.x, turned.q - laser.y, turned.z - laser.z);
  return result;
}

// Turns a triangle that seenFrom() has returned to a beam of the row.
Turned turnedFrom(Triangle seen, uint row, vec2 azimuth) {
  Turned turned = turn(seen, azimuth);
  if (ORIGINS && SHIFTS_TURNED) turned = shifted(turned, laserOf(row));
  return turned;
}

Triangle seenFrom(Triangle triangle, uint slot, uint column, uint row, vec2 azimuth) {
  return seenFrom(seenFrom(triangle, slot, row, column), row, azimuth);
}
