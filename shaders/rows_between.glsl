// SPDX-License-Identifier: Apache-2.0
// Finds the rows whose beams between two columns may hit a triangle. The half-planes of the two azimuths cut a wedge
// out of the triangle; the highest and lowest points of the wedge lie on the triangle's clipped edges.

// Returns the angle by which a beam can miss a triangle and still count as a hit.
float blurOf(Prepared prepared, vec3 far) {
  float blur = 2e-6 + 1.001 * (SPREADS ? frame.footprint : 0.0);
  // The normal of an edge, a x b, has an error of 1e-7 |a| |b|, which tilts it by that error divided by its length.
  if (INSIDE == kInsidePlain) {
    vec3 sizes = vec3(length(prepared.normals.bc), length(prepared.normals.ca), length(prepared.normals.ab));
    vec3 tilts = far.yzx * far.zxy / max(sizes, vec3(1e-30));
    blur += 1e-6 * max(max(tilts.x, tilts.y), tilts.z);
  }
  return blur;
}

vec3 notZero(vec3 v) { return mix(v, vec3(1e-30), lessThan(abs(v), vec3(1e-30))); }

// Computes the elevation keys between the columns `from` and `to`, where `to` is to the left by less than a quarter
// turn; both sides are widened by `slack` metres. Horizontal distances are measured along `from`; the caller adds a
// quarter of the squared angle, which covers this and the bulge of an edge between the columns. keyMin > keyMax if no
// part of the triangle lies in the wedge. If part of it is not in front of the sensor, all keys are returned.
void keysBetween(Turned from, Turned to, float slack, out float keyMin, out float keyMax) {
  // t0..t1 is the part of each edge that lies left of `from` and right of `to`.
  vec3 d = notZero(from.q.yzx - from.q), e = notZero(to.q.yzx - to.q);
  vec3 td = (-slack - from.q) / d, te = (slack - to.q) / e;
  bvec3 rising = greaterThan(d, vec3(0.0)), falling = lessThan(e, vec3(0.0));
  vec3 t0 = max(max(mix(vec3(0.0), td, rising), mix(vec3(0.0), te, falling)), vec3(0.0));
  vec3 t1 = min(min(mix(td, vec3(1.0), rising), mix(te, vec3(1.0), falling)), vec3(1.0));
  bvec3 there = lessThanEqual(t0, t1);
  vec3 along = from.p.yzx - from.p, up = from.z.yzx - from.z;
  vec3 p0 = from.p + along * t0, p1 = from.p + along * t1;
  vec3 z0 = from.z + up * t0, z1 = from.z + up * t1;
  // A point so close to the axis that the slack extends behind the axis ends at a pole, unless it is close to the
  // sensor.
  vec3 k0 = z0 / (abs(z0) + max(p0, vec3(0.0))), k1 = z1 / (abs(z1) + max(p1, vec3(0.0)));
  vec3 low = mix(vec3(2.0), min(k0, k1), there), high = mix(vec3(-2.0), max(k0, k1), there);
  vec3 front = mix(vec3(1.0), max(min(p0, p1), z0 * z1), there);
  bool behind = !(min(min(front.x, front.y), front.z) > 0.0);
  keyMin = behind ? -1.0 : min(min(low.x, low.y), low.z);
  keyMax = behind ? 1.0 : max(max(high.x, high.y), high.z);
}
