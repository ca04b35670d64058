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

mat3 velocitiesOf(uint slot) {
  return mat3(projectedMotions.at[3 * slot].xyz, projectedMotions.at[3 * slot + 1].xyz,
              projectedMotions.at[3 * slot + 2].xyz);
}

Triangle seenAt(Triangle triangle, uint slot, ColumnMotion at) {
  mat3 velocities = mat3(0.0);
  if (triangle.moves) velocities = velocitiesOf(slot);
  return seenAt(triangle, velocities, at);
}

// Transforms the triangle to the frame of the sensor when the beam in a column of a row fires.
Triangle seenFrom(Triangle triangle, uint slot, uint row, uint column) {
  if (!MOTION || atRest(triangle.moves)) return triangle;
  return seenAt(triangle, slot, columnMotionOf(row, column));
}

// True if the inside test needs only the corners turned to the beam. Lasers away from the origin then shift those,
// which is cheaper: a laser's origin turns with the beam.
#define SHIFTS_TURNED (INSIDE == kInsideWatertight && RANGE == kRangeEdgeWeights)

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

// True if a kernel has computed the frame of every beam, which replaces the transformation of a triangle to the frame of
// the sensor, the turn to the beam's azimuth and the shift to its laser.
#define BEAM_FRAMES (TIMED && INSIDE == kInsideWatertight && RANGE == kRangeEdgeWeights)

// Moves the corners of a triangle to their positions so many seconds after the start of the scan.
Triangle movedUntil(float seconds, Triangle triangle, mat3 velocities) {
  precise vec3 a = triangle.a + velocities[0] * seconds;
  precise vec3 b = triangle.b + velocities[1] * seconds;
  precise vec3 c = triangle.c + velocities[2] * seconds;
  triangle.a = a;
  triangle.b = b;
  triangle.c = c;
  return triangle;
}

// Returns the coordinates of the corners along an axis of a beam's frame.
vec3 cornersAlong(vec4 axis, Triangle triangle) {
  vec3 x = vec3(triangle.a.x, triangle.b.x, triangle.c.x), y = vec3(triangle.a.y, triangle.b.y, triangle.c.y),
       z = vec3(triangle.a.z, triangle.b.z, triangle.c.z);
  precise vec3 result = axis.x * x + axis.y * y + axis.z * z + axis.w;
  return result;
}

Turned shifted(Turned turned, vec3 laser) {
  precise Turned result = Turned(turned.p - laser.x, turned.q - laser.y, turned.z - laser.z);
  return result;
}

// Turns a triangle that seenFrom() has returned to a beam of the row.
Turned turnedFrom(Triangle seen, uint row, uint index, vec2 azimuth) {
  if (BEAM_FRAMES && ((EFFECTS & kFootprint) != 0 || !atRest(seen.moves))) {
    BeamFrame of = loadedBeamFrame(beamEntry(index));
    return Turned(cornersAlong(of.forward, seen), cornersAlong(of.left, seen), cornersAlong(of.up, seen));
  }
  Turned turned = turn(seen, azimuth);
  if (ORIGINS && SHIFTS_TURNED) turned = shifted(turned, laserOf(row));
  return turned;
}

// Returns a triangle for turnedFrom(). Where each beam has a frame, only a triangle that moves changes.
Triangle seenFrom(Triangle triangle, uint slot, uint column, uint row, vec2 azimuth) {
  if (BEAM_FRAMES) {
    if (!triangle.moves) return triangle;
    return movedUntil(columnMotionOf(row, column).velocity.w, triangle, velocitiesOf(slot));
  }
  return seenFrom(seenFrom(triangle, slot, row, column), row, azimuth);
}
