// SPDX-License-Identifier: Apache-2.0
// Makes, measures and compares affine maps in double precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/quaternion.hpp"
#include "base/vector.hpp"
#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Composes translation * rotation * scale. The quaternion may have any length, because it may be quantised.
inline Transform composed(const Vec3& t, const Quaternion& rotation, const Vec3& s) {
  const Quaternion q = withUsableLength(rotation);
  const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  const double k = norm > 0 ? 2 / norm : 0;
  return {{(1 - k * (q.y * q.y + q.z * q.z)) * s.x, k * (q.x * q.y - q.z * q.w) * s.y,
           k * (q.x * q.z + q.y * q.w) * s.z, t.x,  //
           k * (q.x * q.y + q.z * q.w) * s.x, (1 - k * (q.x * q.x + q.z * q.z)) * s.y,
           k * (q.y * q.z - q.x * q.w) * s.z, t.y,  //
           k * (q.x * q.z - q.y * q.w) * s.x, k * (q.y * q.z + q.x * q.w) * s.y,
           (1 - k * (q.x * q.x + q.y * q.y)) * s.z, t.z}};
}

/// Factor by which the error of matrix * (x - pivot) may exceed that of a rotation, at a given distance of the result.
/// Rounding is relative to each column's contribution, so scaling along the mesh's own axes is harmless, and only the
/// angles between columns count: with unit columns in B it is |B| |B^-1| / 3 in Frobenius norms, 1 for a rotation.
inline double conditionOf(const Transform& t) {
  Vec3 columns[3];
  int empty = -1, emptyCount = 0;
  for (int k = 0; k < 3; ++k) {
    columns[k] = {t.rows[k], t.rows[4 + k], t.rows[8 + k]};
    const double length = lengthOf(columns[k]);
    if (length > 0) {
      columns[k] = (1 / length) * columns[k];
    } else {
      empty = k;
      ++emptyCount;
    }
  }
  if (emptyCount > 1) return 1;  // a line or a point, which cannot be hit
  if (emptyCount == 1) {         // a flattened mesh: the missing column adds no error
    const Vec3 n = cross(columns[(empty + 1) % 3], columns[(empty + 2) % 3]);
    columns[empty] = (1 / std::max(lengthOf(n), 1e-30)) * n;
  }
  double squares = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 row = cross(columns[(k + 1) % 3], columns[(k + 2) % 3]);
    squares += dot(row, row);
  }
  const double volume = std::abs(dot(columns[0], cross(columns[1], columns[2])));
  return std::max(std::sqrt(squares / 3) / std::max(volume, 1e-30), 1.0);
}

/// Returns whether two poses have the same bits.
inline bool samePose(const Pose& a, const Pose& b) {
  return std::memcmp(&a, &b, sizeof(Pose)) == 0;
}

/// Determinant of the linear part of a transform.
inline double determinant(const Transform& transform) {
  const auto& m = transform.rows;
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/// The inverse of a map whose determinant is not 0.
inline Transform inverse(const Transform& map) {
  const auto& m = map.rows;
  const double c0 = m[5] * m[10] - m[6] * m[9], c1 = m[6] * m[8] - m[4] * m[10], c2 = m[4] * m[9] - m[5] * m[8];
  const double scale = 1 / (m[0] * c0 + m[1] * c1 + m[2] * c2);
  Transform r = {{scale * c0, scale * (m[2] * m[9] - m[1] * m[10]), scale * (m[1] * m[6] - m[2] * m[5]), 0,  //
                  scale * c1, scale * (m[0] * m[10] - m[2] * m[8]), scale * (m[2] * m[4] - m[0] * m[6]), 0,  //
                  scale * c2, scale * (m[1] * m[8] - m[0] * m[9]), scale * (m[0] * m[5] - m[1] * m[4]), 0}};
  for (size_t row = 0; row < 12; row += 4)
    r.rows[row + 3] = -(r.rows[row] * m[3] + r.rows[row + 1] * m[7] + r.rows[row + 2] * m[11]);
  return r;
}

}  // namespace gnosphere
