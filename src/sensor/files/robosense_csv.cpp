// SPDX-License-Identifier: Apache-2.0
// RoboSense's angle.csv, as its drivers read it: a row per laser in the order of its channels, its vertical and its
// horizontal angle in degrees, without a header. Azimuths are clockwise from x, so they change their sign.
#include <algorithm>
#include <cmath>

#include "sensor/files/source.hpp"

namespace gnosphere {

void readRobosenseCsv(SensorSource& source) {
  Sensor& sensor = source.file.sensor;
  const std::vector<std::string_view> lines = linesOf(source.bytes);
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::vector<std::string_view> cells = cellsOf(lines[i]);
    if (cells[0].empty() && cells.size() == 1) continue;
    const std::string where = "line " + std::to_string(i + 1);
    if (cells.size() < 2) source.refuse(where + " has 1 cell, expected are the vertical and the horizontal angle");
    refuseSurplus(source, cells, 2, where);
    const double elevation = numberOf(source, cells[0], where + ", vertical angle");
    const double azimuth = numberOf(source, cells[1], where + ", horizontal angle");
    if (std::abs(elevation) > 90) source.refuse(where + ": the vertical angle must be -90 to 90");
    sensor.channels.push_back({elevation, -azimuth});
  }
  if (sensor.channels.empty()) source.refuse("there is no laser");
  if (sensor.channels.size() > 1024) source.refuse("has more than 1024 lasers");
  // Rings are numbered from the bottom up, as the driver does.
  std::stable_sort(sensor.channels.begin(), sensor.channels.end(),
                   [](const Channel& a, const Channel& b) { return a.elevationDeg < b.elevationDeg; });
  setTurn(source, 0);
  assumeRange(source, 200);
}

}  // namespace gnosphere
