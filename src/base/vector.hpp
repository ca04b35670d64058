// SPDX-License-Identifier: Apache-2.0
// Operations on vectors of doubles, which use only + - * and square roots, so they give the same bits on every machine.
#pragma once

#include <algorithm>
#include <cmath>

#include "gnosphere/scene.hpp"

namespace gnosphere {

inline Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(double s, const Vec3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline double dot(const Vec3& a, const Vec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline bool isFinite(const Vec3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
/// The least and the greatest coordinates of two points.
inline Vec3 lowest(const Vec3& a, const Vec3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
inline Vec3 highest(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
/// Lengths are no job for std::hypot(), which C libraries round in one way on arm64 and in another on x86-64.
inline double lengthOf(const Vec3& a) {
  return std::sqrt(dot(a, a));
}
inline double lengthOf(double x, double y) {
  return std::sqrt(x * x + y * y);
}

}  // namespace gnosphere
