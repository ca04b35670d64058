// SPDX-License-Identifier: Apache-2.0
// Reads calibrations of Velodyne heads. The vendor's azimuth is counted clockwise from the front of the head, and a
// laser points to the head's azimuth minus its rotation correction. The driver of ROS turns the front to x, and y to
// the left. There a laser with the corrections r and e at the head's azimuth A has the azimuth r - A and the elevation
// e, and starts at -v sin(e) forward, h to the left and v cos(e) up of the head's centre, v and h being its vertical
// and horizontal offsets.
#include <algorithm>
#include <cmath>

#include "base/units.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {

void fromVelodyneLasers(SensorSource& source, std::vector<VelodyneLaser> lasers, double distanceResolution) {
  if (lasers.empty()) source.refuse("there is no laser");
  // Rings are numbered from the bottom up, as the drivers do.
  std::stable_sort(lasers.begin(), lasers.end(),
                   [](const auto& a, const auto& b) { return a.vertCorrection < b.vertCorrection; });
  setTurn(source, 0);
  Sensor& sensor = source.file.sensor;
  for (const VelodyneLaser& laser : lasers) {
    Channel channel;
    channel.elevationDeg = kRadian * laser.vertCorrection;
    channel.azimuthOffsetDeg = kRadian * laser.rotCorrection;
    channel.origin = {-laser.vertOffset * std::sin(laser.vertCorrection), laser.horizOffset,
                      laser.vertOffset * std::cos(laser.vertCorrection)};
    sensor.channels.push_back(channel);
  }
  if (distanceResolution > 0)
    assumeRange(source, 65535 * distanceResolution, ", the most that 16 bits hold at the stated resolution");
  else
    assumeRange(source, 200);
}

}  // namespace gnosphere
