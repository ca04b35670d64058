// SPDX-License-Identifier: Apache-2.0
// Operations on quaternions, which use only + - * / and square roots, so they give the same bits on every machine.
#pragma once

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

}  // namespace gnosphere
