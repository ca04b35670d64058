// SPDX-License-Identifier: Apache-2.0
#include "drive/pose_math.hpp"

#include <algorithm>
#include <cmath>

namespace gnosphere::drive {

double angleBetween(const Quaternion& a, const Quaternion& b) {
  const Quaternion turn = Quaternion{-a.x, -a.y, -a.z, a.w} * b;
  return 2 * std::atan2(lengthOf({turn.x, turn.y, turn.z}), std::abs(turn.w));
}

Pose operator*(const Pose& a, const Pose& b) {
  return {a * b.position, normalized(a.orientation * b.orientation)};
}

Vec3 operator*(const Pose& pose, const Vec3& point) {
  return pose.position + pose.orientation * point;
}

Pose inverse(const Pose& pose) {
  const Quaternion& q = pose.orientation;
  const Quaternion back = {-q.x, -q.y, -q.z, q.w};
  return {-1.0 * (back * pose.position), back};
}

Transform transformOf(const Pose& pose) {
  const Vec3 x = pose.orientation * Vec3{1, 0, 0}, y = pose.orientation * Vec3{0, 1, 0},
             z = pose.orientation * Vec3{0, 0, 1}, &p = pose.position;
  return {{x.x, y.x, z.x, p.x, x.y, y.y, z.y, p.y, x.z, y.z, z.z, p.z}};
}

Quaternion yawPitchRoll(double yaw, double pitch, double roll) {
  const Quaternion z = {0, 0, std::sin(yaw / 2), std::cos(yaw / 2)},
                   y = {0, std::sin(pitch / 2), 0, std::cos(pitch / 2)},
                   x = {std::sin(roll / 2), 0, 0, std::cos(roll / 2)};
  return z * y * x;
}

std::array<double, 3> yawPitchRollOf(const Quaternion& q) {
  const double sine = std::clamp(2 * (q.w * q.y - q.z * q.x), -1.0, 1.0);
  return {std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z)), std::asin(sine),
          std::atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x * q.x + q.y * q.y))};
}

// After Shepperd, "Quaternion from rotation matrix" (1978): the largest of the four is computed by a root.
Quaternion quaternionOf(const std::array<Vec3, 3>& m) {
  const double xx = m[0].x, yy = m[1].y, zz = m[2].z, trace = xx + yy + zz;
  Quaternion q;
  if (trace >= std::max({xx, yy, zz}))
    q = {m[2].y - m[1].z, m[0].z - m[2].x, m[1].x - m[0].y, 1 + trace};
  else if (xx >= std::max(yy, zz))
    q = {1 + xx - yy - zz, m[0].y + m[1].x, m[0].z + m[2].x, m[2].y - m[1].z};
  else if (yy >= zz)
    q = {m[0].y + m[1].x, 1 - xx + yy - zz, m[1].z + m[2].y, m[0].z - m[2].x};
  else
    q = {m[0].z + m[2].x, m[1].z + m[2].y, 1 - xx - yy + zz, m[1].x - m[0].y};
  return normalized(q);
}

}  // namespace gnosphere::drive
