// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "town/mesh_builder.hpp"
#include "town/opendrive/network.hpp"

namespace gnosphere::town::opendrive {

inline constexpr double kCurbHeight = 0.12;  ///< height of sidewalks if the file states none
inline constexpr double kKerbStone = 0.18;   ///< metres: the width of a kerb
inline constexpr double kSkirt = 0.6;        ///< metres by which the edges of roads extend downwards

/// A mesh placed at `at` (whole metres), without rotation.
struct GroundPiece {
  Mesh mesh;
  Vec3 at;
};

/// A lane with a visible surface, with its edges in laneEdges().
struct VisibleLane {
  size_t index;  ///< in the section
  LaneUse use;   ///< lanes of type `none` between others become carriageway
};

/// Returns the lanes of a section that have a surface at `s`, from left to right, without gaps between them.
std::vector<VisibleLane> visibleLanes(const LaneSection& section, const std::vector<double>& edges);

/// Returns where a road is cut into cross-sections: every three metres, where an entry of its profiles, of its lanes'
/// profiles or of their marks starts, at `from` and `to`, and between these wherever an edge of a lane would otherwise
/// be more than 2 cm off its chord: in bends and tapers, on crests, and where geometries of the reference line meet at
/// an angle.
std::vector<double> stations(const Road& road, double from, double to);

/// Returns the axes of the cross-section at `s`. Where geometries of the reference line meet at an angle it halves this
/// angle, and `left` is longer than 1, so that the edges of lanes before and after it meet in a corner (a mitre).
RoadFrame crossSection(const Road& road, double s);

/// Adds a quad, or a triangle or nothing if corners coincide.
void addPatch(MeshBuilder& builder, Surface surface, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Returns pieces of at most 48 m of a road outside junctions: carriageway, markings, kerbs, sidewalks.
std::vector<GroundPiece> roadPieces(const Road& road);

/// Returns the area of a junction's connecting roads as one surface, with sidewalks around it if the roads that meet
/// there have any.
std::vector<GroundPiece> junctionPieces(const Network& network, const std::string& junction);

}  // namespace gnosphere::town::opendrive
