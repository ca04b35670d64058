// SPDX-License-Identifier: Apache-2.0
#include "eval/sample.hpp"

#include <random>

#include "scan/columns.hpp"
#include "sensor/beams.hpp"

namespace gnosphere {

Scan BeamSample::of(Scan scan) const {
  if (beams.empty()) return scan;
  Scan some;
  some.sensor = sensor.name;
  some.columns = static_cast<uint32_t>(beams.size());
  some.channels = 1;
  some.returns = scan.returns;
  some.pose = scan.pose;
  std::vector<size_t> entries;
  for (const size_t beam : beams)
    for (size_t k = 0; k < scan.returns; ++k) entries.push_back(beam * scan.returns + k);
  for (const size_t entry : entries) {
    for (size_t axis = 0; axis < 3; ++axis) some.points.push_back(scan.points[3 * entry + axis]);
    some.ranges.push_back(scan.ranges[entry]);
    some.triangles.push_back(scan.triangles[entry]);
    some.instances.push_back(scan.instances[entry]);
  }
  ScanColumns columns(some);
  const auto select = [&](Field field, auto value) {
    if (!scan.has(field)) return;
    const auto all = scan.column<decltype(value)>(field);
    columns.make(field);
    decltype(value)* const to = columns.data<decltype(value)>(field);
    for (size_t i = 0; i < entries.size(); ++i) to[i] = all[entries[i]];
  };
  select(Field::tie, uint8_t{});
  select(Field::tolerance, float{});
  select(Field::intensity, float{});
  return some;
}

BeamSample sampleOf(const Sensor& sensor, uint64_t count, uint32_t seed) {
  BeamSample sample;
  sample.sensor = sensor;
  const uint64_t all = sensor.beamCount();
  if (count == 0 || count >= all) return sample;
  const std::vector<bool> silent = silentBeams(sensor);
  std::vector<bool> sampled(all);
  std::mt19937_64 random(seed);
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t first = all * i / count, last = all * (i + 1) / count;
    sample.beams.push_back(first + random() % (last - first));
    sampled[sample.beams.back()] = !silent[sample.beams.back()];
  }
  sample.sensor.maskedBeams.clear();
  for (uint64_t beam = 0; beam < all; ++beam)
    if (!sampled[beam]) sample.sensor.maskedBeams.push_back(static_cast<uint32_t>(beam));
  return sample;
}

}  // namespace gnosphere
