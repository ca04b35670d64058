// SPDX-License-Identifier: Apache-2.0
// The silhouettes of triangles that move relative to the sensor, for rows that fire at different times.

Silhouette silhouetteOf(Triangle triangle, mat3 corners, Box box) {
  triangle.a = corners[0];
  triangle.b = corners[1];
  triangle.c = corners[2];
  return silhouetteOf(triangle, prepare(triangle), box);
}

float largestOf(vec3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }

// Returns the silhouette of a triangle in one box for rows that fire at different times. Between the first and the last
// moment at which the beams of the box fire, each corner moves along a nearly straight line at nearly constant speed. So
// each row sees a corner at the point of this line where it is when the row fires, and needs no slack for the motion.
Silhouette driftingSilhouette(Triangle triangle, mat3 corners, Projected projected, Box box) {
  const float kRepays = 0.25;  // columns of slack; a head whose rows fire almost together has less
  float from = floor(box.columnMin - frame.shiftMax), to = ceil(box.columnMax - frame.shiftMin), moments = to - from;
  float before = float(frame.momentsBefore);
  bool within = from + before >= float(motion.bendFirst) && to + before < float(motion.bendEnd);
  // An apparent motion by the angle A is off a straight line by at most A^2 / 4, in azimuth or elevation, and at 56 degrees
  // of elevation by five times that. The motion between the two moments is up to twice `seemingMotion`.
  vec3 a = projected.seen[0], b = projected.seen[1], c = projected.seen[2];
  float farthest = max(max(length(a), length(b)), length(c)) + motion.shift;
  mat3 velocities = projected.velocities;
  float bend = bendWithin(moments, farthest, velocities);
  float off = 4.0 * seemingMotion * seemingMotion + seemingAngle(bend, 0.0, projected.b.w) + 2e-6;
  bool drifts = within && off < 0.5 * seemingMotion && seemingMotion < 0.02 &&
                seemingMotion * frame.columnsPerRadian > kRepays;
  if (drifts) {
    projected.seen = cornersAt(columnMotionOfPlace(from), corners, velocities);
    seemingAcross -= seemingMotion - off;
    seemingUp -= seemingMotion - off;
  }
  Silhouette result = silhouetteOf(triangle, projected.seen, box);
  if (!drifts) return result;
  Silhouette end = silhouetteOf(triangle, cornersAt(columnMotionOfPlace(to), corners, velocities), box);
  vec3 perMoment = (end.across - result.across) / moments, upPerMoment = (end.up - result.up) / moments;
  result.known = result.known && end.known && largestOf(perMoment) < 0.05;
  // A corner that moves by D columns per moment is seen in the column c in which it is when that column fires:
  // c = across + D (c - row's shift - from). The row's beams in the columns between two corners fire at other moments than
  // both. Such a beam sees the edge beside the line between the corners, by at most a quarter of the edge's length times the
  // difference of the corners' speeds.
  vec3 share = vec3(1.0) / (vec3(1.0) - perMoment);
  float start = box.columnMin - from, columns_ = spanOf(result.across) + 2.0 * result.slackAcross;
  result.across = (result.across + perMoment * start) * share;
  result.up += upPerMoment * (result.across + start);
  result.acrossDrift = perMoment * share;
  result.upDrift = upPerMoment * (result.acrossDrift + 1.0);
  // The first terms cover that the slack changes a little with the motion. The last terms cover that a beam may lie further
  // behind its place than the first beam of its row, or less far, by up to a column.
  result.slackUp = 1.1 * result.slackUp + 1e-6 + 0.25 * columns_ * spanOf(upPerMoment) +
                   largestOf(result.upDrift) * (1.5 + 2.0 * result.slackAcross);
  result.slackAcross = 1.1 * result.slackAcross + 1e-6 * float(frame.columns) + 0.25 * columns_ * spanOf(perMoment) +
                       1.5 * largestOf(result.acrossDrift);
  return result;
}
