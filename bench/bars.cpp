// SPDX-License-Identifier: Apache-2.0
#include "bars.hpp"

#include <algorithm>
#include <cmath>

#include "console.hpp"
#include "svg.hpp"

namespace gnosphere::bench {
namespace {

using cli::escaped;
using cli::formatted;
using cli::lineFrom;
using cli::textAt;

// Pixels: names are to the left of the axis, values to the right of their bars.
constexpr double kLetter = 6.2, kLeastLeft = 190, kBars = 500, kValues = 70, kRow = 19, kBar = 13, kFoot = 44;

/// Returns 1, 2 and 5 times every power of ten between `low` and `high`.
std::vector<double> ticksOf(double low, double high) {
  std::vector<double> ticks;
  for (int e = static_cast<int>(std::floor(std::log10(low))); e <= std::log10(high); ++e)
    for (double step : {1, 2, 5})
      if (const double tick = step * std::pow(10, e); tick >= low && tick <= high) ticks.push_back(tick);
  return ticks;
}

}  // namespace

std::string toSvg(const BarChart& chart) {
  std::vector<Bar> bars;
  for (const Bar& bar : chart.bars)
    if (bar.value > 0 && std::isfinite(bar.value)) bars.push_back(bar);
  double least = chart.mark, most = chart.mark;
  for (const Bar& bar : bars) {
    least = std::min(least, bar.value);
    most = std::max({most, bar.value, bar.high});
  }
  least *= 0.9;  // leaves a margin; whiskers may be clipped there
  most *= 1.01;
  size_t letters = 0;
  for (const Bar& bar : bars) letters = std::max(letters, bar.name.size());
  const double left = std::max(kLeastLeft, 20 + kLetter * static_cast<double>(letters));
  const double top = 40 + cli::kNoteLine * static_cast<double>(chart.notes.size());
  const double bottom = top + kRow * static_cast<double>(bars.size());
  const double width = left + kBars + kValues, height = bottom + kFoot;
  const auto at = [=](double value) {
    return left + kBars * std::log(std::max(value, least) / least) / std::log(most / least);
  };

  std::string out = cli::svgHead(width, height, chart.title, chart.notes);
  for (double tick : ticksOf(least, most)) {
    out += lineFrom(at(tick), top, at(tick), bottom, "stroke='#e3e3e3'");
    out += textAt(at(tick), bottom + 15, "middle", formatted("%.4g", tick));
  }
  for (size_t i = 0; i < bars.size(); ++i) {
    const Bar& bar = bars[i];
    const double y = top + kRow * static_cast<double>(i) + (kRow - kBar) / 2, middle = y + kBar / 2;
    const double end = at(bar.value), from = std::min(end, at(chart.mark)), to = std::max(end, at(chart.mark));
    out += formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='#56b4e9'/>\n", from, y, to - from, kBar);
    if (bar.low < bar.high) out += lineFrom(at(bar.low), middle, at(bar.high), middle, "stroke='#222222'");
    out += textAt(left - 6, middle + 4, "end", escaped(bar.name));
    out +=
        textAt(at(std::max({bar.value, bar.high, chart.mark})) + 5, middle + 4, "start", formatted("%.2f", bar.value));
  }
  out += lineFrom(at(chart.mark), top, at(chart.mark), bottom, "stroke='#d55e00'");
  out += textAt(left + kBars / 2, bottom + 33, "middle", escaped(chart.xLabel));
  return out + "</svg>\n";
}

}  // namespace gnosphere::bench
