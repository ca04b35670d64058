// SPDX-License-Identifier: Apache-2.0
#include "effects/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/quaternion.hpp"
#include "base/vector.hpp"

namespace gnosphere {
namespace {

using Stamp = SensorMotion::Stamp;

Quaternion scaled(const Quaternion& q, double by) {
  return {by * q.x, by * q.y, by * q.z, by * q.w};
}
Quaternion sum(const Quaternion& a, const Quaternion& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w};
}
double dot(const Quaternion& a, const Quaternion& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}
Quaternion unit(const Quaternion& q) {
  return scaled(q, 1 / std::sqrt(dot(q, q)));
}

/// Spherical interpolation after Shoemake, "Animating rotation with quaternion curves" (SIGGRAPH 1985); q and -q are
/// the same rotation.
Quaternion slerp(const Quaternion& first, const Quaternion& second, double share) {
  const Quaternion from = withUsableLength(first), to = withUsableLength(second), a = unit(from);
  const Quaternion b = dot(from, to) < 0 ? scaled(unit(to), -1) : unit(to);
  // The angle is computed from the difference, because that is accurate for small angles.
  const Quaternion half = sum(b, scaled(a, -1));
  const double angle = 2 * std::asin(std::min(1.0, std::sqrt(dot(half, half)) / 2));
  if (angle < 1e-9) return unit(sum(scaled(a, 1 - share), scaled(b, share)));
  return unit(sum(scaled(a, std::sin((1 - share) * angle)), scaled(b, std::sin(share * angle))));
}

/// Returns the index of the first stamp later than `time`.
size_t after(const std::vector<Stamp>& stamps, double time) {
  const auto later = [](double t, const Stamp& stamp) { return t < stamp.time; };
  return static_cast<size_t>(std::upper_bound(stamps.begin(), stamps.end(), time, later) - stamps.begin());
}

/// Returns the two stamps of the interval that contains `time`, or that is nearest to it; none if there is no interval.
std::span<const Stamp> intervalAt(const SensorMotion& motion, double time) {
  const std::span<const Stamp> stamps = motion.stamps;
  if (stamps.size() < 2) return {};
  return stamps.subspan(std::clamp(after(motion.stamps, time), size_t{1}, stamps.size() - 1) - 1, 2);
}

}  // namespace

Pose poseAt(const SensorMotion& motion, const Pose& standing, double time) {
  const auto& stamps = motion.stamps;
  if (stamps.empty()) return standing;
  const size_t next = after(stamps, time);
  if (next == 0) return stamps.front().pose;
  if (next == stamps.size()) return stamps.back().pose;
  const Stamp &a = stamps[next - 1], &b = stamps[next];
  const double share = (time - a.time) / (b.time - a.time);
  const Vec3 &p = a.pose.position, &q = b.pose.position;
  const Quaternion &from = a.pose.orientation, &to = b.pose.orientation;
  // An orientation between two equal ones has the same numbers, so what stands does not move by rounding.
  return {p + share * (q - p), isSame(from, to) ? from : slerp(from, to, share)};
}

Vec3 velocityAt(const SensorMotion& motion, double time) {
  const std::span<const Stamp> interval = intervalAt(motion, time);
  if (interval.empty()) return {};
  const Stamp &a = interval[0], &b = interval[1];
  return 1 / (b.time - a.time) * (b.pose.position - a.pose.position);
}

Vec3 angularVelocityAt(const SensorMotion& motion, double time) {
  const std::span<const Stamp> interval = intervalAt(motion, time);
  if (interval.empty()) return {};
  const Stamp &a = interval[0], &b = interval[1];
  const Quaternion p = unit(withUsableLength(a.pose.orientation)), q = unit(withUsableLength(b.pose.orientation));
  // The rotation conj(p) q leads from the one pose to the other along the shorter arc.
  const Vec3 axis = {p.w * q.x - p.x * q.w - p.y * q.z + p.z * q.y, p.w * q.y + p.x * q.z - p.y * q.w - p.z * q.x,
                     p.w * q.z - p.x * q.y + p.y * q.x - p.z * q.w};
  const double sine = lengthOf(axis), cosine = dot(p, q);
  if (sine == 0) return {};
  const double angle = 2 * std::atan2(sine, std::abs(cosine));
  return std::copysign(angle / sine / (b.time - a.time), cosine) * axis;
}

Transform velocityOf(const Transform& start, const Transform& end, double period) {
  Transform result;
  for (size_t i = 0; i < 12; ++i) result.rows[i] = (end.rows[i] - start.rows[i]) / period;
  return result;
}

}  // namespace gnosphere
