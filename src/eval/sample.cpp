// SPDX-License-Identifier: Apache-2.0
#include "eval/sample.hpp"

#include <cmath>
#include <random>

namespace gnosphere {

Scan BeamSample::of(Scan scan) const {
  if (beams.empty()) return scan;
  Scan some;
  some.sensor = sensor.name;
  some.columns = sensor.columns;
  some.channels = static_cast<uint32_t>(beams.size());
  some.pose = scan.pose;
  for (size_t beam : beams) {
    for (size_t axis = 0; axis < 3; ++axis) some.points.push_back(scan.points[3 * beam + axis]);
    some.ranges.push_back(scan.ranges[beam]);
    some.triangles.push_back(scan.triangles[beam]);
    some.instances.push_back(scan.instances[beam]);
  }
  return some;
}

BeamSample sampleOf(const Sensor& sensor, uint64_t count, uint32_t seed) {
  BeamSample sample;
  sample.sensor = sensor;
  const uint64_t all = sensor.beamCount();
  if (count == 0 || count >= all) return sample;
  sample.sensor.columns = 1;
  sample.sensor.channels.clear();
  std::mt19937_64 random(seed);
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t first = all * i / count, last = all * (i + 1) / count;
    const uint64_t beam = first + random() % (last - first);
    const Channel& channel = sensor.channels[beam / sensor.columns];
    // A sensor of one column points to -180 degrees; the channel's own offset turns it to the beam's azimuth.
    const double column = 360.0 * static_cast<double>(beam % sensor.columns) / sensor.columns;
    sample.sensor.channels.push_back({channel.elevationDeg, std::remainder(column + channel.azimuthOffsetDeg, 360.0)});
    sample.beams.push_back(beam);
  }
  return sample;
}

}  // namespace gnosphere
