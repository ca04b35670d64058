// SPDX-License-Identifier: Apache-2.0
// Finds the columns of a row whose beams may hit a small triangle. With the azimuth as abscissa and the tangent of the
// elevation as ordinate, a great circle is a sine curve: its second derivative is its negative ordinate. So an edge
// that spans d radians of azimuth is off its chord by at most d^2 / 8 times the largest tangent, and the triangle lies
// within the plane triangle of its corners, widened by so much.

// The corners of a triangle as the sensor sees them: one component per corner.
struct Silhouette {
  bool known;               // if not, the beams of all columns may hit
  vec3 across, up;          // columns from the box's columnMin, and tangents of the elevation
  float slackAcross, slackUp;
  vec3 acrossDrift, upDrift;  // by so much the corners lie elsewhere for a row that fires a column earlier
};

Silhouette noSilhouette() { return Silhouette(false, vec3(0.0), vec3(0.0), 0.0, 0.0, vec3(0.0), vec3(0.0)); }

// Returns the silhouette as the beams of a row see it, which may fire earlier or later than the columns of their places.
Silhouette seenByRow(Silhouette s, uint row) {
  if (!(MOTION && STAGGERED)) return s;
  Row of = loadedRow(row);
  float early = float(of.first) + of.behind - (of.lag - float(frame.momentsBefore));
  s.across -= s.acrossDrift * early;
  s.up -= s.upDrift * early;
  return s;
}

// Returns the silhouette of a triangle that spans at most a tenth of a radian and lies within 56 degrees of the
// horizon. The silhouette of any other triangle is not known. No silhouette is known where the cells of a grid hold the
// beams of a list. With motion the triangle is as a column near the box sees it, and seems elsewhere to the others.
Silhouette silhouetteOf(Triangle triangle, Prepared prepared, Box box) {
  Silhouette result = noSilhouette();
  if (BOUNDS != kBoundsExact || LISTED) return result;
  vec3 a = triangle.a, b = triangle.b, c = triangle.c;
  result.up = vec3(a.z, b.z, c.z) / vec3(length(a.xy), length(b.xy), length(c.xy));
  float steepest = max(max(abs(result.up.x), abs(result.up.y)), abs(result.up.z));
  vec2 along = vec2(dot(a.xy, b.xy), dot(a.xy, c.xy));
  // The arc tangent by two terms of its series; below 0.1 the third one is less than 2e-6.
  vec2 tangent = vec2(a.x * b.y - a.y * b.x, a.x * c.y - a.y * c.x) / along;
  vec2 angle = tangent - tangent * tangent * tangent * (1.0 / 3.0);
  float span = max(max(angle.x, angle.y), 0.0) - min(min(angle.x, angle.y), 0.0);
  result.known = max(abs(tangent.x), abs(tangent.y)) < 0.1 && min(along.x, along.y) > 0.0 && steepest < 1.5 &&
                 boxColumnCount(box) < frame.columns;
  float blur = blurOf(prepared, vec3(length(a), length(b), length(c)));
  // The derivative of the tangent by the elevation key is (1 + tangent)^2.
  float slope = (1.1 + steepest) * (1.1 + steepest), key = steepest / (1.0 + steepest);
  result.slackUp = slope * (kKeySlack + blur + seemingUp) + 0.14 * span * span * steepest;
  float start = columnAt(azimuthOf(a.y, a.x)) - box.columnMin, turnColumns = float(frame.columns);
  if (MOTION) start -= floor(start / turnColumns + 0.25) * turnColumns;  // the box may lie a turn away
  result.across = vec3(start, start + angle.x * frame.columnsPerRadian, start + angle.y * frame.columnsPerRadian);
  // The difference of two column numbers is rounded; the arc tangent's third term adds to that.
  result.slackAcross = columnSlack(-key, key) + 5e-7 * float(frame.columns) +
                       (1.1 * blur / (1.0 - key) + 2e-6) * frame.columnsPerRadian;
  return result;
}

// Estimates by the triangle's area how many steps a walk over the beams that may hit takes. Each row takes at least one
// step.
float walkLength(Silhouette s, Box box) {
  float rowCount = float(boxRowCount(box));
  if (!s.known) return rowCount * float(boxColumnCount(box));
  vec3 up = s.up - s.up.x, across = s.across - s.across.x;
  float area = 0.5 * abs(across.y * up.z - across.z * up.y);
  float height = max(max(up.y, up.z), 0.0) - min(min(up.y, up.z), 0.0) + 2.0 * s.slackUp;
  return rowCount * (1.0 + area / height);
}

// Returns the first and the last place between which beams with this tangent of the elevation may hit, in columns from
// the box's columnMin. If no beam may hit, the first place is behind the last.
vec2 columnsBetween(Silhouette s, float tangent) {
  vec3 inverse = vec3(1.0) / notZero(s.up.yzx - s.up), from = vec3(tangent) - s.up;
  // t0..t1 is the part of each edge that lies within the slack.
  vec3 ta = (from - s.slackUp) * inverse, tb = (from + s.slackUp) * inverse;
  vec3 t0 = max(min(ta, tb), vec3(0.0)), t1 = min(max(ta, tb), vec3(1.0));
  vec3 along = s.across.yzx - s.across, x0 = s.across + along * t0, x1 = s.across + along * t1;
  bvec3 there = lessThanEqual(t0, t1);
  vec3 low = mix(vec3(1e9), min(x0, x1), there), high = mix(vec3(-1e9), max(x0, x1), there);
  return vec2(min(min(low.x, low.y), low.z) - s.slackAcross, max(max(high.x, high.y), high.z) + s.slackAcross);
}
