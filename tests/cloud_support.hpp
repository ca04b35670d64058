// SPDX-License-Identifier: Apache-2.0
// A cloud small enough to be checked by hand.
#pragma once

#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstring>
#include <string>

#include "bits.hpp"
#include "columns.hpp"
#include "folder.hpp"
#include "gnosphere/gnosphere.hpp"

namespace gnosphere::test {

/// A scan of three columns and two channels with one miss and every array filled.
inline Scan tiny() {
  Scan scan;
  scan.sensor = "tiny";
  scan.columns = 3;
  scan.channels = 2;
  std::vector<uint8_t> ties;
  std::vector<float> tolerances;
  for (uint32_t beam = 0; beam < 6; ++beam) {
    const auto f = static_cast<float>(beam);
    const bool hit = beam != 4;
    const float nan = -std::nanf("");  // negative, as some machines produce it
    for (float value : {f + 0.1f, -f, f * 1e-20f}) scan.points.push_back(hit ? value : nan);
    scan.ranges.push_back(hit ? f + 1 : nan);
    scan.triangles.push_back(hit ? 100 + beam : kNoTriangle);
    scan.instances.push_back(hit ? 7 : kNoTriangle);
    ties.push_back(beam == 2);
    tolerances.push_back(hit ? 1e-5f : nan);
  }
  setColumn(scan, Field::tie, ties);
  setColumn(scan, Field::tolerance, tolerances);
  return scan;
}

}  // namespace gnosphere::test
