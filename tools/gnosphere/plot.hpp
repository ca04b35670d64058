// SPDX-License-Identifier: Apache-2.0
// Logarithmic plots as self-contained SVG, readable without colour: markers and dashes differ, too. What is 0 has no
// place on a logarithmic axis and gets a band of its own below it.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace gnosphere::cli {

struct PlotPoint {
  double x = 0;                ///< positive
  double y = 0;                ///< 0 goes to the band; what is not finite is left out
  double xLow = 0, xHigh = 0;  ///< a bar across the point, where they differ
  std::string label;
};

enum class Marker { cross, triangle, circle, square, diamond };

/// What one name stands for.
struct PlotSeries {
  std::string name;
  Marker marker = Marker::circle;
  std::string colour = "#222222";
  std::string dash;  ///< of the line that joins the points, as SVG writes it: "4 2"; "none": no line
  double size = 5;   ///< of the marker: half its width in pixels
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
  bool legend = false;  ///< names of the first panel's series
};

std::string toSvg(const Plot& plot);

/// As XML wants it; control characters, which it has no place for, are left out.
std::string escaped(const std::string& text);

}  // namespace gnosphere::cli
