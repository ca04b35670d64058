// SPDX-License-Identifier: Apache-2.0
#include "town/ground.hpp"

#include <algorithm>
#include <cmath>

namespace gnosphere::town {
namespace {

constexpr int kArcSteps = 6;  ///< segments of the kerb around a corner

enum class Paint : uint8_t { none, dashed, solid };

/// A strip of carriageway that ends at `edge`; strips go across the road from right to left.
struct Strip {
  double edge;
  Paint paint;
};

std::vector<Strip> stripsOf(const Road& road) {
  const double half = road.halfWidth / 100.0;
  if (road.avenue)
    return {{-half + 0.30, Paint::none},
            {-half + 0.42, Paint::solid},
            {-half / 2 - 0.06, Paint::none},
            {-half / 2 + 0.06, Paint::dashed},
            {-0.22, Paint::none},
            {-0.10, Paint::solid},
            {0.10, Paint::none},
            {0.22, Paint::solid},
            {half / 2 - 0.06, Paint::none},
            {half / 2 + 0.06, Paint::dashed},
            {half - 0.42, Paint::none},
            {half - 0.30, Paint::solid},
            {half, Paint::none}};
  return {{-half + 2.0, Paint::none}, {-half + 2.1, Paint::solid}, {-0.06, Paint::none}, {0.06, Paint::dashed},
          {half - 2.1, Paint::none},  {half - 2.0, Paint::solid},  {half, Paint::none}};
}

/// Rotates (x, y) by quarter turns about the origin.
Vec3 quarterTurned(double x, double y, int quarters) {
  const double c = cosine(0.25 * quarters), s = sine(0.25 * quarters);
  return {c * x - s * y, s * x + c * y, 0};
}

/// Adds one arm of a crossing, along +x before its rotation: zebra, stop line. Returns where it was cut along x.
std::vector<double> addArm(MeshBuilder& builder, double start, double half, int quarters) {
  const std::vector<double> cuts = {start,       start + 0.5, start + 3.1,
                                    start + 3.5, start + 3.9, start + kCornerRadius / 100.0};
  const int bars = 2 * static_cast<int>(half / 0.75) + 1;
  for (size_t i = 0; i + 1 < cuts.size(); ++i)
    for (int bar = 0; bar < bars; ++bar) {
      const double y0 = -half + 2 * half * bar / bars, y1 = -half + 2 * half * (bar + 1) / bars;
      const bool zebra = i == 1 && bar % 2 == 1, stop = i == 3 && 2 * bar > bars;
      builder.quad(zebra || stop ? Surface::roadPaint : Surface::asphalt, quarterTurned(cuts[i], y0, quarters),
                   quarterTurned(cuts[i + 1], y0, quarters), quarterTurned(cuts[i + 1], y1, quarters),
                   quarterTurned(cuts[i], y1, quarters));
    }
  return cuts;
}

/// Adds the asphalt between two arms and the rounded kerb. Its two chains of points run around the arc's centre in
/// step.
void addCorner(MeshBuilder& builder, const std::vector<double>& xCuts, const std::vector<double>& yCuts, int quarters) {
  const double radius = kCornerRadius / 100.0;
  const Vec3 centre = {xCuts.back(), yCuts.back(), 0};
  Loop outer, arc;
  for (auto y = yCuts.rbegin(); y != yCuts.rend(); ++y) outer.push_back({xCuts.front(), *y, 0});
  for (size_t i = 1; i < xCuts.size(); ++i) outer.push_back({xCuts[i], yCuts.front(), 0});
  arc.push_back(outer.front());
  for (int i = 1; i < kArcSteps; ++i) {
    const double turns = 0.5 + 0.25 * i / kArcSteps;
    arc.push_back(centre + Vec3{radius * cosine(turns), radius * sine(turns), 0});
  }
  arc.push_back(outer.back());
  const auto progress = [&](const Vec3& p) {  // 0 where both chains start, 1 where they end
    const double dx = centre.x - p.x, dy = centre.y - p.y;
    return dy / (dx + dy);
  };
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    builder.triangle(Surface::asphalt, quarterTurned(a.x, a.y, quarters), quarterTurned(b.x, b.y, quarters),
                     quarterTurned(c.x, c.y, quarters));
  };
  size_t i = 1, j = 0;
  add(outer[0], outer[1], arc[1]);
  j = 1;
  while (i + 2 < outer.size() || j + 2 < arc.size()) {
    const bool stepOuter =
        j + 2 >= arc.size() || (i + 2 < outer.size() && progress(outer[i + 1]) <= progress(arc[j + 1]));
    if (stepOuter) {
      add(outer[i], outer[i + 1], arc[j]);
      ++i;
    } else {
      add(outer[i], arc[j + 1], arc[j]);
      ++j;
    }
  }
  add(outer[i], outer[i + 1], arc[j]);
}

/// Outline of the block, moved inwards: four rounded corners, straight sides cut about every ten metres.
Loop outline(const Block& block, double inset, double z) {
  const double width = block.width / 100.0, depth = block.depth / 100.0;
  const double radius = std::max(kCornerRadius / 100.0 - inset, 0.3), r = radius + inset;
  const Vec3 centres[4] = {{width - r, r, z}, {width - r, depth - r, z}, {r, depth - r, z}, {r, r, z}};
  Loop loop;
  for (int side = 0; side < 4; ++side) {
    const auto corner = [&](int which, int step) {
      const double turns = 0.75 + 0.25 * which + 0.25 * step / kArcSteps;
      return centres[which] + Vec3{radius * cosine(turns), radius * sine(turns), 0};
    };
    for (int step = 0; step <= kArcSteps; ++step) loop.push_back(corner(side, step));
    const Vec3 from = loop.back(), to = corner((side + 1) % 4, 0);
    const int cuts = std::max(1, (side % 2 == 0 ? block.depth : block.width) / 1000);
    for (int i = 1; i < cuts; ++i) loop.push_back(from + static_cast<double>(i) / cuts * (to - from));
  }
  return loop;
}

}  // namespace

Mesh roadMesh(const Road& road) {
  MeshBuilder builder;
  const double length = road.length / 100.0;
  const int panels = std::max(1, road.length / 300);
  const std::vector<Strip> strips = stripsOf(road);
  for (int i = 0; i < panels; ++i) {
    const double x0 = length * i / panels, x1 = length * (i + 1) / panels;
    double y = -road.halfWidth / 100.0;
    for (const Strip& strip : strips) {
      const bool painted = strip.paint == Paint::solid || (strip.paint == Paint::dashed && i % 3 == 1);
      builder.quad(painted ? Surface::roadPaint : Surface::asphalt, {x0, y, 0}, {x1, y, 0}, {x1, strip.edge, 0},
                   {x0, strip.edge, 0});
      y = strip.edge;
    }
  }
  return builder.finish(road.avenue ? "avenue" : "street");
}

Mesh crossingMesh(const Crossing& crossing) {
  MeshBuilder builder;
  const double half[2] = {crossing.halfX / 100.0, crossing.halfY / 100.0};
  std::vector<double> cuts[4];
  for (int arm = 0; arm < 4; ++arm) cuts[arm] = addArm(builder, half[arm % 2], half[1 - arm % 2], arm);
  for (int arm = 0; arm < 4; ++arm) addCorner(builder, cuts[arm], cuts[(arm + 1) % 4], arm);
  constexpr int kTiles = 4;
  for (int i = 0; i < kTiles; ++i)
    for (int j = 0; j < kTiles; ++j) {
      const double x0 = half[0] * (2.0 * i / kTiles - 1), x1 = half[0] * (2.0 * (i + 1) / kTiles - 1);
      const double y0 = half[1] * (2.0 * j / kTiles - 1), y1 = half[1] * (2.0 * (j + 1) / kTiles - 1);
      builder.quad(Surface::asphalt, {x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0});
    }
  return builder.finish("crossing");
}

Mesh blockMesh(const Block& block) {
  MeshBuilder builder;
  const double sidewalk = block.sidewalk / 100.0;
  const Loop edge = outline(block, 0, kKerbHeight);
  const Loop stone = outline(block, 0.18, kKerbHeight);
  const Loop inner = outline(block, sidewalk, kKerbHeight), deep = outline(block, sidewalk + 7, kKerbHeight);
  builder.band(Surface::kerb, outline(block, 0, -0.05), edge);
  builder.band(Surface::kerb, edge, stone);
  builder.band(Surface::paving, stone, inner);
  builder.band(block.inside, inner, deep);
  builder.fan(block.inside, deep, {block.width / 200.0, block.depth / 200.0, kKerbHeight});
  return builder.finish("block");
}

}  // namespace gnosphere::town
