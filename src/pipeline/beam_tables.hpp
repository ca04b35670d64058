// SPDX-License-Identifier: Apache-2.0
// Computes the beam tables that the stages read from a Sensor, in double precision on the host.
#pragma once

#include <array>
#include <vector>

#include "common/shared.h"
#include "gnosphere/sensor.hpp"

namespace gnosphere {

struct BeamTables {
  std::vector<gpu::Row> rows;  ///< one per channel, in order of elevation
  /// Per cell of elevation keys: first row in or above the cell | first row above it << 16.
  std::vector<uint32_t> rowLookup;
  std::vector<float> columns;         ///< cos, sin of the azimuth of each place, then of rows that look elsewhere
  gpu::Frame frame = {};              ///< the backend fills in capacities and the instance count
  bool between = false;               ///< rows look between the places of the grid; each has its own run of `columns`
  bool staggered = false;             ///< the beams of a place fire at different times
  bool apart = false;                 ///< lasers stand away from the point that the scan is seen from
  std::vector<gpu::vec4> rowOrigins;  ///< of a grid, per row: its laser as seen from the middle of all

  /// The beams of a list, cell by cell (`listed`) or in places of a grid (`mapped`); see arrays.h.
  bool listed = false, mapped = false;
  bool holes = false;  ///< some places have no beam
  /// The farthest-range table before anything is hit: 0 where there is no beam, otherwise kNone. Empty if there is
  /// none.
  std::vector<uint32_t> startFarthest;
  std::vector<uint32_t> cellStarts, sliceMasks, timedStarts, numbers;
  std::vector<std::array<uint32_t, 2>> timedBeams;
  uint32_t masked = 0;  ///< number of beams, at the end, that never fire
  std::vector<gpu::vec4> angles, origins;
  std::vector<gpu::vec2> ranges;  ///< empty if all beams have those of the frame

  /// Returns the number of a beam in the scan; kNone for a place without a beam.
  uint32_t numberOf(uint32_t index) const;
  /// Whether a scan of the table's range window counts this range as a return of the beam.
  bool reports(uint32_t index, float range) const;
};

/// Throws Error(invalidArgument) for more than 65,535 channels, because a box packs its rows into 16 bits each, and for
/// more than 2^25 columns.
BeamTables makeBeamTables(const Sensor& sensor);

/// Rounds to multiples of 2^-30, so that exact arithmetic on directions never underflows. The error, 5e-10 rad, is
/// negligible.
float onLattice(double value);
/// Computes the key of elevationKey() in sphere.glsl from an angle in radians.
double elevationKey(double elevation);

/// Elevation keys of the lowest and the highest beam of a row.
struct RowKeys {
  double low, high;
};
/// Computes a table of so many cells from elevation keys to rows, which are in order and do not overlap.
std::vector<uint32_t> makeRowLookup(const std::vector<RowKeys>& rows, uint32_t cells);
/// Computes the columns of a turn, and all of the frame that follows from them, from `tables.rows` and the sensor.
/// `phase` is the azimuth of column 0 beyond -180 degrees, in columns.
void setFrame(const Sensor& sensor, uint32_t columns, double phase, BeamTables& tables);
/// Computes the table from elevation keys to rows that have one elevation each.
void setRowLookup(BeamTables& tables);
/// Computes the members of the frame that the paper's bounds read. The elevations must be at even steps.
void setPaper(const Sensor& sensor, BeamTables& tables);
/// Number of slabs of a turn.
uint32_t slabsOf(const gpu::Frame& frame);
/// Returns a row without azimuth offset from its elevation in radians.
gpu::Row rowAt(double elevation, uint32_t channel);

}  // namespace gnosphere
