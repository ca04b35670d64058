// SPDX-License-Identifier: Apache-2.0
// The example of docs/api.md, "Results": everything below the include lines is the page's text.
#pragma once

#include <gnosphere/gnosphere.hpp>

using namespace gnosphere;

/// How strong what came back is on average.
double meanIntensity(const Scan& scan) {
  const auto intensities = scan.column<float>(Field::intensity);
  double sum = 0, count = 0;
  for (size_t i = 0; i < intensities.size(); ++i)
    if (scan.returned(i)) sum += intensities[i], ++count;
  return count > 0 ? sum / count : 0;
}

/// The data of a ROS PointCloud2 of x, y, z and intensity, with what came back.
std::vector<std::byte> pointCloud(const Scan& scan) {
  RecordLayout layout;
  layout.values = {{Field::x, 0, 0}, {Field::y, 0, 4}, {Field::z, 0, 8}, {Field::intensity, 0, 16}};
  layout.stride = 32;
  layout.compact = true;
  std::vector<std::byte> rows(scan.ranges.size() * layout.stride);
  rows.resize(pack(scan, layout, rows) * layout.stride);
  return rows;
}
