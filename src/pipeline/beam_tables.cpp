// SPDX-License-Identifier: Apache-2.0
#include "pipeline/beam_tables.hpp"

#include <cmath>
#include <numbers>

#include "base/limits.hpp"
#include "base/units.hpp"
#include "pipeline/tuning.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {
namespace {

std::vector<gpu::Row> makeRows(const Sensor& sensor) {
  std::vector<gpu::Row> rows;
  for (const uint32_t channel : channelsByElevation(sensor))
    rows.push_back(rowAt(sensor.channels[channel].elevationDeg * kDegree, channel));
  return rows;
}

}  // namespace

float onLattice(double value) {
  constexpr double kSteps = 1 << 30;
  return static_cast<float>(std::round(value * kSteps) / kSteps);
}

double elevationKey(double elevation) {
  const double c = std::abs(std::cos(elevation)), s = std::sin(elevation);
  return s / (c + std::abs(s));
}

// Computes the table from elevation keys to rows of one elevation each.
void setRowLookup(BeamTables& tables) {
  std::vector<RowKeys> keys;
  for (const gpu::Row& row : tables.rows) keys.push_back({row.angles.z, row.angles.z});
  tables.rowLookup = makeRowLookup(keys, gpu::kRowLookupCells);
}

// Entry k is (first row not below cell k) | (first row above it << 16), with a margin for the rounding of the key.
std::vector<uint32_t> makeRowLookup(const std::vector<RowKeys>& rows, uint32_t cells) {
  std::vector<uint32_t> lookup;
  uint32_t first = 0, end = 0;
  for (uint32_t cell = 0; cell < cells; ++cell) {
    const double low = 2.0 * cell / cells - 1, high = low + 2.0 / cells;
    while (first < rows.size() && rows[first].high < low - 1e-6) ++first;
    while (end < rows.size() && rows[end].low < high + 1e-6) ++end;
    lookup.push_back(first | end << 16);
  }
  return lookup;
}

bool BeamTables::reports(uint32_t index, float range) const {
  return frame.hidesNear == 0 || range >= (ranges.empty() ? frame.rangeMin : ranges[index].x);
}

uint32_t BeamTables::numberOf(uint32_t index) const {
  return listed || mapped ? numbers[index]
                          : rows[index / frame.columns].channel * frame.columns + index % frame.columns;
}

BeamTables makeBeamTables(const Sensor& sensor) {
  limits::kChannels.check(sensor.channels.size(), "sensor '" + sensor.name + "' has");
  limits::kColumns.check(sensor.columns, "sensor '" + sensor.name + "' has");
  BeamTables tables;
  tables.rows = makeRows(sensor);
  setRowLookup(tables);
  setFrame(sensor, sensor.columns, 0, tables);
  setPaper(sensor, tables);
  return tables;
}

void setPaper(const Sensor& sensor, BeamTables& tables) {
  gpu::Frame& frame = tables.frame;
  const auto elevationOf = [&](const gpu::Row& row) { return sensor.channels[row.channel].elevationDeg * kDegree; };
  if (frame.rows > 1) {
    const double first = elevationOf(tables.rows.front()), last = elevationOf(tables.rows.back());
    frame.paperFirstElevation = static_cast<float>(first);
    frame.paperRowsPerRadian = static_cast<float>(last > first ? (frame.rows - 1) / (last - first) : 0);
  } else if (frame.rows == 1) {
    frame.paperFirstElevation = static_cast<float>(sensor.channels[0].elevationDeg * kDegree);
  }
}

gpu::Row rowAt(double elevation, uint32_t channel) {
  gpu::Row row = {};
  row.angles = {onLattice(std::cos(elevation)), onLattice(std::sin(elevation)),
                static_cast<float>(elevationKey(elevation))};
  row.channel = channel;
  return row;
}

uint32_t slabsOf(const gpu::Frame& frame) {
  return frame.columns == 0 ? 0 : ((frame.columns - 1) >> frame.slabShift) + 1;
}

void setFrame(const Sensor& sensor, uint32_t columns, double phase, BeamTables& tables) {
  for (uint32_t i = 0; i < columns; ++i) {
    const double place = i + phase < columns ? i + phase : i + phase - columns;
    const double azimuth = (-1 + 2.0 * place / columns) * std::numbers::pi;
    tables.columns.push_back(onLattice(std::cos(azimuth)));
    tables.columns.push_back(onLattice(std::sin(azimuth)));
  }
  gpu::Frame& frame = tables.frame;
  const double columnsPerRadian = columns / (2 * std::numbers::pi);
  frame.columns = columns;
  frame.phase = static_cast<float>(phase);
  frame.slabShift = slabShift(columns);
  frame.slabCount = slabsOf(frame);
  frame.beamColumnCount = columns;
  frame.views = 1;
  frame.rows = static_cast<uint32_t>(tables.rows.size());
  frame.beams = frame.scanBeams = static_cast<uint32_t>(sensor.beamCount());

  frame.rangeMin = static_cast<float>(sensor.rangeMin);
  frame.rangeMax = static_cast<float>(sensor.rangeMax);
  frame.columnsPerRadian = static_cast<float>(columnsPerRadian);
  // The slack is the angle slack plus the rounding error of a column position. That error is at most 7.5 * 2^-24 *
  // columns: the sum of all roundings when the last column of a box is found (project_triangles.comp, cull.glsl).
  // A phase of many columns rounds once more, by at most 4 * 2^-24 * columns.
  frame.columnSlack = static_cast<float>(gpu::kAzimuthSlack * columnsPerRadian + (phase < 1 ? 5e-7 : 7.5e-7) * columns);
}

}  // namespace gnosphere
