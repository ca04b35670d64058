// SPDX-License-Identifier: Apache-2.0
// Merges the overlapping connecting roads of a junction into one surface, with Clipper polygons in whole millimetres.
#include <algorithm>
#include <cmath>
#include <polyclipping/clipper.hpp>

#include "town/opendrive/road_mesh.hpp"

namespace gnosphere::town::opendrive {
namespace {

using ClipperLib::IntPoint;
using ClipperLib::Path;
using ClipperLib::Paths;

constexpr double kUnit = 1000;      ///< per metre
constexpr double kCell = 4;         ///< metres: the largest triangle, so that triangles follow the heights
constexpr double kHeal = 0.4;       ///< metres: gaps up to twice as wide are closed, and so are sharp corners
constexpr double kSmallest = 1e-3;  ///< square metres

Paths combined(ClipperLib::ClipType type, const Paths& a, const Paths& b) {
  ClipperLib::Clipper clipper;
  clipper.StrictlySimple(true);
  clipper.AddPaths(a, ClipperLib::ptSubject, true);
  clipper.AddPaths(b, ClipperLib::ptClip, true);
  Paths result;
  clipper.Execute(type, result, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
  return result;
}

Paths grown(const Paths& paths, double metres) {
  ClipperLib::ClipperOffset offset(2, 0.03 * kUnit);
  offset.AddPaths(paths, ClipperLib::jtRound, ClipperLib::etClosedPolygon);
  Paths result;
  offset.Execute(result, metres * kUnit);
  return result;
}

double cornerProduct(const IntPoint& a, const IntPoint& b, const IntPoint& c) {
  return static_cast<double>((b.X - a.X) * (c.Y - a.Y) - (b.Y - a.Y) * (c.X - a.X));
}

/// Triangulates a simple counter-clockwise polygon by ear clipping.
template <typename Emit>
void cutEars(Path polygon, Emit&& emit) {
  const auto isEar = [&](size_t i) {
    const size_t n = polygon.size();
    const IntPoint &a = polygon[(i + n - 1) % n], &b = polygon[i], &c = polygon[(i + 1) % n];
    if (cornerProduct(a, b, c) <= 0) return false;
    for (const IntPoint& p : polygon)
      if (p != a && p != b && p != c && cornerProduct(a, b, p) >= 0 && cornerProduct(b, c, p) >= 0 &&
          cornerProduct(c, a, p) >= 0)
        return false;
    return true;
  };
  while (polygon.size() >= 3) {
    size_t ear = 0;
    while (ear < polygon.size() && !isEar(ear)) ++ear;
    if (ear == polygon.size()) {  // corners are collinear or touch each other: such a corner has no area
      ear = 0;
      while (ear < polygon.size() && cornerProduct(polygon[(ear + polygon.size() - 1) % polygon.size()], polygon[ear],
                                                   polygon[(ear + 1) % polygon.size()]) > 0)
        ++ear;
      if (ear == polygon.size()) return;
    } else {
      const size_t n = polygon.size();
      emit(polygon[(ear + n - 1) % n], polygon[ear], polygon[(ear + 1) % n]);
    }
    polygon.erase(polygon.begin() + static_cast<ptrdiff_t>(ear));
  }
}

Path boxPath(const IntPoint& low, const IntPoint& high) {
  return {low, {high.X, low.Y}, high, {low.X, high.Y}};
}

/// Triangulates polygons in a box. A box that contains a hole is halved through the hole until no part contains one.
template <typename Emit>
void triangulate(const Paths& paths, const IntPoint& low, const IntPoint& high, Emit&& emit) {
  const auto hole =
      std::find_if(paths.begin(), paths.end(), [](const Path& path) { return !ClipperLib::Orientation(path); });
  if (hole == paths.end()) {
    for (const Path& path : paths) cutEars(path, emit);
    return;
  }
  const auto [left, right] =
      std::minmax_element(hole->begin(), hole->end(), [](const IntPoint& a, const IntPoint& b) { return a.X < b.X; });
  const ClipperLib::cInt middle = (left->X + right->X) / 2;
  if (middle <= low.X || middle >= high.X) return;  // the hole is narrower than a millimetre
  const IntPoint top = {middle, high.Y}, bottom = {middle, low.Y};
  triangulate(combined(ClipperLib::ctIntersection, paths, {boxPath(low, top)}), low, top, emit);
  triangulate(combined(ClipperLib::ctIntersection, paths, {boxPath(bottom, high)}), bottom, high, emit);
}

struct Box {
  IntPoint low, high;
};

Box boxOf(const Paths& paths) {
  Box box = {paths[0][0], paths[0][0]};
  for (const Path& path : paths)
    for (const IntPoint& p : path) {
      box.low = {std::min(box.low.X, p.X), std::min(box.low.Y, p.Y)};
      box.high = {std::max(box.high.X, p.X), std::max(box.high.Y, p.Y)};
    }
  return box;
}

/// Triangulates a region with triangles no larger than a grid cell.
template <typename Emit>
void cutIntoCells(const Paths& region, Emit&& emit) {
  const Box box = boxOf(region);
  const auto cell = static_cast<ClipperLib::cInt>(kCell * kUnit);
  for (ClipperLib::cInt x = box.low.X; x < box.high.X; x += cell) {
    const Paths column =
        combined(ClipperLib::ctIntersection, region, {boxPath({x, box.low.Y}, {x + cell, box.high.Y})});
    for (ClipperLib::cInt y = box.low.Y; y < box.high.Y; y += cell) {
      const IntPoint low = {x, y}, high = {x + cell, y + cell};
      triangulate(combined(ClipperLib::ctIntersection, column, {boxPath(low, high)}), low, high, emit);
    }
  }
}

/// Data to build one junction: its connecting roads, the roads that meet there, and the heights of both.
class JunctionSurface {
 public:
  JunctionSurface(const Network& network, const std::string& id) : id_(id) {
    for (const Road& road : network.roads)
      if (road.junction == id) origin_ = road.frame(0).at;
    origin_ = {std::round(origin_.x), std::round(origin_.y), std::round(origin_.z)};
    for (const Road& road : network.roads)
      if (road.junction == id) addConnecting(road);
    for (const Road& road : network.roads) {
      if (road.junction == id) continue;
      if (road.predecessor.kind == RoadLink::junction && road.predecessor.id == id) addMeeting(road, true);
      if (road.successor.kind == RoadLink::junction && road.successor.id == id) addMeeting(road, false);
    }
  }

  std::vector<GroundPiece> pieces() const {
    if (covered_.empty()) return {};
    MeshBuilder builder;
    const Paths healed = grown(grown(combined(ClipperLib::ctUnion, covered_, {}), kHeal), -kHeal);
    const Paths ownGround = combined(ClipperLib::ctDifference, healed, footprints_);
    addRegion(builder, Surface::asphalt, Surface::asphalt, ownGround, 0);
    if (sidewalk_ > 0) {
      const Paths taken = combined(ClipperLib::ctUnion, healed, footprints_);
      const Paths stone = combined(ClipperLib::ctDifference, grown(healed, kKerbStone), taken);
      addRegion(builder, Surface::kerb, Surface::kerb, stone, kCurbHeight);
      const Paths both = combined(ClipperLib::ctUnion, taken, grown(healed, kKerbStone));
      const Paths paving = combined(ClipperLib::ctDifference, grown(healed, sidewalk_), both);
      addRegion(builder, Surface::paving, Surface::kerb, paving, kCurbHeight);
    }
    if (builder.triangleCount() == 0) return {};
    return {{builder.finish("junction " + id_), origin_}};
  }

 private:
  IntPoint rounded(const Vec3& p) const {
    return {std::llround((p.x - origin_.x) * kUnit), std::llround((p.y - origin_.y) * kUnit)};
  }

  /// Adds the outline of a road's surface between two edges at each station.
  template <typename Edges>
  void addStrip(const Road& road, double from, double to, Paths& strips, Edges&& edgesAt) {
    Path outline, back;
    for (double s : stations(road, from, to)) {
      const auto [left, right] = edgesAt(s);
      const RoadFrame frame = road.frame(s);
      for (double t : {left, right}) heights_.push_back(frame.point(t));
      outline.push_back(rounded(frame.point(right)));
      back.push_back(rounded(frame.point(left)));
    }
    outline.insert(outline.end(), back.rbegin(), back.rend());
    Paths simple;
    ClipperLib::SimplifyPolygon(outline, simple, ClipperLib::pftNonZero);
    strips.insert(strips.end(), simple.begin(), simple.end());
  }

  void addConnecting(const Road& road) {
    addStrip(road, 0, road.length, covered_, [&](double s) {
      // Shoulders have the lane type `none` here: narrow lanes count as road, wide ones stand for sidewalks and lawns.
      constexpr double kShoulder = 1.5;
      const LaneSection& section = road.sectionAt(s);
      const std::vector<double> edges = laneEdges(road, section, s);
      size_t first = edges.size(), last = 0;
      for (size_t i = 0; i + 1 < edges.size(); ++i)
        if (section.lanes[i].use == LaneUse::carriageway && edges[i] - edges[i + 1] > 1e-3) {
          first = std::min(first, i);
          last = i + 1;
        }
      if (first > last) return std::pair(edges.front(), edges.front());
      const auto isShoulder = [&](size_t i) {
        return section.lanes[i].use == LaneUse::none && edges[i] - edges[i + 1] < kShoulder;
      };
      while (first > 0 && isShoulder(first - 1)) --first;
      while (last < section.lanes.size() && isShoulder(last)) ++last;
      return std::pair(edges[first], edges[last]);
    });
  }

  void addMeeting(const Road& road, bool atStart) {
    constexpr double kReach = 30;  // metres of the road into which the junction's sidewalks may reach
    const double from = atStart ? 0 : std::max(0.0, road.length - kReach);
    const double to = atStart ? std::min(kReach, road.length) : road.length;
    addStrip(road, from, to, footprints_, [&](double s) {
      const LaneSection& section = road.sectionAt(std::min(s, road.length - 1e-6));
      const std::vector<double> edges = laneEdges(road, section, s);
      const std::vector<VisibleLane> lanes = visibleLanes(section, edges);
      if (lanes.empty()) return std::pair(edges.front(), edges.front());
      for (const VisibleLane& lane : lanes)
        if (lane.use == LaneUse::sidewalk) {
          const double width = edges[lane.index] - edges[lane.index + 1];
          if (width > 0.5) sidewalk_ = sidewalk_ == 0 ? width : std::min(sidewalk_, width);
        }
      return std::pair(edges[lanes.front().index], edges[lanes.back().index + 1]);
    });
  }

  /// Interpolates heights by the fourth power of the inverse distance: exact at the edges of roads.
  double heightAt(double x, double y) const {
    double sum = 0, weights = 0;
    for (const Vec3& p : heights_) {
      const double dx = p.x - origin_.x - x, dy = p.y - origin_.y - y, square = dx * dx + dy * dy;
      const double weight = 1 / (square * square + 1e-9);
      sum += weight * (p.z - origin_.z);
      weights += weight;
    }
    return sum / weights;
  }

  Vec3 lifted(const IntPoint& p, double height) const {
    const double x = static_cast<double>(p.X) / kUnit, y = static_cast<double>(p.Y) / kUnit;
    return {x, y, heightAt(x, y) + height};
  }

  void addRegion(MeshBuilder& builder, Surface top, Surface side, const Paths& raw, double height) const {
    Paths region;
    for (const Path& path : raw)
      if (std::abs(ClipperLib::Area(path)) > kSmallest * kUnit * kUnit) region.push_back(path);
    if (region.empty()) return;
    cutIntoCells(region, [&](const IntPoint& a, const IntPoint& b, const IntPoint& c) {
      const Vec3 p = lifted(a, height), q = lifted(b, height), r = lifted(c, height);
      addPatch(builder, top, p, q, r, r);
    });
    const Vec3 down = {0, 0, -kSkirt};
    for (const Path& path : region)
      for (size_t i = 0; i < path.size(); ++i) {
        const Vec3 a = lifted(path[i], height), b = lifted(path[(i + 1) % path.size()], height);
        addPatch(builder, side, a + down, b + down, b, a);
      }
  }

  std::string id_;
  Vec3 origin_;
  Paths covered_, footprints_;
  std::vector<Vec3> heights_;
  double sidewalk_ = 0;
};

}  // namespace

std::vector<GroundPiece> junctionPieces(const Network& network, const std::string& junction) {
  return JunctionSurface(network, junction).pieces();
}

}  // namespace gnosphere::town::opendrive
