// SPDX-License-Identifier: Apache-2.0
#include "drive/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "base/vector.hpp"
#include "drive/pose_math.hpp"
#include "effects/trajectory.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::drive {
namespace {

/// Whether two poses are the same numbers; their bits may differ, as those of 0 and -0 do.
bool equal(const Pose& a, const Pose& b) {
  const auto& [p, q] = a;
  const auto& [r, s] = b;
  return p.x == r.x && p.y == r.y && p.z == r.z && q.x == s.x && q.y == s.y && q.z == s.z && q.w == s.w;
}

}  // namespace

Trajectory::Trajectory(std::vector<Stamp> stamps) : motion_{std::move(stamps)} {
  if (motion_.stamps.empty()) throw Error(ErrorCode::format, "a trajectory has no pose");
  for (size_t i = 1; i < motion_.stamps.size(); ++i) {
    const double before = motion_.stamps[i - 1].time, time = motion_.stamps[i].time;
    if (!(time > before))
      throw Error(ErrorCode::format, "the time of pose " + std::to_string(i) + ", " + gnosphere::numberText(time) +
                                         ", does not come after the one before, " + gnosphere::numberText(before));
  }
}

Pose Trajectory::at(double time) const {
  return poseAt(motion_, {}, time);
}

bool Trajectory::movesWithin(double from, double to) const {
  const Pose start = at(from);
  if (!equal(start, at(to))) return true;
  const std::vector<double> between = timesWithin(from, to);
  return std::any_of(between.begin(), between.end(), [&](double time) { return !equal(start, at(time)); });
}

std::vector<double> Trajectory::timesWithin(double from, double to) const {
  const auto later = [](double time, const Stamp& stamp) { return time < stamp.time; };
  std::vector<double> times;
  auto stamp = std::upper_bound(motion_.stamps.begin(), motion_.stamps.end(), from, later);
  for (; stamp != motion_.stamps.end() && stamp->time < to; ++stamp) times.push_back(stamp->time);
  return times;
}

void headAlong(std::vector<Trajectory::Stamp>& stamps) {
  constexpr double kStill = 1e-6;  // metres
  Quaternion heading;
  size_t first = stamps.size();  // first stamp with a direction; those before it get the same
  for (size_t i = 0; i < stamps.size(); ++i) {
    const Vec3 &from = stamps[i == 0 ? 0 : i - 1].pose.position,
               &to = stamps[std::min(i + 1, stamps.size() - 1)].pose.position;
    const double x = to.x - from.x, y = to.y - from.y;
    if (lengthOf(x, y) > kStill) {
      heading = yawPitchRoll(std::atan2(y, x), 0, 0);
      first = std::min(first, i);
    }
    stamps[i].pose.orientation = heading;
  }
  for (size_t i = 0; i < first && first < stamps.size(); ++i)
    stamps[i].pose.orientation = stamps[first].pose.orientation;
}

}  // namespace gnosphere::drive
