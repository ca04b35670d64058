// SPDX-License-Identifier: Apache-2.0
#include "town/opendrive/height_field.hpp"

#include <algorithm>
#include <cmath>

#include "base/vector.hpp"

namespace gnosphere::town::opendrive {

double planDot(const Vec3& a, const Vec3& b) {
  return a.x * b.x + a.y * b.y;
}

double planDistance(const Vec3& a, const Vec3& b) {
  return std::sqrt(planDot(a - b, a - b));
}

void HeightField::add(const std::vector<CrossSection>& strip) {
  for (size_t i = 1; i < strip.size(); ++i) {
    const double fromStart = strip[i - 1].s - strip[0].s, toEnd = strip.back().s - strip[i].s;
    if ((i - 1) % kRun == 0) runs_.push_back({quads_.size(), quads_.size(), {}, {}});
    quads_.push_back({strip[i - 1], strip[i], fromStart, toEnd, i == 1, i + 1 == strip.size()});
    Run& run = runs_.back();
    for (const Vec3& p : {strip[i - 1].left, strip[i - 1].right, strip[i].left, strip[i].right}) {
      const bool first = run.first == run.last;
      run.low = first ? p : Vec3{std::min(run.low.x, p.x), std::min(run.low.y, p.y), 0};
      run.high = first ? p : Vec3{std::max(run.high.x, p.x), std::max(run.high.y, p.y), 0};
      run.last = quads_.size();
    }
  }
}

template <typename Visit>
void HeightField::visit(const Vec3& p, double reach, Visit&& visit) const {
  for (const Run& run : runs_)
    if (p.x >= run.low.x - reach && p.x <= run.high.x + reach && p.y >= run.low.y - reach && p.y <= run.high.y + reach)
      for (size_t i = run.first; i < run.last; ++i) visit(quads_[i]);
}

void HeightField::addInside(const Quad& quad, const Vec3& p, double& sum, double& weights) {
  const double ahead = planDot(p - quad.from.right, quad.from.along);
  const double behind = planDot(quad.to.right - p, quad.to.along);
  if (ahead < (quad.first ? -kEdge : 0) || (quad.last ? behind < -kEdge : behind <= 0)) return;
  const double length = ahead + behind, share = length > 0 ? std::clamp(ahead / length, 0.0, 1.0) : 0;
  const Vec3 left = quad.from.left + share * (quad.to.left - quad.from.left);
  const Vec3 right = quad.from.right + share * (quad.to.right - quad.from.right);
  const double width = planDistance(left, right);
  if (width < kEdge) return;
  const double fromRight = planDot(p - right, left - right) / width;
  const double depth = std::min(fromRight, width - fromRight) + kEdge;
  if (depth <= 0) return;
  const double toEnd = std::max(0.0, std::min(quad.fromStart + ahead, quad.toEnd + behind));
  const double weight = depth / (toEnd + kClosest);
  sum += weight * (right.z + fromRight / width * (left.z - right.z));
  weights += weight;
}

void HeightField::addEdge(const Vec3& a, const Vec3& b, const Vec3& p, double reach, double& sum, double& weights) {
  const Vec3 edge = b - a;
  const double length = planDot(edge, edge);
  const double share = length > 0 ? std::clamp(planDot(p - a, edge) / length, 0.0, 1.0) : 0;
  const double distance = planDistance(a + share * edge, p);
  if (distance >= reach) return;
  const double root = 1 / (distance * distance + kClosest * kClosest) - 1 / (reach * reach + kClosest * kClosest);
  sum += root * root * (a.z + share * edge.z);
  weights += root * root;
}

double HeightField::at(double x, double y) const {
  const Vec3 p = {x, y, 0};
  double sum = 0, weights = 0;
  visit(p, kEdge, [&](const Quad& quad) { addInside(quad, p, sum, weights); });
  for (double reach = kReach; weights == 0 && reach < kFarthest; reach *= 2)
    visit(p, reach, [&](const Quad& quad) {
      addEdge(quad.from.left, quad.to.left, p, reach, sum, weights);
      addEdge(quad.from.right, quad.to.right, p, reach, sum, weights);
    });
  return weights > 0 ? sum / weights : 0;
}

}  // namespace gnosphere::town::opendrive
