// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "town/opendrive/drive.hpp"
#include "town/plan.hpp"
#include "town/town.hpp"

namespace gnosphere {
namespace {

using namespace town;

constexpr double kSensorHeight = 1.8;
constexpr double kBaseline = 0.4;  ///< metres before and after a pose that define its heading

/// Points of a path by their distance along it.
class Way {
 public:
  explicit Way(const std::vector<Vec3>& points) : points_(points), distances_{0} {
    for (size_t i = 1; i < points.size(); ++i)
      distances_.push_back(distances_.back() + lengthOf(points[i] - points[i - 1]));
  }
  double length() const { return distances_.back(); }
  Vec3 at(double distance) const {
    distance = std::clamp(distance, 0.0, length());
    const auto next = std::upper_bound(distances_.begin() + 1, distances_.end() - 1, distance);
    const size_t i = static_cast<size_t>(next - distances_.begin());
    const double share = (distance - distances_[i - 1]) / (distances_[i] - distances_[i - 1]);
    return points_[i - 1] + share * (points_[i] - points_[i - 1]);
  }

 private:
  const std::vector<Vec3>& points_;
  std::vector<double> distances_;
};

/// Returns the rotation about z that maps x to a level unit vector.
Quaternion headingAlong(const Vec3& x) {
  const double w = std::sqrt(std::max(0.0, (1 + x.x) / 2)), z = std::sqrt(std::max(0.0, (1 - x.x) / 2));
  return {0, 0, x.y < 0 ? -z : z, w};
}

std::vector<Pose> posesAlong(const std::vector<Vec3>& points, const Transform& toWorld) {
  const Way way(points);
  const double spacing = std::min(kDriveMetres, way.length()) / (kDrivePoses - 1);
  std::vector<Pose> poses;
  for (size_t i = 0; i < kDrivePoses; ++i) {
    const double distance = spacing * static_cast<double>(i);
    const Vec3 from = toWorld * way.at(distance - kBaseline), to = toWorld * way.at(distance + kBaseline);
    const Vec3 along = {to.x - from.x, to.y - from.y, 0};
    poses.push_back({toWorld * (way.at(distance) + Vec3{0, 0, kSensorHeight}), headingAlong(normalized(along))});
  }
  return poses;
}

}  // namespace

std::vector<Pose> makeDrive(const TownOptions& options) {
  if (options.xodr.empty()) return posesAlong(gridDrive(options.seed), {});
  const opendrive::Network network = opendrive::readNetwork(options.xodr);
  return posesAlong(opendrive::planDrive(network, options.seed, kDriveMetres).points, network.toFile);
}

}  // namespace gnosphere
