// SPDX-License-Identifier: Apache-2.0
// Arithmetic of poses: composition, inverses, matrices.
#pragma once

#include <array>

#include "base/quaternion.hpp"

namespace gnosphere::drive {

/// The angle of the shorter turn from `a` to `b` in radians, 0..pi.
double angleBetween(const Quaternion& a, const Quaternion& b);
/// Composes poses: (a * b) p = a (b p).
Pose operator*(const Pose& a, const Pose& b);
Vec3 operator*(const Pose& pose, const Vec3& point);
Pose inverse(const Pose& pose);
Transform transformOf(const Pose& pose);
/// Rotation by yaw about z, then pitch about the new y, then roll about the new x; radians.
Quaternion yawPitchRoll(double yaw, double pitch, double roll);
/// The inverse of yawPitchRoll(), as {yaw, pitch, roll}.
std::array<double, 3> yawPitchRollOf(const Quaternion& q);
/// Rows of a rotation matrix; `m` must be a rotation to the precision of its digits.
Quaternion quaternionOf(const std::array<Vec3, 3>& m);

}  // namespace gnosphere::drive
