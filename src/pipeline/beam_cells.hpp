// SPDX-License-Identifier: Apache-2.0
// Puts the beams of a list into the places or the cells of a grid.
#pragma once

#include "pipeline/beam_tables.hpp"
#include "pipeline/origin_groups.hpp"
#include "sensor/row_grid.hpp"

namespace gnosphere {

/// Computes the tables of a spinning head whose beams lie in places of a grid.
BeamTables makeRowTables(const Sensor& sensor, const RowGrid& grid, const OriginGroup& group);

/// Computes the tables of a group of the beams that scan number `frame` fires. If each beam lies in a place of a grid
/// of its own, as those of a sector do, and `mayMap`, the tables are those of the grid, with the numbers of the beams.
/// Otherwise the beams are sorted into cells. A cell is a row of elevations and a column of azimuths. If the beams have
/// few elevations, each is a row of its own; otherwise rows hold equally many beams. Masked beams stand behind the last
/// cell. Throws Error(invalidArgument) if there are more beams than kernels can index.
BeamTables makeListedTables(const Sensor& sensor, uint64_t frame, const OriginGroup& group, bool mayMap);

}  // namespace gnosphere
