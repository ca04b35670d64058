// SPDX-License-Identifier: Apache-2.0
// Logarithmic plots as self-contained SVG, readable without colour because markers and dashes differ, too. A
// logarithmic axis has no 0, so zeros are drawn in a separate band below it.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace gnosphere::cli {

struct PlotPoint {
  double x = 0;                ///< positive
  double y = 0;                ///< 0 is drawn in the band; values that are not finite are left out
  double xLow = 0, xHigh = 0;  ///< a bar across the point, if they differ
  std::string label;
};

enum class Marker { cross, triangle, circle, square, diamond };

/// Points that share a name in the legend.
struct PlotSeries {
  std::string name;
  Marker marker = Marker::circle;
  std::string colour = "#222222";
  std::string dash;  ///< of the line that joins the points, as in SVG: "4 2"; "none": no line
  double size = 5;   ///< half the width of the marker in pixels
  std::vector<PlotPoint> points;
};

struct PlotPanel {
  std::string title, xLabel, yLabel;
  std::vector<PlotSeries> series;
};

struct Plot {
  std::string title;
  std::vector<std::string> notes;  ///< lines under the title
  std::vector<PlotPanel> panels;   ///< row by row
  size_t columns = 1;
  double panelWidth = 760, panelHeight = 300;
  bool legend = false;  ///< whether to list the names of the first panel's series
};

std::string toSvg(const Plot& plot);

}  // namespace gnosphere::cli
