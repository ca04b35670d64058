// SPDX-License-Identifier: Apache-2.0
// The heights of a junction, whose roads overlap.
#pragma once

#include <vector>

#include "town/opendrive/network.hpp"

namespace gnosphere::town::opendrive {

/// The scalar product and the distance of points as seen from above.
double planDot(const Vec3& a, const Vec3& b);
double planDistance(const Vec3& a, const Vec3& b);

/// The two ends of a cross-section of a strip, and the strip's level direction there.
struct CrossSection {
  double s;
  Vec3 left, right, along;
};

/// The surfaces of the roads in and around a junction, as strips of quads between cross-sections. A junction has one
/// height at each point, whereas strips overlap in it.
class HeightField {
 public:
  /// Adds the surface between cross-sections that follow each other along a road.
  void add(const std::vector<CrossSection>& strip);

  /// Returns the height at a point: that of the strip there, a weighted mean where strips overlap, and a blend of the
  /// heights of the edges nearby where there is no strip.
  double at(double x, double y) const;

 private:
  static constexpr size_t kRun = 8;         ///< quads that share a bounding box
  static constexpr double kEdge = 0.01;     ///< metres by which strips are wider and longer, since corners are rounded
  static constexpr double kReach = 8;       ///< metres: edges farther away do not count, unless there is none
  static constexpr double kFarthest = 1e5;  ///< metres: no road is that far away
  static constexpr double kClosest = 0.01;  ///< metres: smaller distances do not raise a weight

  struct Quad {
    CrossSection from, to;
    double fromStart, toEnd;  ///< metres from its ends to those of the strip
    bool first, last;
  };
  /// A part of a strip with its bounding box.
  struct Run {
    size_t first, last;
    Vec3 low, high;
  };

  template <typename Visit>
  void visit(const Vec3& p, double reach, Visit&& visit) const;

  /// Weights are 0 at the lateral edges of a strip, so that the mean is continuous there, and largest at its ends,
  /// where the road that it leads to takes over its height.
  static void addInside(const Quad& quad, const Vec3& p, double& sum, double& weights);

  /// Weights an edge by the fourth power of its inverse distance, less what makes it 0 at `reach`.
  static void addEdge(const Vec3& a, const Vec3& b, const Vec3& p, double reach, double& sum, double& weights);

  std::vector<Quad> quads_;
  std::vector<Run> runs_;
};

}  // namespace gnosphere::town::opendrive
