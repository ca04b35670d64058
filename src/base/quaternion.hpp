// SPDX-License-Identifier: Apache-2.0
// Operations on quaternions, which use only + - * / and square roots, so they give the same bits on every machine.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/vector.hpp"
#include "gnosphere/scan.hpp"

namespace gnosphere {

/// The rotation `b` followed by the rotation `a`.
inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

/// Turns a vector by a quaternion.
inline Vec3 operator*(const Quaternion& q, const Vec3& v) {
  const Vec3 u = {q.x, q.y, q.z}, t = 2.0 * cross(u, v);
  return v + q.w * t + cross(u, t);
}

/// True for a quaternion of length 0, which has no direction.
inline bool isZero(const Quaternion& q) {
  return q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0;
}

/// Whether two quaternions are the same numbers; their bits may differ, as those of 0 and -0 do.
inline bool isSame(const Quaternion& a, const Quaternion& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w;
}

/// Returns a quaternion of the same direction whose squared length neither overflows nor underflows. Unless it is
/// extremely long or short, that is the quaternion itself, so that the usual ones keep their bits. One of length 0
/// stays.
inline Quaternion withUsableLength(const Quaternion& q) {
  const double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  if ((square > 1e-200 && square < 1e200) || isZero(q)) return q;
  const double largest = std::max({std::abs(q.x), std::abs(q.y), std::abs(q.z), std::abs(q.w)});
  return {q.x / largest, q.y / largest, q.z / largest, q.w / largest};
}

inline double normOf(const Quaternion& q) {
  return std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
}

inline Quaternion normalized(const Quaternion& q) {
  const double length = normOf(q);
  return {q.x / length, q.y / length, q.z / length, q.w / length};
}

/// Tolerance on the length of a quaternion of a file, because files have few digits; a larger deviation means that it
/// is no unit quaternion.
inline constexpr double kUnitTolerance = 0.01;

inline bool isUnit(const Quaternion& q) {
  return std::abs(normOf(q) - 1) < kUnitTolerance;
}

/// Returns a unit quaternion of the same direction, which is the quaternion itself if isUnit(); one of length 0 becomes
/// the identity.
inline Quaternion unitOf(const Quaternion& q) {
  return isZero(q) ? Quaternion{} : isUnit(q) ? q : normalized(withUsableLength(q));
}

}  // namespace gnosphere
