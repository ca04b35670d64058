// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "town/mesh_builder.hpp"
#include "town/opendrive/network.hpp"

namespace gnosphere::town::opendrive {

inline constexpr double kCurbHeight = 0.12;  ///< of sidewalks for which the file states no height
inline constexpr double kSkirt = 0.6;        ///< metres that the edges of roads reach down

/// A mesh that stands at `at` (whole metres), unturned.
struct GroundPiece {
  Mesh mesh;
  Vec3 at;
};

/// A lane that is there to be seen, with its edges in laneEdges().
struct VisibleLane {
  size_t index;  ///< in the section
  LaneUse use;   ///< `none` between others has become carriageway
};

/// The lanes of a section with a surface at `s`, from left to right, without gaps between them.
std::vector<VisibleLane> visibleLanes(const LaneSection& section, const std::vector<double>& edges);

/// Where a road is cut across for triangles: every three metres, more often in bends, and at `from` and `to`.
std::vector<double> stations(const Road& road, double from, double to);

/// Adds a quad, or what is left of it where corners coincide.
void addPatch(MeshBuilder& builder, Surface surface, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Pieces of at most 48 m of a road of its own (not of a junction): carriageway, markings, kerbs, sidewalks.
std::vector<GroundPiece> roadPieces(const Road& road);

/// What the junction's connecting roads cover, as one surface, with sidewalks around it if the roads that meet there
/// have any.
std::vector<GroundPiece> junctionPieces(const Network& network, const std::string& junction);

}  // namespace gnosphere::town::opendrive
