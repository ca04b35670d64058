// SPDX-License-Identifier: Apache-2.0
// Makes the tables of a list of beams, whose beams are sorted into cells unless they lie in places of a grid.
#pragma once

#include <span>
#include <vector>

#include "pipeline/beam_tables.hpp"
#include "pipeline/origin_groups.hpp"

namespace gnosphere {

/// FiredGroup names a group of beams, and the number of a scan that fires them, which tells the pattern of the list.
struct FiredGroup {
  uint64_t frame;
  const OriginGroup* group;
};

/// Computes the tables of groups of beams. If there is one group, each of its beams lies in a place of a grid of its
/// own, as those of a sector do, and `mayMap`, the table is that of the grid, with the numbers of the beams. Otherwise
/// the beams are sorted into cells. A cell is a row of elevations and a column of azimuths. If the beams have few
/// elevations, each is a row of its own; otherwise rows hold equally many beams. Masked beams stand behind the last
/// cell. All tables have the same rows, columns and number of beams in their frames, so that they can follow each other
/// in an array; a table with fewer beams has fewer entries. Throws Error(invalidArgument) if there are more beams than
/// kernels can index.
std::vector<BeamTables> makeListedTables(const Sensor& sensor, std::span<const FiredGroup> groups, bool mayMap);

}  // namespace gnosphere
