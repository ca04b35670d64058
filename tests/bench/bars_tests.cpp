// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <limits>

#include "bars.hpp"
#include "bench/xml.hpp"

using namespace gnosphere::bench;
using Catch::Matchers::ContainsSubstring;

TEST_CASE("bars are well-formed SVG for any values, and values that cannot be drawn are left out") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const std::string svg =
      toSvg({"a < b & c", {"note"}, "times", 1, {{"one", 1}, {"lost", nan}, {"far", infinity}, {"<&>", 70, 60, 90}}});
  CHECK(gnosphere::test::xmlProblem(svg) == "");
  CHECK_THAT(svg, ContainsSubstring("a &lt; b &amp; c") && ContainsSubstring(">70.00<"));
  CHECK_THAT(svg, !ContainsSubstring("lost") && !ContainsSubstring("nan") && !ContainsSubstring("inf"));
  CHECK(gnosphere::test::xmlProblem(toSvg(BarChart())) == "");
  CHECK_THAT(svg, ContainsSubstring("width='760'"));
  CHECK_THAT(toSvg({"", {}, "", 1, {{std::string(60, 'n'), 2}}}), ContainsSubstring("width='962'"));  // room for names
}
