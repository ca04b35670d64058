// SPDX-License-Identifier: Apache-2.0
// Which rows may meet a triangle between two columns? The half-planes of two azimuths cut a wedge out of it, whose
// highest and lowest points lie on its edges, clipped.

// The angle by which a beam may miss a triangle and be told to meet it.
float blurOf(Triangle triangle, Prepared prepared, vec3 far) {
  float blur = 2e-6 + 1.001 * footprint();
  // The normal of an edge, a x b, is off by 1e-7 |a| |b|: that tilts it by so much over its length.
  if (INSIDE == kInsidePlain) {
    vec3 sizes = vec3(length(prepared.normals.bc), length(prepared.normals.ca), length(prepared.normals.ab));
    vec3 tilts = far.yzx * far.zxy / max(sizes, vec3(1e-30));
    blur += 1e-6 * max(max(tilts.x, tilts.y), tilts.z);
  }
  return blur;
}

vec3 notZero(vec3 v) { return mix(v, vec3(1e-30), lessThan(abs(v), vec3(1e-30))); }

// The elevation keys between the columns of `from` and `to`, which lies to the left by less than a quarter turn; `slack`
// metres more on either side. Horizontal distances are taken along `from`: who asks widens by what that and the bulge of
// an edge between the columns make, a quarter of the angle squared. keyMin > keyMax where there is nothing. What is not
// in front of the sensor says nothing: then every key may be.
void keysBetween(Turned from, Turned to, float slack, out float keyMin, out float keyMax) {
  // Along each edge, left of `from` and right of `to`: t0..t1.
  vec3 d = notZero(from.q.yzx - from.q), e = notZero(to.q.yzx - to.q);
  vec3 td = (-slack - from.q) / d, te = (slack - to.q) / e;
  bvec3 rising = greaterThan(d, vec3(0.0)), falling = lessThan(e, vec3(0.0));
  vec3 t0 = max(max(mix(vec3(0.0), td, rising), mix(vec3(0.0), te, falling)), vec3(0.0));
  vec3 t1 = min(min(mix(td, vec3(1.0), rising), mix(te, vec3(1.0), falling)), vec3(1.0));
  bvec3 there = lessThanEqual(t0, t1);
  vec3 along = from.p.yzx - from.p, up = from.z.yzx - from.z;
  vec3 p0 = from.p + along * t0, p1 = from.p + along * t1;
  vec3 z0 = from.z + up * t0, z1 = from.z + up * t1;
  // What lies so near the axis that the slack lets it reach behind it ends at a pole; unless it lies near the sensor.
  vec3 k0 = z0 / (abs(z0) + max(p0, vec3(0.0))), k1 = z1 / (abs(z1) + max(p1, vec3(0.0)));
  vec3 low = mix(vec3(2.0), min(k0, k1), there), high = mix(vec3(-2.0), max(k0, k1), there);
  vec3 front = mix(vec3(1.0), max(min(p0, p1), z0 * z1), there);
  bool behind = !(min(min(front.x, front.y), front.z) > 0.0);
  keyMin = behind ? -1.0 : min(min(low.x, low.y), low.z);
  keyMax = behind ? 1.0 : max(max(high.x, high.y), high.z);
}
