// SPDX-License-Identifier: Apache-2.0
// Sensors that see a part of the turn, and those that turn clockwise.
#include <cstring>

#include "covered_town.hpp"
#include "list_sensors.hpp"
#include "pipeline/beam_cells.hpp"
#include "pipeline/beam_places.hpp"
#include "pipeline/origin_groups.hpp"

namespace gnosphere::test {

TEST_CASE("a sector and a clockwise head have the beams of the full turn") {
  needVulkan();
  const Scene scene = coveredTown();
  Sensor turn = builtinSensor("VLP-16");
  Sensor sector = turn, clockwise = turn;
  sector.columns = turn.columns / 3;
  sector.azimuthStartDeg = -60;
  sector.azimuthSpanDeg = 120;
  clockwise.azimuthStartDeg = 180;
  clockwise.azimuthSpanDeg = -360;
  Simulator simulator = makeSimulator(scene, {turn, sector, clockwise}, optionsWith(Accuracy::standard));
  const Scan whole = simulator.scan(kPlace, 0), part = simulator.scan(kPlace, 1), reversed = simulator.scan(kPlace, 2);
  size_t different = 0;
  for (size_t j = 0; j < turn.channels.size(); ++j)
    for (uint32_t i = 0; i < turn.columns; ++i) {
      const size_t beam = j * turn.columns + i;
      const auto differs = [&](const Scan& other, size_t at) {
        return std::memcmp(&whole.ranges[beam], &other.ranges[at], 4) != 0 ||
               whole.triangles[beam] != other.triangles[at];
      };
      different += differs(reversed, j * turn.columns + (turn.columns - i) % turn.columns);
      if (i >= turn.columns / 3 && i < 2 * turn.columns / 3)
        different += differs(part, j * sector.columns + i - turn.columns / 3);
    }
  CHECK(part.beamCount() == whole.beamCount() / 3);
  CHECK(different == 0);
  requireSame(referenceOf(scene, sector, kPlace), part);
  requireSame(referenceOf(scene, clockwise, kPlace), reversed);
}

/// A third of a VLP-16's turn around this azimuth.
Sensor sectorAround(double azimuthDeg) {
  Sensor sensor = builtinSensor("VLP-16");
  sensor.columns /= 3;
  sensor.azimuthStartDeg = azimuthDeg - 60;
  sensor.azimuthSpanDeg = 120;
  return sensor;
}

/// Requires that the columns and the slabs of a frame that are said to hold all beams are the fewest that do.
void requireFewestPlaces(const BeamTables& tables) {
  const gpu::Frame& frame = tables.frame;
  const uint32_t slabs = slabsOf(frame);
  std::vector<bool> columns(frame.columns), used(slabs);
  for (size_t i = 0; i < tables.numbers.size(); ++i)
    if (tables.numbers[i] != gpu::kNone) columns[i % frame.columns] = used[i % frame.columns >> frame.slabShift] = true;
  for (uint32_t slab = 0; slab < slabs; ++slab)
    CHECK(used[slab] == ((slab + slabs - frame.slabFirst) % slabs < frame.slabCount));
  const auto at = [&](uint32_t k) { return (frame.beamColumnFirst + k) % frame.columns; };
  REQUIRE(frame.beamColumnCount > 0);
  CHECK(columns[at(0)]);
  CHECK(columns[at(frame.beamColumnCount - 1)]);
  size_t outside = 0;
  for (uint32_t k = frame.beamColumnCount; k < frame.columns; ++k) outside += columns[at(k)];
  CHECK(outside == 0);
}

TEST_CASE("the columns and slabs of a sector are those with beams, also across the seam") {
  for (const double azimuth : {0.0, 97.0, 180.0}) {
    INFO(azimuth << " degrees");
    const Sensor sensor = sectorAround(azimuth);
    const std::vector<OriginGroup> groups = originGroups(sensor, 0);
    const BeamTables tables = makeListedTables(sensor, std::vector<FiredGroup>{{0, &groups[0]}}, true)[0];
    const gpu::Frame& frame = tables.frame;
    CHECK(tables.mapped);
    CHECK(tables.ranges.empty());
    CHECK(frame.hasBeamRanges == 0);
    requireFewestPlaces(tables);
    CHECK(frame.beamColumnCount == sensor.columns);
  }
}

TEST_CASE("the beams of AT128, whose channels look beside each other, take a third of the turn") {
  const Sensor sensor = builtinSensor("AT128");
  const BeamTables tables = makeRowTables(sensor, rowGridOf(sensor).value(), originGroups(sensor, 0)[0]);
  requireFewestPlaces(tables);
  CHECK(tables.frame.beamColumnCount >= sensor.columns);
  CHECK(tables.frame.beamColumnCount < tables.frame.columns * 2 / 5);
}

TEST_CASE("a sector behind the sensor equals the reference, with every way of binning") {
  needVulkan();
  const Scene scene = coveredTown();
  const Sensor sector = sectorAround(180);
  const Scan expected = referenceOf(scene, sector, kPlace);
  for (const Binning binning : {Binning::slabs, Binning::nearest, Binning::lists})
    requireSame(expected, scanOf(scene, sector, kPlace, optionsWith(Accuracy::standard, binning)));
}

TEST_CASE("three sectors have as many candidates as the turn") {
  needVulkan();
  const Scene scene = coveredTown();
  const TestOptions options = optionsWith(Accuracy::standard, Binning::lists);
  uint64_t candidates = 0;
  for (const double azimuth : {-120.0, 0.0, 120.0})
    candidates += scanOf(scene, sectorAround(azimuth), kPlace, options).counters.candidates;
  CHECK(candidates > 0);
  CHECK(candidates == scanOf(scene, builtinSensor("VLP-16"), kPlace, options).counters.candidates);
}

}  // namespace gnosphere::test
