// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "town/opendrive/reference_line.hpp"

namespace gnosphere::town::opendrive {

enum class LaneUse : uint8_t {
  carriageway,  ///< asphalt: driving, parking, shoulders, ...
  sidewalk,     ///< raised behind a kerb
  verge,        ///< grass: borders, medians
  none,         ///< asphalt between other lanes, else nothing
};

enum class MarkKind : uint8_t { none, solid, broken };

/// A <roadMark>, from `start` metres into its lane section. Double lines have a kind for each of the two lines.
struct RoadMark {
  double start = 0;
  MarkKind kind = MarkKind::none, second = MarkKind::none;  ///< from the inner line outwards
  double width = 0.12;
};

/// A lane of a section. Distances along s are measured from the start of the section, in metres.
struct Lane {
  int id = 0;  ///< negative to the right of the reference line
  LaneUse use = LaneUse::none;
  bool driving = false, parking = false;
  bool reversed = false;  ///< traffic goes against the usual direction of this side of the road
  Profile width;
  Profile border;          ///< replaces the width: distance of the outer edge from the reference line
  Profile inner, outer;    ///< heights above the road
  bool hasHeight = false;  ///< whether the file states these two heights
  std::vector<RoadMark> marks;
  std::optional<int> predecessor, successor;
};

/// The lanes of a stretch of road, from left to right; lane 0 has no width and carries the centre mark.
struct LaneSection {
  double s = 0, end = 0;
  std::vector<Lane> lanes;

  const Lane* find(int id) const;
};

/// The neighbour of a road's end: none, another road's start or end, or a junction.
struct RoadLink {
  enum Kind : uint8_t { nothing, road, junction } kind = nothing;
  std::string id;
  bool atStart = true;
};

/// A point of a road's reference line with the road's axes there: `left` is level, or inclined by the superelevation.
struct RoadFrame {
  Vec3 at, along, left;  ///< `along` is level
  Vec3 point(double t, double height = 0) const { return at + t * left + Vec3{0, 0, height}; }
};

struct Road {
  std::string id, junction;  ///< junction: empty for a road outside junctions
  double length = 0;
  bool leftHand = false;  ///< traffic drives on the left
  std::vector<Geometry> geometries;
  Profile elevation, superelevation, laneOffset;
  std::vector<LaneSection> sections;
  RoadLink predecessor, successor;

  RoadFrame frame(double s) const;
  const LaneSection& sectionAt(double s) const;
  /// Whether traffic on a lane goes towards larger s.
  bool isForward(const Lane& lane) const { return ((lane.id < 0) != leftHand) != lane.reversed; }
};

/// Returns the edges of a section's lanes at `s`, in metres to the left of the reference line, from left to right: edge
/// i is the left edge of lane i (both edges of lane 0 are equal), the last is the right edge of the last lane.
std::vector<double> laneEdges(const Road& road, const LaneSection& section, double s);

/// A place in the middle of a lane, on the road's surface, with unit vectors along the lane and upright on it. Both are
/// inclined as the road is there: by its slope, its superelevation and the lane's heights.
struct LaneMiddle {
  Vec3 at, along, up;
};

/// Returns the middle of lane number `index` of a section; `along` points towards larger s. The slope is measured
/// between the axles of a vehicle.
LaneMiddle laneMiddle(const Road& road, const LaneSection& section, size_t index, double s);

struct LaneLink {
  int from = 0, to = 0;
};

struct Connection {
  std::string incoming, connecting;
  bool atStart = true;  ///< which end of the connecting road is linked
  std::vector<LaneLink> lanes;
};

struct Junction {
  std::string id;
  std::vector<Connection> connections;
};

/// Roads in local coordinates with the origin in their middle; `toFile` transforms to the file's coordinates, offset
/// included.
struct Network {
  std::string file;
  std::vector<Road> roads;
  std::vector<Junction> junctions;
  Transform toFile;
  std::string offset;                 ///< the words for the header's offset; empty if it has none
  std::vector<std::string> warnings;  ///< lines about what the file lacks, or what is not read of it

  const Road* road(const std::string& id) const;
  const Junction* junction(const std::string& id) const;
};

/// Returns warnings of gaps in reference lines and of links to roads and junctions that a network does not have.
std::vector<std::string> doubtsOf(const Network& network);

/// Reads OpenDRIVE 1.x: plan view, elevation, superelevation, lanes and links. Objects, signals and shapes are ignored.
/// Throws Error(file), or Error(format) that names the file, the road and the mistake.
Network readNetwork(const std::filesystem::path& file);

}  // namespace gnosphere::town::opendrive
