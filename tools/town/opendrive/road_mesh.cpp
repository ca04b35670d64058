// SPDX-License-Identifier: Apache-2.0
#include "town/opendrive/road_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gnosphere::town::opendrive {
namespace {

constexpr double kPanel = 3;       ///< metres: a dash is one panel long, the gap after it two
constexpr double kPiece = 48;      ///< metres: the longest piece of a mesh
constexpr double kSagitta = 0.02;  ///< metres: the largest distance of a chord from its curve
constexpr double kNarrow = 1e-3;   ///< metres: a lane that is not wider than this is ignored

/// A cross-section of the road.
struct Cut {
  double s;
  RoadFrame frame;
  std::vector<double> edges;
};

/// A line along an edge: it covers from..to metres away from the edge, on one side.
struct Line {
  double from = 0, to = 0;
  bool painted = false;
};

/// Returns the mark of a lane at `ds`; null before the first.
const RoadMark* markAt(const Lane& lane, double ds) {
  const RoadMark* mark = nullptr;
  for (const RoadMark& candidate : lane.marks)
    if (candidate.start <= ds + 1e-9) mark = &candidate;
  return mark && (mark->kind != MarkKind::none || mark->second != MarkKind::none) ? mark : nullptr;
}

/// Returns the part of a lane's mark on one side of its edge: towards the reference line, or away from it (lane 0: to
/// its left, or to its right).
Line lineOf(const Lane& lane, double s, double ds, bool outwards) {
  const RoadMark* mark = markAt(lane, ds);
  if (!mark) return {};
  const bool dash = static_cast<long long>(std::floor(s / kPanel)) % 3 == 1;
  const bool isDouble = mark->second != MarkKind::none;
  const MarkKind kind = isDouble && outwards ? mark->second : mark->kind;
  const bool painted = kind == MarkKind::solid || (kind == MarkKind::broken && dash);
  if (isDouble) return {0.5 * mark->width, 1.5 * mark->width, painted};
  return {0, 0.5 * mark->width, painted};
}

double heightOf(const Lane& lane, LaneUse use, double ds, bool atLeft) {
  const bool outer = (lane.id > 0) == atLeft;
  if (lane.hasHeight) return valueAt(outer ? lane.outer : lane.inner, ds);
  return use == LaneUse::sidewalk ? kCurbHeight : 0;
}

Surface surfaceOf(LaneUse use) {
  return use == LaneUse::sidewalk ? Surface::paving : use == LaneUse::verge ? Surface::grass : Surface::asphalt;
}

/// The surface between two cross-sections of one lane section.
class Panel {
 public:
  Panel(MeshBuilder& builder, const Vec3& origin, const LaneSection& section, const Cut& from, const Cut& to)
      : builder_(builder), origin_(origin), section_(section), cuts_{&from, &to} {}

  void add() {
    std::vector<double> wider(cuts_[0]->edges.size());
    for (size_t i = 0; i < wider.size(); ++i) wider[i] = (cuts_[0]->edges[i] + cuts_[1]->edges[i]) / 2;
    const std::vector<VisibleLane> lanes = visibleLanes(section_, wider);
    for (size_t i = 0; i < lanes.size(); ++i) {
      addLane(lanes[i]);
      if (i > 0) addStep(lanes[i - 1], lanes[i]);
    }
    if (lanes.empty()) return;
    addSkirt(lanes.front(), true);
    addSkirt(lanes.back(), false);
  }

 private:
  const Lane& lane(const VisibleLane& visible) const { return section_.lanes[visible.index]; }
  double middle() const { return (cuts_[0]->s + cuts_[1]->s) / 2; }
  double edge(int end, size_t index) const { return cuts_[end]->edges[index]; }
  double height(int end, const VisibleLane& visible, bool atLeft) const {
    return heightOf(lane(visible), visible.use, cuts_[end]->s - section_.s, atLeft);
  }
  Vec3 point(int end, double t, double height) const { return cuts_[end]->frame.point(t, height) - origin_; }

  /// Returns the part of the mark along the left or right edge of a lane that lies in this lane.
  Line line(const VisibleLane& visible, bool atLeft) const {
    const int id = lane(visible).id, inner = id > 0 ? id - 1 : id + 1;
    const bool isOuter = (id > 0) == atLeft;
    const Lane* owner = section_.find(isOuter ? id : inner);
    if (!owner) return {};
    return lineOf(*owner, middle(), middle() - section_.s, owner->id == 0 ? id < 0 : !isOuter);
  }

  /// Adds the surface between two relative distances from the lane's left edge at each end, with interpolated height.
  void addBand(const VisibleLane& visible, Surface surface, const double (&left)[2], const double (&right)[2]) {
    Vec3 corners[2][2];
    for (int end = 0; end < 2; ++end) {
      const double start = edge(end, visible.index), width = start - edge(end, visible.index + 1);
      const double heightLeft = height(end, visible, true), heightRight = height(end, visible, false);
      for (int k = 0; k < 2; ++k) {
        const double away = k == 0 ? left[end] : right[end], share = width > 0 ? away / width : 0;
        corners[end][k] = point(end, start - away, heightLeft + share * (heightRight - heightLeft));
      }
    }
    addPatch(builder_, surface, corners[0][1], corners[1][1], corners[1][0], corners[0][0]);
  }

  /// A strip of a lane, which ends `distance` from the lane's left or right edge.
  struct Band {
    double distance;
    bool fromLeft;
    Surface surface;
  };

  /// Returns the strips from left to right: the surface between the marks along its edges, or behind the kerb.
  std::vector<Band> bandsOf(const VisibleLane& visible) const {
    const Surface surface = surfaceOf(visible.use);
    if (visible.use == LaneUse::sidewalk && lane(visible).id < 0)
      return {{kKerbStone, true, Surface::kerb}, {0, false, surface}};
    if (visible.use == LaneUse::sidewalk) return {{kKerbStone, false, surface}, {0, false, Surface::kerb}};
    const Line left = line(visible, true), right = line(visible, false);
    return {{left.from, true, surface},
            {left.to, true, left.painted ? Surface::roadPaint : surface},
            {right.to, false, surface},
            {right.from, false, right.painted ? Surface::roadPaint : surface},
            {0, false, surface}};
  }

  void addLane(const VisibleLane& visible) {
    double before[2] = {0, 0};
    for (const Band& band : bandsOf(visible)) {
      double here[2];
      for (int end = 0; end < 2; ++end) {
        const double width = edge(end, visible.index) - edge(end, visible.index + 1);
        const double distance = std::min(band.distance, width / 2);
        here[end] = band.fromLeft ? distance : width - distance;
      }
      addBand(visible, band.surface, before, here);  // adds nothing where the strip has no width
      std::copy(here, here + 2, before);
    }
  }

  /// Adds the vertical face between two neighbours of different heights.
  void addStep(const VisibleLane& left, const VisibleLane& right) {
    Vec3 high[2], low[2];
    for (int end = 0; end < 2; ++end) {
      const double t = edge(end, right.index);
      high[end] = point(end, t, height(end, left, false));
      low[end] = point(end, t, height(end, right, true));
    }
    if (high[0].z + high[1].z >= low[0].z + low[1].z)
      addPatch(builder_, Surface::kerb, low[0], low[1], high[1], high[0]);
    else
      addPatch(builder_, Surface::kerb, high[1], high[0], low[0], low[1]);
  }

  void addSkirt(const VisibleLane& visible, bool atLeft) {
    const Surface surface = visible.use == LaneUse::sidewalk ? Surface::kerb : surfaceOf(visible.use);
    Vec3 high[2], low[2];
    for (int end = 0; end < 2; ++end) {
      const double t = edge(end, visible.index + (atLeft ? 0 : 1));
      high[end] = point(end, t, height(end, visible, atLeft));
      low[end] = high[end] - Vec3{0, 0, kSkirt};
    }
    if (atLeft)
      addPatch(builder_, surface, low[1], low[0], high[0], high[1]);
    else
      addPatch(builder_, surface, low[0], low[1], high[1], high[0]);
  }

  MeshBuilder& builder_;
  Vec3 origin_;
  const LaneSection& section_;
  const Cut* cuts_[2];
};

/// Where a part of a road is cut into cross-sections.
class Stations {
 public:
  Stations(const Road& road, double from, double to) : road_(road), from_(from), to_(to) {}

  std::vector<double> list() {
    addBreaks();
    addJoints();
    std::vector<double> fixed;
    for (const Break& each : breaks_) fixed.push_back(each.s);
    for (double panel = std::ceil(from_ / kPanel) * kPanel; panel < to_; panel += kPanel) {
      const auto next = std::lower_bound(breaks_.begin(), breaks_.end(), panel,
                                         [](const Break& each, double s) { return each.s < s; });
      if (next == breaks_.begin() || next == breaks_.end()) continue;
      if (panel > next[-1].s + next[-1].reach && panel < next->s - next->reach) fixed.push_back(panel);
    }
    std::sort(fixed.begin(), fixed.end());
    for (size_t i = 0; i + 1 < fixed.size(); ++i) {
      stations_.push_back(fixed[i]);
      refine(fixed[i], fixed[i + 1]);
    }
    stations_.push_back(to_);
    return std::move(stations_);
  }

 private:
  static constexpr double kSame = 1e-3;      // metres: breaks that are closer together than this are one
  static constexpr double kApart = 0.05;     // metres: the least distance of other stations from a break
  static constexpr double kShortest = 0.15;  // metres between stations, but for breaks and joints

  /// A station that a road needs, and how many metres other stations keep away from it.
  struct Break {
    double s = 0, reach = kApart;
  };

  void addBreak(double s, double reach = kApart) {
    if (s > from_ + kSame && s < to_ - kSame) breaks_.push_back({s, reach});
  }

  void addBreaks() {
    const auto addStarts = [&](const Profile& profile, double start) {
      for (const Cubic& cubic : profile) addBreak(start + cubic.start);
    };
    for (const Profile* profile : {&road_.elevation, &road_.superelevation, &road_.laneOffset}) addStarts(*profile, 0);
    for (const LaneSection& section : road_.sections) {
      if (section.end < from_ || section.s > to_) continue;
      for (const Lane& lane : section.lanes) {
        for (const Profile* profile : {&lane.width, &lane.border, &lane.inner, &lane.outer})
          addStarts(*profile, section.s);
        for (const RoadMark& mark : lane.marks) addBreak(section.s + mark.start);
      }
    }
  }

  /// Notes the joints of geometries. Joints that shift the edges of lanes by more than kApart are breaks: behind the
  /// mitre, a cross-section would lie in the other geometry's part of the road.
  void addJoints() {
    for (size_t i = 1; i < road_.geometries.size(); ++i) {
      const double s = road_.geometries[i].s;
      if (s < from_ + kSame || s > to_ - kSame || (!joints_.empty() && s < joints_.back() + kSame)) continue;
      joints_.push_back(s);
      const RoadFrame frame = crossSection(road_, s);
      const std::vector<double> edges = laneEdges(road_, road_.sectionAt(s), s);
      const double length = lengthOf(frame.left);  // 1 / cos(half the angle)
      const double tangent = std::sqrt(std::max(length * length - 1, 0.0));
      const double reach = tangent * std::max(std::abs(edges.front()), std::abs(edges.back()));
      if (reach > kApart) addBreak(s, reach);
    }
    breaks_.push_back({from_});
    std::sort(breaks_.begin(), breaks_.end(),
              [](const Break& a, const Break& b) { return a.s != b.s ? a.s < b.s : a.reach > b.reach; });
    breaks_.erase(
        std::unique(breaks_.begin(), breaks_.end(), [](const Break& a, const Break& b) { return b.s - a.s < kSame; }),
        breaks_.end());
    breaks_.push_back({to_});
  }

  /// Returns the points of a section's edges on its cross-section at `s`.
  std::vector<Vec3> edgesAt(const LaneSection& section, double s) const {
    const RoadFrame frame = crossSection(road_, s);
    std::vector<Vec3> points;
    for (double t : laneEdges(road_, section, s)) points.push_back(frame.point(t));
    return points;
  }

  /// Adds the stations between two others that the edges of lanes need to stay within kSagitta of their chords.
  void refine(double from, double to) {
    const bool isLong = to - from > 2 * kShortest;
    const auto first = std::upper_bound(joints_.begin(), joints_.end(), from + kSame);
    const auto last = std::lower_bound(first, joints_.end(), to - kSame);
    std::vector<double> samples(first, last);
    if (isLong)
      for (double share : {0.5, 0.25, 0.75}) samples.push_back(from + share * (to - from));
    if (samples.empty()) return;
    const LaneSection& section = road_.sectionAt((from + to) / 2);
    const std::vector<Vec3> before = edgesAt(section, from), after = edgesAt(section, to);
    double worst = kSagitta;
    const double* cut = nullptr;
    for (const double& s : samples) {
      const std::vector<Vec3> here = edgesAt(section, s);
      for (size_t i = 0; i < here.size(); ++i) {
        const double off = distanceFromChord(here[i], before[i], after[i]);
        if (off <= worst) continue;
        worst = off;
        cut = &s;
      }
    }
    if (!cut) return;
    const bool isJoint = cut < samples.data() + (last - first);
    if (!isJoint && !isLong) return;
    const double s = isJoint ? *cut : (from + to) / 2;
    refine(from, s);
    stations_.push_back(s);
    refine(s, to);
  }

  /// Returns the distance from the line through two points. Next to a mitre points of an edge may lie behind the ends.
  static double distanceFromChord(const Vec3& p, const Vec3& from, const Vec3& to) {
    const Vec3 chord = to - from, way = p - from;
    const double square = dot(chord, chord);
    return lengthOf(way - (square > 0 ? dot(way, chord) / square : 0) * chord);
  }

  const Road& road_;
  double from_, to_;
  std::vector<Break> breaks_;     // ascending, with from_ and to_
  std::vector<double> joints_;    // where geometries of the reference line meet
  std::vector<double> stations_;  // the result
};

/// Closes the end of a road without a successor, so that its surface cannot be seen from below.
void addCap(MeshBuilder& builder, const Vec3& origin, const Cut& cut, bool atStart) {
  const double left = cut.edges.front(), right = cut.edges.back();
  const Vec3 a = cut.frame.point(left) - origin, b = cut.frame.point(right) - origin, down = {0, 0, -kSkirt};
  if (atStart)
    addPatch(builder, Surface::asphalt, a + down, b + down, b, a);
  else
    addPatch(builder, Surface::asphalt, b + down, a + down, a, b);
}

}  // namespace

std::vector<VisibleLane> visibleLanes(const LaneSection& section, const std::vector<double>& edges) {
  std::vector<VisibleLane> lanes;
  size_t sound = 0;  // lanes up to the last one that is not a gap
  for (size_t i = 0; i < section.lanes.size(); ++i) {
    const LaneUse use = section.lanes[i].use;
    if (edges[i] - edges[i + 1] <= kNarrow || (use == LaneUse::none && lanes.empty())) continue;
    lanes.push_back({i, use == LaneUse::none ? LaneUse::carriageway : use});
    if (use != LaneUse::none) sound = lanes.size();
  }
  lanes.resize(sound);
  return lanes;
}

RoadFrame crossSection(const Road& road, double s) {
  constexpr double kBefore = 1e-6;  // metres: so far before a joint the geometry before it still applies
  constexpr double kSmooth = 1e-4;  // radians: a smaller angle between geometries is rounding, or a bend
  constexpr double kLongest = 2;    // the longest mitre: of geometries that meet at 120 degrees
  RoadFrame frame = road.frame(s);
  const Vec3 before = road.frame(std::max(s - kBefore, 0.0)).along;
  if (lengthOf(frame.along - before) < kSmooth) return frame;
  // Half the sum of unit vectors is as long as the cosine of half the angle between them.
  const Vec3 half = 0.5 * (before + frame.along);
  const double cosineOfHalf = std::max(lengthOf(half), 1 / kLongest), level = lengthOf(frame.left.x, frame.left.y);
  frame.along = lengthOf(half) > kSmooth ? normalized(half) : frame.along;
  frame.left = level / cosineOfHalf * Vec3{-frame.along.y, frame.along.x, 0} + Vec3{0, 0, frame.left.z};
  return frame;
}

std::vector<double> stations(const Road& road, double from, double to) {
  return Stations(road, from, to).list();
}

void addPatch(MeshBuilder& builder, Surface surface, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  constexpr double kThin = 1e-5;  // square metres
  const auto add = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
    const Vec3 n = cross(q - p, r - p);
    if (dot(n, n) > kThin * kThin) builder.triangle(surface, p, q, r);
  };
  add(a, b, c);
  add(a, c, d);
}

std::vector<GroundPiece> roadPieces(const Road& road) {
  std::vector<GroundPiece> pieces;
  for (const LaneSection& section : road.sections) {
    const double end = std::min(section.end, road.length);
    const int count = std::max(1, static_cast<int>(std::ceil((end - section.s) / kPiece)));
    for (int i = 0; i < count; ++i) {
      const double from = section.s + (end - section.s) * i / count;
      const double to = section.s + (end - section.s) * (i + 1) / count;
      if (to - from < 0.01) continue;
      const Vec3 at = road.frame(from).at;
      const Vec3 origin = {std::round(at.x), std::round(at.y), std::round(at.z)};
      MeshBuilder builder;
      Cut before = {from, crossSection(road, from), laneEdges(road, section, from)};
      if (from == 0 && road.predecessor.kind == RoadLink::nothing) addCap(builder, origin, before, true);
      const std::vector<double> cuts = stations(road, from, to);
      for (size_t k = 1; k < cuts.size(); ++k) {
        Cut cut = {cuts[k], crossSection(road, cuts[k]), laneEdges(road, section, cuts[k])};
        Panel(builder, origin, section, before, cut).add();
        before = std::move(cut);
      }
      if (to == road.length && road.successor.kind == RoadLink::nothing) addCap(builder, origin, before, false);
      if (builder.triangleCount() > 0) pieces.push_back({builder.finish("road " + road.id), origin});
    }
  }
  return pieces;
}

}  // namespace gnosphere::town::opendrive
