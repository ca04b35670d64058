// SPDX-License-Identifier: Apache-2.0
// The beams of a spinning head in places of a grid. A head's lasers may look beside each other and fire one after the
// other, and a turn need not be a whole number of columns. So each channel is a row with a shift of its own: its beams
// lie in the places of the grid, from a place of the row on, each up to a column or two behind its place.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {

struct RowGrid {
  /// The beams of a channel.
  struct Row {
    uint32_t channel = 0;
    int32_t first = 0;  ///< place of beam 0 in order of azimuth, -columns / 2..columns / 2; places wrap
    double behind = 0;  ///< columns by which beam 0 lies behind its place
    double lag = 0;     ///< columns of rising azimuth between a beam's own column and the one that fires with the beam
  };

  uint32_t columns = 0;    ///< places of a turn
  uint32_t taken = 0;      ///< beams of a row: the sensor's columns
  double phase = 0;        ///< azimuth of place 0 beyond -180 degrees, in columns; 0..columns
  double stretch = 0;      ///< columns by which the last beam of a row lies further behind its place than the first
  double beside = 0;       ///< most columns by which any beam lies behind its place
  bool clockwise = false;  ///< beams fire in the order of falling azimuth
  double step = 0;         ///< seconds between the columns
  std::vector<Row> rows;   ///< in order of elevation

  /// The sensor's column of beam `place` of a row in order of azimuth.
  uint32_t columnAt(uint32_t place) const { return clockwise ? taken - 1 - place : place; }
  /// Entries of the table of moments before those of the columns, for rows with a lag below 0.
  uint32_t before() const;
  /// Entries of the table of moments behind those of the columns, for rows with a lag above 0.
  uint32_t after() const;
  /// Whether the rows look in different directions at one place.
  bool between() const { return beside > 0; }
  /// Whether the beams at one place fire at different times.
  bool staggered() const;
};

/// Returns the places of a sensor's grid. Empty for a list, for a sector so small that most places would be without a
/// beam, and for more places than kernels can number.
std::optional<RowGrid> rowGridOf(const Sensor& sensor);

/// Returns the moments of a grid, in the order of azimuth: beam i of a row fires at entry i + before() + lag.
ScanTimes scanTimesOf(const RowGrid& grid, const Sensor& sensor);

}  // namespace gnosphere
