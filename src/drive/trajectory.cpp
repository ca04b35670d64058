// SPDX-License-Identifier: Apache-2.0
#include "drive/trajectory.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>

#include "base/text.hpp"
#include "base/vector.hpp"
#include "drive/median.hpp"
#include "drive/pose_math.hpp"
#include "effects/trajectory.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::drive {
namespace {

constexpr double kLongestBend = 0.5;  ///< seconds of a turn before and after a stamp
constexpr double kShortest = 1e-6;    ///< seconds over which rates are taken; differences of stamps closer tell nothing

/// Whether two poses are the same numbers; their bits may differ, as those of 0 and -0 do.
bool equal(const Pose& a, const Pose& b) {
  const Vec3 &p = a.position, &q = b.position;
  return p.x == q.x && p.y == q.y && p.z == q.z && isSame(a.orientation, b.orientation);
}

std::vector<Segment> segmentsOf(std::span<const Trajectory::Stamp> stamps, bool pitched,
                                std::optional<Direction> before = {}) {
  constexpr double kStill = 1e-6;  // metres
  std::vector<Segment> segments;
  for (size_t i = 1; i < stamps.size(); ++i) {
    const Vec3 way = stamps[i].pose.position - stamps[i - 1].pose.position;
    const double level = lengthOf(way.x, way.y);
    const bool moves = level > kStill;
    const Direction last = segments.empty() ? before.value_or(Direction{}) : segments.back().along;
    const Direction here = {std::atan2(way.y, way.x), pitched ? std::atan2(-way.z, level) : 0};
    segments.push_back({stamps[i].time - stamps[i - 1].time, moves ? here : last, moves});
  }
  const auto first = std::ranges::find(segments, true, &Segment::moves);
  if (first != segments.end() && !before)
    for (auto segment = segments.begin(); segment != first; ++segment) segment->along = first->along;
  return segments;
}

constexpr double kGpsWeek = 604800;  // s

/// Returns the median time between stamps; 0 if there is one stamp.
double medianSpacing(std::span<const Trajectory::Stamp> stamps) {
  std::vector<double> spacings;
  for (size_t i = 1; i < stamps.size(); ++i) spacings.push_back(stamps[i].time - stamps[i - 1].time);
  return medianOf(spacings);
}

/// Returns the seconds between positions below which their second differences tell of digits that a file has cut off
/// rather than of accelerations: rounding to 1 mm, 0.1 mm or 1 um must not add more than 0.3 m/s^2. The answer is 0 if
/// positions have more digits.
double blurOf(std::span<const Trajectory::Stamp> stamps) {
  constexpr double kMostNoise = 0.3;  // m/s^2, root mean square
  constexpr double kMostSteps = 1e7;  // a metre; coordinates on a map have no more digits as doubles
  constexpr size_t kDigits = 8;  // of the ten: last digits of rounded numbers differ, those of round numbers do not
  double steps = 1;              // a metre
  size_t digits = 0;
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    const auto value = [&](const Trajectory::Stamp& stamp) { return stamp.pose.position.*axis; };
    const auto isRounded = [&](double x) { return std::abs(steps * x - std::round(steps * x)) < 0.01; };
    while (steps < kMostSteps && !std::ranges::all_of(stamps, isRounded, value)) steps *= 10;
  }
  if (steps == kMostSteps) return 0;
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    std::bitset<10> found;
    for (const Trajectory::Stamp& stamp : stamps)
      found.set(static_cast<size_t>(std::fmod(std::abs(std::round(steps * (stamp.pose.position.*axis))), 10)));
    digits = std::max(digits, found.count());
  }
  if (digits < kDigits) return 0;
  // Errors of rounding are evenly spread, with a standard deviation of 1 / sqrt(12) steps, and a second difference adds
  // up six times their variance.
  return std::sqrt(std::sqrt(6.0 / 12) / (steps * kMostNoise));
}

/// The turn at a stamp from the segment before it to that after it. A vehicle turns only while it moves.
struct Bend {
  Direction angle;               ///< of the whole turn
  double before = 0, after = 0;  ///< seconds of the turn before and after the stamp; 0 if there is no turn
  Direction there;               ///< where the vehicle looks at the stamp

  /// Returns where it looks from a direction on, so many seconds of the turn later.
  Direction turned(const Direction& from, double seconds) const {
    const double share = seconds / (before + after);
    return {from.yaw + angle.yaw * share, from.pitch + angle.pitch * share};
  }
};

Bend bendAt(const std::vector<Segment>& segments, size_t stamp) {
  constexpr double kStraight = 1e-6;  // radians
  if (segments.empty()) return {};
  if (stamp == 0) return {{}, 0, 0, segments.front().along};
  const Segment& before = segments[stamp - 1];
  if (stamp == segments.size()) return {{}, 0, 0, before.along};
  const Segment& after = segments[stamp];
  const Direction angle = {std::remainder(after.along.yaw - before.along.yaw, 2 * M_PI),
                           after.along.pitch - before.along.pitch};
  if (std::abs(angle.yaw) < kStraight && std::abs(angle.pitch) < kStraight) return {{}, 0, 0, before.along};
  const auto share = [&](const Segment& segment) {
    return segment.moves ? std::clamp(segment.duration / 2, 0.0, kLongestBend) : 0.0;
  };
  Bend bend = {angle, share(before), share(after), {}};
  bend.there = bend.turned(before.along, bend.before);
  return bend;
}

}  // namespace

Trajectory::Trajectory(std::vector<Stamp> stamps) : motion_{std::move(stamps)} {
  if (motion_.stamps.empty()) throw Error(ErrorCode::format, "a trajectory has no pose");
  for (size_t i = 1; i < motion_.stamps.size(); ++i) {
    const double before = motion_.stamps[i - 1].time, time = motion_.stamps[i].time;
    if (!(time > before))
      throw Error(ErrorCode::format,
                  "the time of pose " + std::to_string(i + 1) + " of " + std::to_string(motion_.stamps.size()) + ", " +
                      gnosphere::numberText(time) + ", does not come after the one before, " +
                      gnosphere::numberText(before) +
                      (std::abs(before - time - kGpsWeek) < 3600 ? "; from the end of a GPS week on, add 604800 s"
                                                                 : "; sort the poses by their times"));
  }
  spacing_ = medianSpacing(motion_.stamps);
  blur_ = blurOf(motion_.stamps);
}

Trajectory Trajectory::alongWay(std::vector<Stamp> stamps, std::vector<bool> turned, bool pitched,
                                std::optional<Direction> before) {
  Trajectory result(std::move(stamps));
  std::vector<Stamp>& kept = result.motion_.stamps;
  turned.resize(kept.size());
  result.segments_ = segmentsOf(kept, pitched, before);
  result.turned_ = std::move(turned);
  for (size_t i = 0; i < kept.size(); ++i) {
    if (result.turned_[i]) continue;
    const Direction there = result.segments_.empty() ? before.value_or(Direction{}) : bendAt(result.segments_, i).there;
    kept[i].pose.orientation = yawPitchRoll(there.yaw, there.pitch, 0);
  }
  return result;
}

bool Trajectory::looksAlong(size_t i) const {
  return i < segments_.size() && !turned_[i] && !turned_[i + 1];
}

Pose Trajectory::at(double time) const {
  Pose pose = poseAt(motion_, {}, time);
  if (segments_.empty() || !(time > begin()) || !(time < end())) return pose;
  const std::vector<Stamp>& stamps = motion_.stamps;
  const auto next = std::ranges::upper_bound(stamps, time, {}, &Stamp::time);
  const auto i = static_cast<size_t>(next - stamps.begin()) - 1;
  if (!looksAlong(i)) return pose;
  const Bend from = bendAt(segments_, i), to = bendAt(segments_, i + 1);
  const double since = time - stamps[i].time, until = stamps[i + 1].time - time;
  Direction along = segments_[i].along;
  if (since < from.after) along = from.turned(along, since - from.after);
  if (until < to.before) along = to.turned(along, to.before - until);
  pose.orientation = yawPitchRoll(along.yaw, along.pitch, 0);
  return pose;
}

Trajectory::Neighbours Trajectory::neighboursOf(double time, double apart) const {
  const std::vector<Stamp>& stamps = motion_.stamps;
  const auto last = static_cast<ptrdiff_t>(stamps.size()) - 1;
  // The next stamp in a direction that is far enough away; behind the end if there is none.
  const auto next = [&](ptrdiff_t from, ptrdiff_t step) {
    ptrdiff_t to = from + step;
    while (to >= 0 && to <= last && std::abs(stamps[to].time - stamps[from].time) < apart) to += step;
    return to;
  };
  const auto after = std::ranges::lower_bound(stamps, time, {}, &Stamp::time) - stamps.begin();
  ptrdiff_t middle = std::min(after, last);
  if (after > 0 && after <= last && time - stamps[after - 1].time < stamps[after].time - time) --middle;
  if (next(middle, -1) < 0) middle = next(0, 1);
  if (middle > last || next(middle, 1) > last) middle = next(last, -1);
  const ptrdiff_t low = middle < 0 ? 0 : std::max<ptrdiff_t>(next(middle, -1), 0),
                  high = middle < 0 ? last : next(middle, 1);
  return {static_cast<size_t>(low), static_cast<size_t>(std::clamp(middle, low, high)), static_cast<size_t>(high)};
}

Trajectory::Rates Trajectory::ratesAt(double time, const Pose& mount, double period) const {
  constexpr double kMost = 0.05 - 1e-9;  // seconds between stamps of a parabola, less the rounding of times in files
  constexpr double kShare = 0.75;        // of the usual time between stamps, so that a stamp that is early counts, too
  const std::vector<Stamp>& stamps = motion_.stamps;
  if (!(end() - begin() > kShortest) || !covers(time)) return {};  // the vehicle stands
  const double apart = std::min(kMost, std::max(kShortest, kShare * std::max(spacing_, period)));
  const Neighbours way = neighboursOf(time, std::min(kMost, std::max(apart, blur_))), turns = neighboursOf(time, apart);
  const auto mountedAt = [&](double when) { return Stamp{when, at(when) * mount}; };
  const auto mounted = [&](size_t i) { return Stamp{stamps[i].time, stamps[i].pose * mount}; };
  const bool isSparse = stamps[way.high].time - stamps[way.low].time > 2 * kLongestBend + 1e-9;
  const Stamp first = isSparse ? mountedAt(std::max(time - kLongestBend, begin())) : mounted(way.low),
              between = isSparse ? mountedAt(time) : mounted(way.middle),
              end = isSparse ? mountedAt(std::min(time + kLongestBend, this->end())) : mounted(way.high);
  const Vec3 across = (1 / (end.time - first.time)) * (end.pose.position - first.pose.position);
  Rates rates = {across, {}, {}};
  if (between.time - first.time > kShortest && end.time - between.time > kShortest) {
    const Vec3 early = (1 / (between.time - first.time)) * (between.pose.position - first.pose.position);
    rates.acceleration = (2 / (end.time - between.time)) * (across - early);
    rates.velocity = across + (time - 0.5 * (first.time + end.time)) * rates.acceleration;
  }
  const Span span = around(time, std::min(kAround, std::max({kShortest, spacing_, period})));
  const bool atStamps = segments_.empty() && !isSparse;
  const Stamp from = atStamps ? mounted(turns.low) : mountedAt(span.from),
              to = atStamps ? mounted(turns.high) : mountedAt(span.to);
  const Quaternion turn = inverse(from.pose).orientation * to.pose.orientation;
  const Vec3 axis = (turn.w < 0 ? -1.0 : 1.0) * Vec3{turn.x, turn.y, turn.z};
  const double sine = lengthOf(axis), angle = angleBetween(from.pose.orientation, to.pose.orientation);
  if (sine > 0) rates.turnRate = (angle / (sine * (to.time - from.time))) * axis;
  return rates;
}

Trajectory::Span Trajectory::around(double time, double reach) const {
  Span span = {time - reach, time + reach};
  if (!(end() - begin() > kShortest)) return span;
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
  const std::vector<Stamp>& stamps = motion_.stamps;
  std::vector<double> times;
  const auto add = [&](double time) {
    if (time > from && time < to && (times.empty() || time > times.back())) times.push_back(time);
  };
  // The last stamp that is not later than `from` may have a turn that ends later.
  auto stamp = std::ranges::upper_bound(stamps, from, {}, &Stamp::time);
  if (stamp != stamps.begin()) --stamp;
  for (; stamp != stamps.end(); ++stamp) {
    const auto i = static_cast<size_t>(stamp - stamps.begin());
    const Bend bend = segments_.empty() ? Bend() : bendAt(segments_, i);
    if (bend.before > 0 && looksAlong(i - 1)) add(stamp->time - bend.before);
    add(stamp->time);
    if (bend.after > 0 && looksAlong(i)) add(stamp->time + bend.after);
    if (stamp->time >= to) break;
  }
  return times;
}

std::optional<Direction> directionOfLastWay(std::span<const Trajectory::Stamp> stamps, bool pitched) {
  const std::vector<Segment> segments = segmentsOf(stamps, pitched);
  if (std::ranges::find(segments, true, &Segment::moves) == segments.end()) return {};
  return segments.back().along;
}

double steepestOf(std::span<const Trajectory::Stamp> stamps) {
  constexpr double kWay = 2;  // metres: on shorter ways, noise looks like slopes
  std::vector<double> gone = {0};
  for (size_t i = 1; i < stamps.size(); ++i) {
    const Vec3 way = stamps[i].pose.position - stamps[i - 1].pose.position;
    gone.push_back(gone.back() + lengthOf(way.x, way.y));
  }
  double steepest = 0;
  size_t from = 0;  // the last stamp that is kWay or more before `to`, or the first
  for (size_t to = 1; to < stamps.size(); ++to) {
    while (from + 1 < to && gone[to] - gone[from + 1] >= kWay) ++from;
    const double way = gone[to] - gone[from];
    if (way < std::min(kWay, gone.back()) || !(way > 0)) continue;
    steepest = std::max(steepest, std::abs(stamps[to].pose.position.z - stamps[from].pose.position.z) / way);
  }
  return steepest;
}

std::vector<double> yawsAlong(const std::vector<Trajectory::Stamp>& stamps) {
  const std::vector<Segment> segments = segmentsOf(stamps, false);
  std::vector<double> yaws(stamps.size());
  for (size_t i = 0; i < stamps.size(); ++i) yaws[i] = bendAt(segments, i).there.yaw;
  return yaws;
}

}  // namespace gnosphere::drive
