// SPDX-License-Identifier: Apache-2.0
// Puts the beams of a list into the places or the cells of a grid.
#pragma once

#include <span>
#include <vector>

#include "pipeline/beam_tables.hpp"
#include "pipeline/origin_groups.hpp"
#include "sensor/row_grid.hpp"

namespace gnosphere {

/// Computes the tables of a spinning head whose beams lie in places of a grid.
BeamTables makeRowTables(const Sensor& sensor, const RowGrid& grid, const OriginGroup& group);

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
