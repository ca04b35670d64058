// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "town/plan.hpp"

namespace gnosphere::town {
namespace {

/// A street of the grid, which crosses an axis at `at`.
struct Line {
  double at;
  double half;  ///< half the width of the carriageway
  bool avenue;
};

/// The streets across one axis. Street 0 is at 0; the positions do not depend on the number of streets.
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
  // Distance between street i - 1 and street i, in whole metres.
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

double reachOf(double x, double y) {
  return std::max(0.0, std::max(std::abs(x), std::abs(y)) - kBuiltFirst);
}

void addCrossing(Plan& plan, const Line& x, const Line& y) {
  const double reachX = x.half + kCorner, reachY = y.half + kCorner;
  plan.blockReach = reachOf(x.at, y.at);
  plan.addGround(Crossing{centimetres(x.half), centimetres(y.half)}, {x.at, y.at, 0}, 0,
                 {x.at - reachX, y.at - reachY, 0}, {x.at + reachX, y.at + reachY, 0});
}

/// Adds the carriageway along an axis between two streets that cross it.
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

Lines linesAcrossX(uint32_t seed, double extent) {
  return {seed, 0, 2, extent};
}
Lines linesAcrossY(uint32_t seed, double extent) {
  return {seed, 1, 0, extent};
}

/// The streets around a clearing; there is no clearing if i0 = i1.
struct Hole {
  int i0 = 0, j0 = 0, i1 = 0, j1 = 0;
};

Hole holeAround(const Area& clearing, const Lines& xs, const Lines& ys) {
  const auto last = [](const Lines& lines, double at) {  // the last street before it
    int i = lines.begin();
    while (i + 1 < lines.end() && lines[i + 1].at + lines[i + 1].half <= at) ++i;
    return i;
  };
  const auto first = [](const Lines& lines, double at) {
    int i = lines.end() - 1;
    while (i > lines.begin() && lines[i - 1].at - lines[i - 1].half >= at) --i;
    return i;
  };
  return {last(xs, clearing.x0), last(ys, clearing.y0), first(xs, clearing.x1), first(ys, clearing.y1)};
}

/// Path through corners, which are rounded, as points half a metre apart.
std::vector<Vec3> roundedWay(const std::vector<Vec3>& corners) {
  constexpr double kRadius = 6, kStep = 0.5;
  std::vector<Vec3> points;
  const auto addLine = [&](const Vec3& from, const Vec3& to) {
    const Vec3 way = to - from;
    const int count = static_cast<int>(lengthOf(way) / kStep);
    for (int i = 0; i < count; ++i) points.push_back(from + static_cast<double>(i) / count * way);
  };
  Vec3 from = corners.front();
  for (size_t k = 1; k + 1 < corners.size(); ++k) {
    const Vec3 in = normalized(corners[k] - corners[k - 1]), out = normalized(corners[k + 1] - corners[k]);
    const Vec3 start = corners[k] - kRadius * in, centre = start + kRadius * out;
    addLine(from, start);
    constexpr int kCount = 19;
    for (int i = 0; i < kCount; ++i) {
      const double turns = 0.25 * i / kCount;
      points.push_back(centre + kRadius * (sine(turns) * in - cosine(turns) * out));
    }
    from = corners[k] + kRadius * out;
  }
  addLine(from, corners.back());
  return points;
}

}  // namespace

Area enclosedLand(uint32_t seed, const Area& clearing) {
  const double extent = 100 + std::max(std::max(-clearing.x0, clearing.x1), std::max(-clearing.y0, clearing.y1));
  const Lines xs = linesAcrossX(seed, extent), ys = linesAcrossY(seed, extent);
  const Hole hole = holeAround(clearing, xs, ys);
  return {xs[hole.i0].at + xs[hole.i0].half, ys[hole.j0].at + ys[hole.j0].half, xs[hole.i1].at - xs[hole.i1].half,
          ys[hole.j1].at - ys[hole.j1].half};
}

std::vector<Vec3> gridDrive(uint32_t seed) {
  const Lines xs = linesAcrossX(seed, 1), ys = linesAcrossY(seed, 1);
  const double right = xs[1].at, up = ys[1].at, down = ys[-1].at;
  return roundedWay(
      {{0, 0, 0}, {right, 0, 0}, {right, up, 0}, {0, up, 0}, {0, down, 0}, {right, down, 0}, {right, 0, 0}, {0, 0, 0}});
}

Plan planGrid(uint32_t seed, double extent, const Detail& detail, const std::optional<Area>& clearing) {
  const Lines xs = linesAcrossX(seed, extent), ys = linesAcrossY(seed, extent);
  const Hole hole = clearing ? holeAround(*clearing, xs, ys) : Hole{};
  Plan plan;
  for (int i = xs.begin(); i < xs.end(); ++i)
    for (int j = ys.begin(); j < ys.end(); ++j) {
      const uint64_t column = static_cast<uint64_t>(i + 4096), row = static_cast<uint64_t>(j + 4096);
      const bool inX = i >= hole.i0 && i < hole.i1, inY = j >= hole.j0 && j < hole.j1;  // for what begins here
      const bool crossingX = inX && i > hole.i0, crossingY = inY && j > hole.j0;
      if (!(crossingX && crossingY)) addCrossing(plan, xs[i], ys[j]);
      if (i + 1 < xs.end() && !(inX && crossingY))
        addRoad(plan, Dice(seed, 2, column, row), xs[i], xs[i + 1], ys[j], false, detail);
      if (j + 1 < ys.end() && !(crossingX && inY))
        addRoad(plan, Dice(seed, 3, column, row), ys[j], ys[j + 1], xs[i], true, detail);
      if (i + 1 < xs.end() && j + 1 < ys.end() && !(inX && inY)) {
        const Site site = siteBetween(seed, xs, ys, i, j);
        plan.blockReach = reachOf((site.x0 + site.x1) / 2, (site.y0 + site.y1) / 2);
        planBlock(plan, site, detail);
        planSidewalks(plan, site, detail);
      }
    }
  return plan;
}

}  // namespace gnosphere::town
