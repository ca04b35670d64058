// SPDX-License-Identifier: Apache-2.0
// Horizontal bars over a logarithmic axis as self-contained SVG.
#pragma once

#include <string>
#include <vector>

namespace gnosphere::bench {

struct Bar {
  std::string name;
  double value = 0;          ///< positive; other values are left out
  double low = 0, high = 0;  ///< ends of a whisker, if they differ; clipped at the end of the axis
};

struct BarChart {
  std::string title;
  std::vector<std::string> notes;  ///< lines under the title
  std::string xLabel;
  double mark = 1;  ///< positive value at which bars begin, with which the others are compared
  std::vector<Bar> bars;
};

std::string toSvg(const BarChart& chart);

}  // namespace gnosphere::bench
