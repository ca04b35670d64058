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

/// The way from one stamp to the next.
struct Segment {
  double duration = 0;  ///< seconds
  bool moves = false;
  double yaw = 0;  ///< of the way; where it does not move, that of the way before, or else of the first way
};

std::vector<Segment> segmentsOf(const std::vector<Trajectory::Stamp>& stamps) {
  constexpr double kStill = 1e-6;  // metres
  std::vector<Segment> segments;
  for (size_t i = 1; i < stamps.size(); ++i) {
    const Vec3 way = stamps[i].pose.position - stamps[i - 1].pose.position;
    const bool moves = lengthOf(way.x, way.y) > kStill;
    const double before = segments.empty() ? 0 : segments.back().yaw;
    segments.push_back({stamps[i].time - stamps[i - 1].time, moves, moves ? std::atan2(way.y, way.x) : before});
  }
  const auto first = std::ranges::find(segments, true, &Segment::moves);
  if (first != segments.end())
    for (auto segment = segments.begin(); segment != first; ++segment) segment->yaw = first->yaw;
  return segments;
}

/// The turn at a stamp from the segment before it to that after it: it takes time of segments that move alone.
struct Bend {
  double angle = 0;              ///< radians, counter-clockwise
  double before = 0, after = 0;  ///< seconds of the turn before and after the stamp
  double yaw = 0;                ///< at the stamp
};

Bend bendAt(const std::vector<Segment>& segments, size_t stamp) {
  constexpr double kLongest = 0.5;  // seconds, before and after a stamp
  if (segments.empty()) return {};
  if (stamp == 0) return {0, 0, 0, segments.front().yaw};
  const Segment& before = segments[stamp - 1];
  if (stamp == segments.size()) return {0, 0, 0, before.yaw};
  const Segment& after = segments[stamp];
  const auto share = [&](const Segment& segment) {
    return segment.moves ? std::clamp(segment.duration / 2, 0.0, kLongest) : 0.0;
  };
  Bend bend = {std::remainder(after.yaw - before.yaw, 2 * M_PI), share(before), share(after), before.yaw};
  if (bend.before > 0) bend.yaw += bend.angle * bend.before / (bend.before + bend.after);
  return bend;
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

std::vector<double> yawsAlong(const std::vector<Trajectory::Stamp>& stamps) {
  const std::vector<Segment> segments = segmentsOf(stamps);
  std::vector<double> yaws(stamps.size());
  for (size_t i = 0; i < stamps.size(); ++i) yaws[i] = bendAt(segments, i).yaw;
  return yaws;
}

void headAlong(std::vector<Trajectory::Stamp>& stamps, const std::vector<bool>& turned) {
  const std::vector<Segment> segments = segmentsOf(stamps);
  const auto isTurned = [&](size_t i) { return i < turned.size() && turned[i]; };
  const bool ascends = std::ranges::all_of(segments, [](const Segment& segment) { return segment.duration >= 0; });
  std::vector<Trajectory::Stamp> result;
  for (size_t i = 0; i < stamps.size(); ++i) {
    const Bend bend = bendAt(segments, i);
    result.push_back(stamps[i]);
    if (!isTurned(i)) result.back().pose.orientation = yawPitchRoll(bend.yaw, 0, 0);
    if (i == segments.size() || !ascends || isTurned(i) || isTurned(i + 1)) continue;
    const auto insert = [&](double time) {
      const Vec3 &from = stamps[i].pose.position, &to = stamps[i + 1].pose.position;
      if (time > result.back().time && time < stamps[i + 1].time) {
        const double share = (time - stamps[i].time) / segments[i].duration;
        result.push_back({time, {from + share * (to - from), yawPitchRoll(segments[i].yaw, 0, 0)}});
      }
    };
    const Bend next = bendAt(segments, i + 1);
    if (bend.angle != 0) insert(stamps[i].time + bend.after);
    if (next.angle != 0) insert(stamps[i + 1].time - next.before);
  }
  stamps = std::move(result);
}

}  // namespace gnosphere::drive
