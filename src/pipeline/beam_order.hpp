// SPDX-License-Identifier: Apache-2.0
// Sorts the beams of a list by elevation, and finds the rows and the columns that suit them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// A beam of a list: its angles, its number, and the cell in which it lies once it is sorted into cells.
struct ListedBeam {
  double azimuth, elevation;  ///< in radians
  uint32_t number, row, column;
};

/// A list may have so many cells or places per beam, or so many in total if that is more.
constexpr uint64_t kCellsPerBeam = 4, kLeastCells = 1 << 16;

/// Returns beams in order of elevation.
std::vector<ListedBeam> sortedBeams(const Sensor& sensor, uint64_t frame, const std::vector<uint32_t>& numbers);
/// Returns for each row the number of beams up to its end; `beams` are sorted by elevation. If the beams have few
/// elevations, each is a row of its own; otherwise rows hold equally many beams.
std::vector<size_t> rowEnds(const std::vector<ListedBeam>& beams);
/// Returns the most columns in a turn. Cells take memory, so there are no more than a few per beam.
uint32_t mostColumns(uint64_t beams, uint64_t rows);
/// Returns the number of columns in a turn: about one beam per cell in the row with most beams. The median of the gaps
/// finds the columns of a grid exactly, also of one that covers only a sector.
uint32_t columnCount(const std::vector<ListedBeam>& beams, const std::vector<size_t>& ends);

}  // namespace gnosphere
