// SPDX-License-Identifier: Apache-2.0
// Merges the overlapping connecting roads of a junction into one surface, with Clipper polygons in whole millimetres.
#include <algorithm>
#include <cmath>
#include <map>
#include <polyclipping/clipper.hpp>
#include <utility>

#include "town/opendrive/height_field.hpp"
#include "town/opendrive/road_mesh.hpp"

namespace gnosphere::town::opendrive {
namespace {

using ClipperLib::IntPoint;
using ClipperLib::Path;
using ClipperLib::Paths;

constexpr double kUnit = 1000;      ///< per metre
constexpr double kCell = 4;         ///< metres: the grid into which surfaces are cut
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

/// Triangulates the part of a region in a box of whole cells of a grid. Each triangle lies in one cell.
template <typename Emit>
void cutIntoCells(const Paths& region, const Box& box, Emit&& emit) {
  constexpr auto kSize = static_cast<ClipperLib::cInt>(kCell * kUnit);
  if (region.empty()) return;
  const ClipperLib::cInt columns = (box.high.X - box.low.X) / kSize, rows = (box.high.Y - box.low.Y) / kSize;
  if (columns <= 1 && rows <= 1) return triangulate(region, box.low, box.high, emit);
  Box first = box, second = box;
  if (columns > rows)
    first.high.X = second.low.X = box.low.X + columns / 2 * kSize;
  else
    first.high.Y = second.low.Y = box.low.Y + rows / 2 * kSize;
  for (const Box& half : {first, second})
    cutIntoCells(combined(ClipperLib::ctIntersection, region, {boxPath(half.low, half.high)}), half, emit);
}

template <typename Emit>
void cutIntoCells(const Paths& region, Emit&& emit) {
  constexpr auto kSize = static_cast<ClipperLib::cInt>(kCell * kUnit);
  const auto cellOf = [](ClipperLib::cInt x) { return x >= 0 ? x / kSize : (x + 1) / kSize - 1; };
  const auto [low, high] = boxOf(region);
  cutIntoCells(
      region,
      {{cellOf(low.X) * kSize, cellOf(low.Y) * kSize}, {(cellOf(high.X) + 1) * kSize, (cellOf(high.Y) + 1) * kSize}},
      emit);
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

  std::vector<GroundPiece> pieces() {
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
  static IntPoint rounded(const Vec3& p) { return {std::llround(p.x * kUnit), std::llround(p.y * kUnit)}; }

  /// Adds a road's surface between two edges at each station, which are those of the lane section there.
  template <typename Edges>
  void addStrip(const Road& road, double from, double to, bool connecting, Edges&& edgesAt) {
    std::vector<CrossSection> strip;
    for (const LaneSection& section : road.sections) {
      const double first = std::max(from, section.s), last = std::min({to, section.end, road.length});
      if (first >= last) continue;
      for (double s : stations(road, first, last)) {
        const auto [left, right] = edgesAt(section, laneEdges(road, section, s));
        const RoadFrame frame = crossSection(road, s);
        strip.push_back({s, frame.point(left) - origin_, frame.point(right) - origin_, frame.along});
      }
    }
    heights_.add(strip);
    Path outline;
    for (const CrossSection& each : strip) outline.push_back(rounded(each.right));
    for (auto each = strip.rbegin(); each != strip.rend(); ++each) outline.push_back(rounded(each->left));
    Paths simple, &strips = connecting ? covered_ : footprints_;
    ClipperLib::SimplifyPolygon(outline, simple, ClipperLib::pftNonZero);
    strips.insert(strips.end(), simple.begin(), simple.end());
  }

  void addConnecting(const Road& road) {
    addStrip(road, 0, road.length, true, [&](const LaneSection& section, const std::vector<double>& edges) {
      // Shoulders have the lane type `none` here: narrow lanes count as road, wide ones stand for sidewalks and lawns.
      constexpr double kShoulder = 1.5;
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
    addStrip(road, from, to, false, [&](const LaneSection& section, const std::vector<double>& edges) {
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

  Vec3 onSurface(double x, double y) const { return {x, y, heights_.at(x, y)}; }
  Vec3 onSurface(const IntPoint& p) const {
    return onSurface(static_cast<double>(p.X) / kUnit, static_cast<double>(p.Y) / kUnit);
  }

  /// Whether an edge is too long to follow the heights. The answer does not depend on the order of the points, so
  /// triangles on both sides of an edge are divided alike there, and their parts meet.
  bool isTooLong(const Vec3& a, const Vec3& b) {
    const Vec3 middle = 0.5 * (a + b);
    double size = kCell;
    for (const Vec3& p : {a, middle, b})
      for (double dx : {-1e-6, 1e-6})  // the point may lie on the border of two cells
        for (double dy : {-1e-6, 1e-6}) size = std::min(size, sizeAt(p.x + dx, p.y + dy));
    return planDistance(a, b) > 1.5 * size;
  }

  /// Returns the size of triangles in the cell of a point with which they follow its heights.
  double sizeAt(double x, double y) {
    const auto column = static_cast<long>(std::floor(x / kCell)), row = static_cast<long>(std::floor(y / kCell));
    const auto [found, isNew] = sizes_.try_emplace({column, row}, kCell);
    if (isNew) found->second = sizeOf(kCell * static_cast<double>(column), kCell * static_cast<double>(row));
    return found->second;
  }

  double sizeOf(double x0, double y0) const {
    constexpr double kOff = 0.01, kSmallestSize = 0.5;  // metres
    double size = kCell;
    for (int parts = 2; size > kSmallestSize; parts *= 2, size /= 2) {
      // Triangles are small enough if each point of a grid has the mean height of its neighbours on both sides.
      const int points = parts + 1;
      std::vector<double> z;
      for (int j = 0; j < points; ++j)
        for (int i = 0; i < points; ++i) z.push_back(heights_.at(x0 + kCell * i / parts, y0 + kCell * j / parts));
      const auto at = [&](int i, int j) { return z[static_cast<size_t>(j * points + i)]; };
      double off = 0;
      for (int j = 0; j < points; ++j)
        for (int i = 0; i < points; ++i)
          for (const auto& [di, dj] : {std::pair(1, 0), {0, 1}, {1, 1}, {1, -1}})
            if (i >= di && i + di < points && std::min(j - dj, j + dj) >= 0 && std::max(j - dj, j + dj) < points)
              off = std::max(off, std::abs((at(i - di, j - dj) + at(i + di, j + dj)) / 2 - at(i, j)));
      if (off < kOff) break;
    }
    return size;
  }

  Vec3 between(const Vec3& a, const Vec3& b) const { return onSurface(0.5 * (a.x + b.x), 0.5 * (a.y + b.y)); }

  /// Halves an edge until its parts follow the heights.
  template <typename Emit>
  void divide(const Vec3& a, const Vec3& b, Emit&& emit) {
    if (!isTooLong(a, b)) return emit(a, b);
    const Vec3 middle = between(a, b);
    divide(a, middle, emit);
    divide(middle, b, emit);
  }

  /// Halves the edges of a triangle, the longest first, until all follow the heights.
  template <typename Emit>
  void divide(const Vec3& a, const Vec3& b, const Vec3& c, Emit&& emit) {
    const Vec3 corners[] = {a, b, c};
    double longest = 0;
    size_t chosen = 0;
    for (size_t i = 0; i < 3; ++i) {
      const Vec3 &p = corners[i], &q = corners[(i + 1) % 3];
      const double length = planDistance(p, q);
      if (length <= longest || !isTooLong(p, q)) continue;
      longest = length;
      chosen = i;
    }
    if (longest == 0) return emit(a, b, c);
    const Vec3 &p = corners[chosen], &q = corners[(chosen + 1) % 3], &r = corners[(chosen + 2) % 3];
    const Vec3 middle = between(p, q);
    divide(p, middle, r, emit);
    divide(middle, q, r, emit);
  }

  void addRegion(MeshBuilder& builder, Surface top, Surface side, const Paths& raw, double height) {
    Paths region;
    for (const Path& path : raw)
      if (std::abs(ClipperLib::Area(path)) > kSmallest * kUnit * kUnit) region.push_back(path);
    if (region.empty()) return;
    const Vec3 up = {0, 0, height}, down = {0, 0, -kSkirt};
    cutIntoCells(region, [&](const IntPoint& a, const IntPoint& b, const IntPoint& c) {
      divide(onSurface(a), onSurface(b), onSurface(c), [&](const Vec3& p, const Vec3& q, const Vec3& r) {
        addPatch(builder, top, p + up, q + up, r + up, r + up);
      });
    });
    for (const Path& path : region)
      for (size_t i = 0; i < path.size(); ++i)
        divide(onSurface(path[i]), onSurface(path[(i + 1) % path.size()]), [&](const Vec3& a, const Vec3& b) {
          addPatch(builder, side, a + up + down, b + up + down, b + up, a + up);
        });
  }

  std::string id_;
  Vec3 origin_;
  Paths covered_, footprints_;
  HeightField heights_;
  std::map<std::pair<long, long>, double> sizes_;  ///< of triangles in each cell, as far as known
  double sidewalk_ = 0;
};

}  // namespace

std::vector<GroundPiece> junctionPieces(const Network& network, const std::string& junction) {
  return JunctionSurface(network, junction).pieces();
}

}  // namespace gnosphere::town::opendrive
