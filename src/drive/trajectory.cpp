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

Trajectory::Rates Trajectory::ratesAt(double time, const Pose& mount) const {
  constexpr double kApart = 0.05;
  const std::vector<Stamp>& stamps = motion_.stamps;
  if (stamps.size() < 2 || !covers(time)) return {};  // the vehicle stands
  const auto last = static_cast<ptrdiff_t>(stamps.size()) - 1;
  // The next stamp in a direction that is far enough away; behind the end if there is none.
  const auto next = [&](ptrdiff_t from, ptrdiff_t step) {
    ptrdiff_t to = from + step;
    while (to >= 0 && to <= last && std::abs(stamps[to].time - stamps[from].time) < kApart - 1e-9) to += step;
    return to;
  };
  const auto after = std::ranges::lower_bound(stamps, time, {}, &Stamp::time) - stamps.begin();
  ptrdiff_t middle = std::min(after, last);
  if (after > 0 && after <= last && time - stamps[after - 1].time < stamps[after].time - time) --middle;
  if (next(middle, -1) < 0) middle = next(0, 1);
  if (middle > last || next(middle, 1) > last) middle = next(last, -1);
  const ptrdiff_t low = middle < 0 ? 0 : std::max<ptrdiff_t>(next(middle, -1), 0),
                  high = middle < 0 ? last : next(middle, 1);
  const auto mounted = [&](ptrdiff_t i) { return Stamp{stamps[i].time, stamps[i].pose * mount}; };
  const Stamp first = mounted(low), end = mounted(high);
  const Vec3 across = (1 / (end.time - first.time)) * (end.pose.position - first.pose.position);
  Rates rates = {across, {}, {}};
  if (middle > low && middle < high) {
    const Stamp between = mounted(middle);
    const Vec3 early = (1 / (between.time - first.time)) * (between.pose.position - first.pose.position);
    rates.acceleration = (2 / (end.time - between.time)) * (across - early);
    rates.velocity = across + (time - 0.5 * (first.time + end.time)) * rates.acceleration;
  }
  const Quaternion turn = inverse(first.pose).orientation * end.pose.orientation;
  const Vec3 axis = (turn.w < 0 ? -1.0 : 1.0) * Vec3{turn.x, turn.y, turn.z};
  const double sine = lengthOf(axis), angle = angleBetween(first.pose.orientation, end.pose.orientation);
  if (sine > 0) rates.turnRate = (angle / (sine * (end.time - first.time))) * axis;
  return rates;
}

Trajectory::Span Trajectory::around(double time) const {
  Span span = {time - kAround, time + kAround};
  if (!(begin() < end())) return span;
  if (time <= end()) span.to = std::min(span.to, time < begin() ? begin() : end());
  if (time >= begin()) span.from = std::max(span.from, time > end() ? end() : begin());
  return span;
}

Vec3 Trajectory::velocityAt(double time) const {
  const auto [from, to] = around(time);
  return (1 / (to - from)) * (at(to).position - at(from).position);
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
