// SPDX-License-Identifier: Apache-2.0
// Sorts the beams of a list into the cells of a grid.
#pragma once

#include "pipeline/beam_tables.hpp"

namespace gnosphere {

/// Computes the tables of the beams that scan number `frame` fires. A cell is a row of elevations and a column of
/// azimuths. If the beams have few elevations, each is a row of its own; otherwise rows hold equally many beams. Masked
/// beams stand behind the last cell. Throws Error(invalidArgument) if there are more beams than kernels can index.
BeamTables makeListedTables(const Sensor& sensor, uint64_t frame);

}  // namespace gnosphere
