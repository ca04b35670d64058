// SPDX-License-Identifier: Apache-2.0
#include "pipeline/origin_groups.hpp"

#include <algorithm>
#include <utility>

#include "base/vector.hpp"

namespace gnosphere {
namespace {

// A group is divided if its lasers lie further than this from its middle along an axis, in metres. Every beam is tried
// on whatever lies within twice this distance.
constexpr double kMostRadius = 0.3;
// Farther away, the beams that are tried in vain are as many as the beams of the group times the square of its radius.
// From this product on (beams x m^2) one more projection costs less.
constexpr double kMostBlur = 10'000;

bool isWide(double beams, double radius) {
  return radius > kMostRadius || beams * radius * radius > kMostBlur;
}

using Numbers = std::vector<uint32_t>;

class Divider {
 public:
  Divider(const Sensor& sensor, uint64_t frame)
      : sensor_(sensor), frame_(frame), silent_(silentBeams(sensor)), origins_(originsOf(sensor, frame)) {}

  std::vector<OriginGroup> groups() {
    Numbers all(sensor_.beamCount());
    for (uint32_t beam = 0; beam < all.size(); ++beam) all[beam] = beam;
    double farthest = 0;
    for (const Vec3& o : origins_) farthest = std::max(farthest, lengthOf(o));
    if (origins_.empty() || !isWide(static_cast<double>(all.size()), farthest))
      add(startTogether() ? origins_[0] : middleOfLasers(sensor_), all);
    else
      divide(std::move(all));
    return std::move(groups_);
  }

 private:
  static std::span<const Vec3> originsOf(const Sensor& sensor, uint64_t frame) {
    if (sensor.isGrid()) return {};
    return patternOf(sensor, frame).origins;
  }

  // True if all beams start at one point. A scan that is seen from this point needs no origins of beams.
  bool startTogether() const {
    return !origins_.empty() && std::ranges::all_of(origins_, [&](const Vec3& o) {
      return o.x == origins_[0].x && o.y == origins_[0].y && o.z == origins_[0].z;
    });
  }

  // Halves the longest side of the box around the lasers until the group is small enough.
  void divide(Numbers beams) {
    Vec3 low = origins_[beams[0]], high = low;
    for (const uint32_t beam : beams) {
      const Vec3& o = origins_[beam];
      low = lowest(low, o);
      high = highest(high, o);
    }
    const Vec3 middle = {0.5 * (low.x + high.x), 0.5 * (low.y + high.y), 0.5 * (low.z + high.z)};
    const double x = high.x - middle.x, y = high.y - middle.y, z = high.z - middle.z, radius = std::max({x, y, z});
    if (!isWide(static_cast<double>(beams.size()), radius)) return add(middle, beams);
    double Vec3::*const axis = x == radius ? &Vec3::x : y == radius ? &Vec3::y : &Vec3::z;
    Numbers lower, upper;
    for (const uint32_t beam : beams) (origins_[beam].*axis < middle.*axis ? lower : upper).push_back(beam);
    beams = {};
    divide(std::move(lower));
    divide(std::move(upper));
  }

  void add(const Vec3& middle, const Numbers& beams) {
    OriginGroup group = {originBoundsOf(sensor_, frame_, middle, beams), {}, {}};
    for (const uint32_t beam : beams) (silent_[beam] ? group.silent : group.beams).push_back(beam);
    groups_.push_back(std::move(group));
  }

  const Sensor& sensor_;
  const uint64_t frame_;
  const std::vector<bool> silent_;
  const std::span<const Vec3> origins_;
  std::vector<OriginGroup> groups_;
};

}  // namespace

std::vector<OriginGroup> originGroups(const Sensor& sensor, uint64_t frame) {
  return Divider(sensor, frame).groups();
}

}  // namespace gnosphere
