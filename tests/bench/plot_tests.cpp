// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <limits>
#include <utility>

#include "bench/xml.hpp"
#include "plot.hpp"

using namespace gnosphere::cli;
using Catch::Matchers::ContainsSubstring;

namespace {

Plot plotOf(std::vector<PlotPoint> points) {
  Plot plot;
  plot.title = "a < b & c";
  plot.legend = true;
  plot.panels = {{"panel", "x", "y", {{"line", Marker::circle, "#222222", "4 2", 5, std::move(points)}}}};
  return plot;
}

}  // namespace

TEST_CASE("a plot is well-formed SVG for any values") {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Plot& plot :
       {plotOf({}), plotOf({{1, 0, 0, 0, "zero"}}), plotOf({{1, 1, 0, 0, "one"}}),
        plotOf({{1, infinity, 0, 0, "lost"}, {2, 1, 0, 0, "here"}}), plotOf({{1e-300, 1e300, 0, 0, "<&>"}}),
        plotOf({{1, 2, 0.5, 2, "a"}, {1.01, 2, 0.5, 2, "b"}, {1.02, 2, 0.5, 2, "c"}, {1.02, 0, 0.5, 2, "d"}})}) {
    const std::string svg = toSvg(plot);
    CHECK(gnosphere::test::xmlProblem(svg) == "");
    CHECK_THAT(svg, ContainsSubstring("a &lt; b &amp; c"));
    CHECK_THAT(svg, !ContainsSubstring("nan") && !ContainsSubstring("inf"));
  }
}

TEST_CASE("zeros are drawn in a separate band") {
  CHECK_THAT(toSvg(plotOf({{1, 0, 0, 0, "zero"}, {2, 1, 0, 0, "one"}})), ContainsSubstring("#f0f0ea"));
  CHECK_THAT(toSvg(plotOf({{2, 1, 0, 0, "one"}})), !ContainsSubstring("#f0f0ea"));
}

TEST_CASE("a legend that is too wide continues on the next line") {
  Plot plot = plotOf({{1, 1, 0, 0, ""}});
  const auto heightOf = [](const std::string& svg) {
    const size_t at = svg.find("height='") + 8;
    return std::stoi(svg.substr(at, svg.find('\'', at) - at));
  };
  const int oneLine = heightOf(toSvg(plot));
  for (int i = 0; i < 5; ++i) plot.panels[0].series.push_back({"a name of thirty characters, " + std::to_string(i)});
  const std::string svg = toSvg(plot);
  CHECK(heightOf(svg) > oneLine);
  for (size_t at = svg.find(">a name"); at != std::string::npos; at = svg.find(">a name", at + 1)) {
    const size_t x = svg.rfind("x='", at) + 3;
    CHECK(std::stod(svg.substr(x)) + 30 * 6 < plot.panelWidth);
  }
}
