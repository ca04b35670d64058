// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "town/opendrive/reference_line.hpp"

namespace gnosphere::town::opendrive {

enum class LaneUse : uint8_t {
  carriageway,  ///< driving, parking, shoulders, ...: asphalt
  sidewalk,     ///< raised behind a kerb
  verge,        ///< borders, medians: grass
  none,         ///< asphalt if it lies between other lanes, nothing if it does not
};

enum class MarkKind : uint8_t { none, solid, broken };

/// A <roadMark> from `start` metres into its lane section on. Double lines have a kind for each of the two.
struct RoadMark {
  double start = 0;
  MarkKind kind = MarkKind::none, second = MarkKind::none;  ///< from the inner line outwards
  double width = 0.12;
};

/// Everything along s is measured from the start of the lane section, in metres.
struct Lane {
  int id = 0;  ///< negative to the right of the reference line
  LaneUse use = LaneUse::none;
  bool driving = false, parking = false;
  Profile width;
  Profile border;          ///< instead of the width: the distance of its outer edge from the reference line
  Profile inner, outer;    ///< heights over the road
  bool hasHeight = false;  ///< the file states those two
  std::vector<RoadMark> marks;
  std::optional<int> predecessor, successor;
};

/// From left to right; lane 0, of no width, carries the mark of the centre.
struct LaneSection {
  double s = 0, end = 0;
  std::vector<Lane> lanes;

  const Lane* find(int id) const;
};

/// What a road's end is joined to: nothing, another road's start or end, or a junction.
struct RoadLink {
  enum Kind : uint8_t { nothing, road, junction } kind = nothing;
  std::string id;
  bool atStart = true;
};

/// A point of a road's reference line with its surface: `left` is level, or inclined by the superelevation.
struct RoadFrame {
  Vec3 at, along, left;  ///< `along` is level
  Vec3 point(double t, double height = 0) const { return at + t * left + Vec3{0, 0, height}; }
};

struct Road {
  std::string id, junction;  ///< junction: empty for a road of its own
  double length = 0;
  bool leftHand = false;  ///< traffic keeps to the left
  std::vector<Geometry> geometries;
  Profile elevation, superelevation, laneOffset;
  std::vector<LaneSection> sections;
  RoadLink predecessor, successor;

  RoadFrame frame(double s) const;
  const LaneSection& sectionAt(double s) const;
  double largestCurvature(double from, double to) const;
};

/// The edges of a section's lanes at `s`, in metres to the left of the reference line, from left to right: edge i is
/// the left one of lane i (lane 0 has both edges alike), the last is the right one of the last lane.
std::vector<double> laneEdges(const Road& road, const LaneSection& section, double s);

struct LaneLink {
  int from = 0, to = 0;
};

struct Connection {
  std::string incoming, connecting;
  bool atStart = true;  ///< of the connecting road
  std::vector<LaneLink> lanes;
};

struct Junction {
  std::string id;
  std::vector<Connection> connections;
};

/// Roads in a frame of their own, whose origin is in the middle of them; `toFile` leads to the file's, offset included.
struct Network {
  std::string file;
  std::vector<Road> roads;
  std::vector<Junction> junctions;
  Transform toFile;

  const Road* road(const std::string& id) const;
  const Junction* junction(const std::string& id) const;
};

/// Reads OpenDRIVE 1.x: plan view, elevation, superelevation, lanes and links. Objects, signals and shapes are not
/// read. Throws Error(file), or Error(format) that names the file, the road and what is wrong with it.
Network readNetwork(const std::filesystem::path& file);

}  // namespace gnosphere::town::opendrive
