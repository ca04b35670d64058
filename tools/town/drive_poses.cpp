// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/quaternion.hpp"
#include "town/opendrive/drive.hpp"
#include "town/plan.hpp"
#include "town/town.hpp"

namespace gnosphere {
namespace {

using namespace town;
using opendrive::WayPoint;

constexpr double kSensorHeight = 1.8;
constexpr double kBaseline = 0.4;  ///< metres before and after a pose that define its heading

/// Points of a path by their distance along it.
class Way {
 public:
  explicit Way(const std::vector<WayPoint>& points) : points_(points), distances_{0} {
    for (size_t i = 1; i < points.size(); ++i)
      distances_.push_back(distances_.back() + lengthOf(points[i].at - points[i - 1].at));
  }
  double length() const { return distances_.back(); }
  WayPoint at(double distance) const {
    distance = std::clamp(distance, 0.0, length());
    const auto next = std::upper_bound(distances_.begin() + 1, distances_.end() - 1, distance);
    const size_t i = static_cast<size_t>(next - distances_.begin());
    const WayPoint &from = points_[i - 1], &to = points_[i];
    const double share = (distance - distances_[i - 1]) / (distances_[i] - distances_[i - 1]);
    return {from.at + share * (to.at - from.at), from.up + share * (to.up - from.up)};
  }

 private:
  const std::vector<WayPoint>& points_;
  std::vector<double> distances_;
};

/// Returns the rotation about z that maps x to a level unit vector.
Quaternion headingAlong(const Vec3& x) {
  const double w = std::sqrt(std::max(0.0, (1 + x.x) / 2)), z = std::sqrt(std::max(0.0, (1 - x.x) / 2));
  return {0, 0, x.y < 0 ? -z : z, w};
}

/// Returns the rotation about the y axis by which the level x axis rises with a slope.
Quaternion pitchOf(double slope) {
  return normalized(Quaternion{0, -slope, 0, std::sqrt(1 + slope * slope) + 1});
}

/// Returns the rotation about the x axis of a pose that brings its z axis nearest to `up`.
Quaternion rollTowards(const Quaternion& orientation, const Vec3& up) {
  const double side = -dot(up, orientation * Vec3{0, 1, 0}), height = dot(up, orientation * Vec3{0, 0, 1});
  return normalized(Quaternion{side, 0, 0, lengthOf(side, height) + height});
}

/// Turns a vector as a transform without scale does.
Vec3 turnedBy(const Transform& transform, const Vec3& v) {
  const auto& m = transform.rows;
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
          m[8] * v.x + m[9] * v.y + m[10] * v.z};
}

std::vector<Pose> posesAlong(const std::vector<WayPoint>& points, const Transform& toWorld) {
  const Way way(points);
  const double spacing = std::min(kDriveMetres, way.length()) / (kDrivePoses - 1);
  std::vector<Pose> poses;
  for (size_t i = 0; i < kDrivePoses; ++i) {
    const double distance = spacing * static_cast<double>(i);
    const WayPoint here = way.at(distance);
    const Vec3 from = toWorld * way.at(distance - kBaseline).at, to = toWorld * way.at(distance + kBaseline).at;
    const Quaternion heading = headingAlong(normalized(Vec3{to.x - from.x, to.y - from.y, 0}));
    const Vec3 axles = way.at(distance + kHalfWheelbase).at - way.at(distance - kHalfWheelbase).at;
    const Quaternion inclined = heading * pitchOf(axles.z / lengthOf(axles.x, axles.y));
    poses.push_back({toWorld * (here.at + Vec3{0, 0, kSensorHeight}),
                     inclined * rollTowards(inclined, turnedBy(toWorld, here.up))});
  }
  return poses;
}

}  // namespace

std::vector<Pose> makeDrive(const TownOptions& options) {
  if (options.xodr.empty()) {
    std::vector<WayPoint> level;
    for (const Vec3& point : gridDrive(options.seed)) level.push_back({point});
    return posesAlong(level, {});
  }
  const opendrive::Network network = opendrive::readNetwork(options.xodr);
  return posesAlong(opendrive::planDrive(network, options.seed, kDriveMetres).points, network.toFile);
}

}  // namespace gnosphere
