// SPDX-License-Identifier: Apache-2.0
#include "town/opendrive/terrain.hpp"

#include <algorithm>
#include <cmath>

namespace gnosphere::town::opendrive {
namespace {

constexpr double kNodeStep = 4;  ///< metres between heights, more if there would be more than kMostNodes
constexpr double kMostNodes = 1e6;
constexpr double kBelow = 0.15;  ///< metres that the ground lies below a road
constexpr double kShoulder = 5;  ///< metres beside a road where the ground keeps that distance
constexpr double kBorder = 8;    ///< metres at the border that are level
constexpr double kBelowBorder = 0.05;

/// Visits points of a road's surface, `step` metres apart, with the road's frame there.
template <typename Visit>
void forEachPoint(const Road& road, double step, double beside, Visit&& visit) {
  const int count = std::max(1, static_cast<int>(std::ceil(road.length / step)));
  for (int i = 0; i <= count; ++i) {
    const double s = std::min(road.length * i / count, road.length - 1e-6);
    const LaneSection& section = road.sectionAt(s);
    const std::vector<double> edges = laneEdges(road, section, s);
    const std::vector<VisibleLane> lanes = visibleLanes(section, edges);
    if (lanes.empty()) continue;
    const double left = edges[lanes.front().index], right = edges[lanes.back().index + 1];
    const RoadFrame frame = road.frame(s);
    const int across = 1 + static_cast<int>((left - right + 2 * beside) / step);
    for (int k = 0; k <= across; ++k) {
      const double t = right - beside + (left - right + 2 * beside) * k / across;
      visit(s, frame, t, std::clamp(t, right, left));
    }
  }
}

}  // namespace

Terrain::Terrain(const Network& network, const Area& area) : area_(area) {
  const double width = area.x1 - area.x0, depth = area.y1 - area.y0;
  const double step = std::max(kNodeStep, std::sqrt(width * depth / kMostNodes));
  columns_ = static_cast<size_t>(std::ceil(width / step));
  rows_ = static_cast<size_t>(std::ceil(depth / step));
  stepX_ = width / static_cast<double>(columns_);
  stepY_ = depth / static_cast<double>(rows_);
  heights_.assign((columns_ + 1) * (rows_ + 1), 0);
  pinned_.assign(heights_.size(), false);
  for (const Road& road : network.roads) pinUnder(road);
  pinBorder();
  stretch();
}

void Terrain::pin(size_t i, size_t j, double height) {
  const size_t n = node(i, j);
  heights_[n] = pinned_[n] ? std::min(heights_[n], height) : height;
  pinned_[n] = true;
}

void Terrain::pinBorder() {
  for (size_t j = 0; j <= rows_; ++j)
    for (size_t i = 0; i <= columns_; ++i) {
      const double inX = stepX_ * static_cast<double>(std::min(i, columns_ - i));
      const double inY = stepY_ * static_cast<double>(std::min(j, rows_ - j));
      if (std::min(inX, inY) < kBorder && !pinned_[node(i, j)]) pin(i, j, -kBelowBorder);
    }
}

void Terrain::pinUnder(const Road& road) {
  // The four heights around each point follow the slope of the road, which may be steep.
  forEachPoint(road, std::min(stepX_, stepY_) / 2, kShoulder,
               [&](double s, const RoadFrame& frame, double t, double on) {
                 const Vec3 p = frame.point(t);
                 if (!area_.contains(p.x, p.y)) return;
                 const double height = frame.point(on).z - kBelow, slope = slopeAt(road.elevation, s);
                 const size_t i = std::min(static_cast<size_t>((p.x - area_.x0) / stepX_), columns_ - 1);
                 const size_t j = std::min(static_cast<size_t>((p.y - area_.y0) / stepY_), rows_ - 1);
                 for (size_t k = 0; k < 4; ++k) {
                   const double x = area_.x0 + stepX_ * static_cast<double>(i + k % 2) - p.x;
                   const double y = area_.y0 + stepY_ * static_cast<double>(j + k / 2) - p.y;
                   pin(i + k % 2, j + k / 2, height + slope * (x * frame.along.x + y * frame.along.y));
                 }
               });
}

void Terrain::stretch() {
  // Solves Laplace's equation by successive over-relaxation: each free height becomes the mean of its neighbours.
  constexpr int kRounds = 400;
  constexpr double kOver = 1.9, kSettled = 1e-3;
  for (int round = 0; round < kRounds; ++round) {
    double largest = 0;
    for (size_t j = 1; j < rows_; ++j)
      for (size_t i = 1; i < columns_; ++i) {
        const size_t n = node(i, j);
        if (pinned_[n]) continue;
        const double mean =
            (heights_[n - 1] + heights_[n + 1] + heights_[n - columns_ - 1] + heights_[n + columns_ + 1]) / 4;
        const double change = kOver * (mean - heights_[n]);
        heights_[n] += change;
        largest = std::max(largest, std::abs(change));
      }
    if (largest < kSettled) break;
  }
}

double Terrain::at(double x, double y) const {
  const double u = std::clamp((x - area_.x0) / stepX_, 0.0, static_cast<double>(columns_) - 1e-9);
  const double v = std::clamp((y - area_.y0) / stepY_, 0.0, static_cast<double>(rows_) - 1e-9);
  const size_t i = static_cast<size_t>(u), j = static_cast<size_t>(v);
  const double fx = u - static_cast<double>(i), fy = v - static_cast<double>(j);
  const double a = heights_[node(i, j)], c = heights_[node(i + 1, j + 1)];
  const double b = heights_[node(i + 1, j)], d = heights_[node(i, j + 1)];
  // The diagonal of the cell runs from its lower left to its upper right corner.
  return fx >= fy ? a + fx * (b - a) + fy * (c - b) : a + fy * (d - a) + fx * (c - d);
}

std::vector<GroundPiece> Terrain::tiles() const {
  constexpr size_t kCells = 16;
  std::vector<GroundPiece> pieces;
  for (size_t j0 = 0; j0 < rows_; j0 += kCells)
    for (size_t i0 = 0; i0 < columns_; i0 += kCells) {
      const auto corner = [&](size_t i, size_t j) {
        return Vec3{area_.x0 + stepX_ * static_cast<double>(i), area_.y0 + stepY_ * static_cast<double>(j),
                    heights_[node(i, j)]};
      };
      const Vec3 first = corner(i0, j0), origin = {std::round(first.x), std::round(first.y), std::round(first.z)};
      MeshBuilder builder;
      for (size_t j = j0; j < std::min(j0 + kCells, rows_); ++j)
        for (size_t i = i0; i < std::min(i0 + kCells, columns_); ++i)
          builder.quad(Surface::grass, corner(i, j) - origin, corner(i + 1, j) - origin, corner(i + 1, j + 1) - origin,
                       corner(i, j + 1) - origin);
      pieces.push_back({builder.finish("ground"), origin});
    }
  return pieces;
}

Occupancy::Occupancy(const Network& network, const Area& area) : area_(area) {
  constexpr double kMostCells = 2e7;
  const double width = area.x1 - area.x0, depth = area.y1 - area.y0;
  step_ = std::max(0.5, std::sqrt(width * depth / kMostCells));
  columns_ = static_cast<size_t>(width / step_) + 1;
  rows_ = static_cast<size_t>(depth / step_) + 1;
  uses_.assign(columns_ * rows_, nothing);
  for (const Road& each : network.roads)
    forEachPoint(each, 0.8 * step_, 0.3, [&](double, const RoadFrame& frame, double t, double) {
      const Vec3 p = frame.point(t);
      if (area_.contains(p.x, p.y)) uses_[cell(p.x, p.y)] = road;
    });
}

size_t Occupancy::cell(double x, double y) const {
  return static_cast<size_t>((y - area_.y0) / step_) * columns_ + static_cast<size_t>((x - area_.x0) / step_);
}

template <typename Visit>
void Occupancy::visit(const Vec3& at, const Vec3& x, double halfLength, double halfWidth, Visit&& visit) const {
  const int along = 1 + static_cast<int>(2 * halfLength / (0.8 * step_));
  const int across = 1 + static_cast<int>(2 * halfWidth / (0.8 * step_));
  for (int i = 0; i <= along; ++i)
    for (int k = 0; k <= across; ++k) {
      const double u = halfLength * (2.0 * i / along - 1), v = halfWidth * (2.0 * k / across - 1);
      visit(at.x + u * x.x - v * x.y, at.y + u * x.y + v * x.x);
    }
}

bool Occupancy::isFree(const Vec3& at, const Vec3& x, double halfLength, double halfWidth) const {
  bool isFree = true;
  visit(at, x, halfLength, halfWidth, [&](double px, double py) {
    if (!area_.contains(px, py) || uses_[cell(px, py)] != nothing) isFree = false;
  });
  return isFree;
}

void Occupancy::take(const Vec3& at, const Vec3& x, double halfLength, double halfWidth) {
  visit(at, x, halfLength, halfWidth, [&](double px, double py) {
    if (area_.contains(px, py)) uses_[cell(px, py)] = thing;
  });
}

}  // namespace gnosphere::town::opendrive
