// SPDX-License-Identifier: Apache-2.0
// Matrices and vectors in single precision. The order of operations matters: results are compared bit by bit.
#pragma once

#include <rgl/api/core.h>

#include <algorithm>
#include <cmath>

namespace gnosphere::rgl {

struct Vec {
  float x = 0, y = 0, z = 0;

  friend Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec operator*(const Vec& a, float s) { return {a.x * s, a.y * s, a.z * s}; }
  friend bool operator==(const Vec& a, const Vec& b) = default;
};

inline float dot(const Vec& a, const Vec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(const Vec& a) {
  return std::sqrt(dot(a, a));
}
inline Vec unit(const Vec& a) {
  const float norm = length(a);
  return {a.x / norm, a.y / norm, a.z / norm};
}

/// An affine map, row-major; column 3 is the translation.
struct Mat {
  float m[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

  Vec translation() const { return {m[0][3], m[1][3], m[2][3]}; }
  /// Maps a direction: without the translation.
  Vec turn(const Vec& v) const {
    return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
            m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
  }
  friend Vec operator*(const Mat& a, const Vec& v) { return a.turn(v) + a.translation(); }
  friend Mat operator*(const Mat& a, const Mat& b) {
    Mat c;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) {
        c.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j];
        if (j == 3) c.m[i][j] += a.m[i][3];
      }
    return c;
  }
  friend bool operator==(const Mat& a, const Mat& b) {
    for (int i = 0; i < 12; ++i)
      if (a.m[i / 4][i % 4] != b.m[i / 4][i % 4]) return false;
    return true;
  }
};
static_assert(sizeof(Mat) == sizeof(rgl_mat3x4f) && sizeof(Vec) == sizeof(rgl_vec3f));

inline bool isFinite(const rgl_mat3x4f& matrix) {
  return std::all_of(&matrix.value[0][0], &matrix.value[0][0] + 12, [](float value) { return std::isfinite(value); });
}

inline Mat matOf(const rgl_mat3x4f& from) {
  Mat to;
  for (int i = 0; i < 12; ++i) to.m[i / 4][i % 4] = from.value[i / 4][i % 4];
  return to;
}

/// Turns by Euler angles: about x, then y, then z (radians).
inline Mat rotation(const Vec& angles) {
  const float cx = std::cos(angles.x), sx = std::sin(angles.x), cy = std::cos(angles.y), sy = std::sin(angles.y),
              cz = std::cos(angles.z), sz = std::sin(angles.z);
  return {{{cy * cz, sx * sy * cz - cx * sz, sx * sz + cx * sy * cz, 0},
           {cy * sz, cx * cz + sx * sy * sz, cx * sy * sz - sx * cz, 0},
           {-sy, sx * cy, cx * cy, 0}}};
}

inline Mat rotation(rgl_axis_t axis, float angle) {
  return rotation({axis == RGL_AXIS_X ? angle : 0, axis == RGL_AXIS_Y ? angle : 0, axis == RGL_AXIS_Z ? angle : 0});
}

/// The inverse of a map; all zeros if it has none.
inline Mat inverse(const Mat& a) {
  double r[3][3], det = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      r[j][i] = double{a.m[i1][j1]} * a.m[i2][j2] - double{a.m[i1][j2]} * a.m[i2][j1];
    }
  for (int j = 0; j < 3; ++j) det += a.m[0][j] * r[j][0];
  Mat result{{{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}}};
  if (det == 0) return result;
  for (int i = 0; i < 3; ++i) {
    double shift = 0;
    for (int j = 0; j < 3; ++j) {
      result.m[i][j] = static_cast<float>(r[i][j] / det);
      shift -= r[i][j] / det * a.m[j][3];
    }
    result.m[i][3] = static_cast<float>(shift);
  }
  return result;
}

/// The scale of a map that turns, moves and scales alike in all directions, within rounding; 0 for any other map.
inline double scaleOf(const Mat& a) {
  double products[3][3] = {}, det = 0;  // of the columns
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) products[i][j] += double{a.m[k][i]} * a.m[k][j];
  const double square = (products[0][0] + products[1][1] + products[2][2]) / 3;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(products[i][j] - (i == j ? square : 0)) <= 2e-6 * square)) return 0;
  for (int j = 0; j < 3; ++j)
    det += a.m[0][j] *
           (double{a.m[1][(j + 1) % 3]} * a.m[2][(j + 2) % 3] - double{a.m[1][(j + 2) % 3]} * a.m[2][(j + 1) % 3]);
  return det > 0 ? std::sqrt(square) : 0;
}

/// The map with its matrix divided by a scale; its translation stays.
inline Mat withoutScale(Mat a, float scale) {
  for (auto& row : a.m)
    for (int j = 0; j < 3; ++j) row[j] /= scale;
  return a;
}

}  // namespace gnosphere::rgl
