// SPDX-License-Identifier: Apache-2.0
// Puts beams into the places of a grid: those of a spinning head, and lists whose beams form a grid.
#pragma once

#include <vector>

#include "pipeline/beam_order.hpp"
#include "pipeline/beam_tables.hpp"
#include "pipeline/origin_groups.hpp"
#include "sensor/row_grid.hpp"

namespace gnosphere {

/// Computes the tables of a spinning head whose beams lie in places of a grid.
BeamTables makeRowTables(const Sensor& sensor, const RowGrid& grid, const OriginGroup& group);

/// Places the beams of a list, which are sorted by elevation into rows, in a grid. Returns false if one of them does
/// not lie in a place, or two lie in the same.
bool placeOnGrid(const Sensor& sensor, uint64_t frame, const std::vector<ListedBeam>& beams,
                 const std::vector<size_t>& ends, uint32_t columns, BeamTables& tables);

}  // namespace gnosphere
