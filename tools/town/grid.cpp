// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "town/plan.hpp"

namespace gnosphere::town {
namespace {

/// A street of the grid: the line across an axis at `at`.
struct Line {
  double at;
  double half;  ///< of the carriageway
  bool avenue;
};

/// Lines across one axis. Line 0 is at 0; the others do not depend on how many there are.
class Lines {
 public:
  Lines(uint32_t seed, int axis, int avenuePhase, double extent) : phase_(avenuePhase) {
    lines_.push_back(make(0, 0));
    first_ = 0;
    double at = 0;
    for (int i = 1; at < extent; ++i) lines_.push_back(make(at += gap(seed, axis, i), i));
    at = 0;
    std::vector<Line> before;
    for (int i = -1; at > -extent; --i) before.push_back(make(at -= gap(seed, axis, i + 1), i));
    first_ = -static_cast<int>(before.size());
    lines_.insert(lines_.begin(), before.rbegin(), before.rend());
  }
  int begin() const { return first_; }
  int end() const { return first_ + static_cast<int>(lines_.size()); }
  const Line& operator[](int i) const { return lines_[static_cast<size_t>(i - first_)]; }

 private:
  // Between line i - 1 and line i, in whole metres.
  static double gap(uint32_t seed, int axis, int i) {
    return 62 + Dice(seed, 1, axis, static_cast<uint64_t>(i + 4096)).below(37);
  }
  Line make(double at, int i) const {
    const bool avenue = ((i % 4) + 4) % 4 == phase_;
    return {at, avenue ? 6.6 : 5.2, avenue};
  }

  int phase_;
  int first_;
  std::vector<Line> lines_;
};

int centimetres(double metres) {
  return static_cast<int>(std::lround(100 * metres));
}

constexpr double kCorner = kCornerRadius / 100.0;
constexpr double kSettled = 55;  ///< metres: the four blocks around the origin, and the streets between, come first

double reachOf(double x, double y) {
  return std::max(0.0, std::max(std::abs(x), std::abs(y)) - kSettled);
}

void addCrossing(Plan& plan, const Line& x, const Line& y) {
  const double reachX = x.half + kCorner, reachY = y.half + kCorner;
  plan.blockReach = reachOf(x.at, y.at);
  plan.addGround(Crossing{centimetres(x.half), centimetres(y.half)}, {x.at, y.at, 0}, 0,
                 {x.at - reachX, y.at - reachY, 0}, {x.at + reachX, y.at + reachY, 0});
}

/// The carriageway along an axis between two lines across it.
void addRoad(Plan& plan, Dice dice, const Line& from, const Line& to, const Line& line, bool alongY,
             const Detail& detail) {
  const double start = from.at + from.half + kCorner, end = to.at - to.half - kCorner;
  const Road road = {centimetres(end - start), centimetres(line.half), line.avenue};
  const Vec3 at = alongY ? Vec3{line.at, start, 0} : Vec3{start, line.at, 0};
  const Vec3 low = alongY ? Vec3{line.at - line.half, start, 0} : Vec3{start, line.at - line.half, 0};
  const Vec3 high = alongY ? Vec3{line.at + line.half, end, 0} : Vec3{end, line.at + line.half, 0};
  plan.blockReach = reachOf((low.x + high.x) / 2, (low.y + high.y) / 2);
  plan.addGround(road, at, alongY ? 0.25 : 0, low, high);
  planTraffic(plan, dice, at, alongY, end - start, line.half, line.avenue, detail);
}

Site siteBetween(uint32_t seed, const Lines& xs, const Lines& ys, int i, int j) {
  const Line &left = xs[i], &right = xs[i + 1], &low = ys[j], &high = ys[j + 1];
  Site site = {seed, i, j, left.at + left.half, low.at + low.half, right.at - right.half, high.at - high.half, {}, {}};
  const bool lights[4] = {right.avenue || low.avenue, right.avenue || high.avenue, left.avenue || high.avenue,
                          left.avenue || low.avenue};
  const bool avenues[4] = {low.avenue, right.avenue, high.avenue, left.avenue};
  for (int k = 0; k < 4; ++k) {
    site.trafficLights[k] = lights[k];
    site.avenues[k] = avenues[k];
  }
  return site;
}

}  // namespace

Plan planGrid(uint32_t seed, double extent, const Detail& detail) {
  const Lines xs(seed, 0, 2, extent), ys(seed, 1, 0, extent);
  Plan plan;
  for (int i = xs.begin(); i < xs.end(); ++i)
    for (int j = ys.begin(); j < ys.end(); ++j) {
      const uint64_t column = static_cast<uint64_t>(i + 4096), row = static_cast<uint64_t>(j + 4096);
      addCrossing(plan, xs[i], ys[j]);
      if (i + 1 < xs.end()) addRoad(plan, Dice(seed, 2, column, row), xs[i], xs[i + 1], ys[j], false, detail);
      if (j + 1 < ys.end()) addRoad(plan, Dice(seed, 3, column, row), ys[j], ys[j + 1], xs[i], true, detail);
      if (i + 1 < xs.end() && j + 1 < ys.end()) {
        const Site site = siteBetween(seed, xs, ys, i, j);
        plan.blockReach = reachOf((site.x0 + site.x1) / 2, (site.y0 + site.y1) / 2);
        planBlock(plan, site, detail);
        planSidewalks(plan, site, detail);
      }
    }
  return plan;
}

}  // namespace gnosphere::town
