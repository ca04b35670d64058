// SPDX-License-Identifier: Apache-2.0
// Horizontal bars as self-contained SVG, over a logarithmic axis: what is compared has a name rather than a place on
// another one.
#pragma once

#include <string>
#include <vector>

namespace gnosphere::bench {

struct Bar {
  std::string name;
  double value = 0;          ///< positive; what is not is left out
  double low = 0, high = 0;  ///< a whisker, where they differ; cut off at the axis' end
};

struct BarChart {
  std::string title;
  std::vector<std::string> notes;  ///< lines under the title
  std::string xLabel;
  double mark = 1;  ///< where bars begin: the value that they are measured by; positive
  std::vector<Bar> bars;
};

std::string toSvg(const BarChart& chart);

}  // namespace gnosphere::bench
