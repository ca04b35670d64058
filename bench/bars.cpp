// SPDX-License-Identifier: Apache-2.0
#include "bars.hpp"

#include <algorithm>
#include <cmath>

#include "console.hpp"
#include "plot.hpp"

namespace gnosphere::bench {
namespace {

using cli::formatted;

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

std::string textAt(double x, double y, const char* anchor, const std::string& text, const char* more = "") {
  return formatted("<text x='%.1f' y='%.1f' text-anchor='%s'%s>", x, y, anchor, more) + cli::escaped(text) +
         "</text>\n";
}

std::string lineFrom(double x1, double y1, double x2, double y2, const char* colour) {
  return formatted("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' stroke='%s'/>\n", x1, y1, x2, y2, colour);
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
  const double top = 40 + 14 * static_cast<double>(chart.notes.size());
  const double bottom = top + kRow * static_cast<double>(bars.size());
  const double width = left + kBars + kValues, height = bottom + kFoot;
  const auto at = [=](double value) {
    return left + kBars * std::log(std::max(value, least) / least) / std::log(most / least);
  };

  std::string out = formatted(
      "<svg xmlns='http://www.w3.org/2000/svg' width='%.0f' height='%.0f' viewBox='0 0 %.0f %.0f' "
      "font-family='sans-serif' font-size='11' fill='#222222'>\n<rect width='%.0f' height='%.0f' fill='white'/>\n",
      width, height, width, height, width, height);
  out += textAt(18, 24, "start", chart.title, " font-size='15' font-weight='bold'");
  for (size_t i = 0; i < chart.notes.size(); ++i)
    out += textAt(18, 42 + 14 * static_cast<double>(i), "start", chart.notes[i], " fill='#555555'");
  for (double tick : ticksOf(least, most)) {
    out += lineFrom(at(tick), top, at(tick), bottom, "#e3e3e3");
    out += textAt(at(tick), bottom + 15, "middle", formatted("%.4g", tick));
  }
  for (size_t i = 0; i < bars.size(); ++i) {
    const Bar& bar = bars[i];
    const double y = top + kRow * static_cast<double>(i) + (kRow - kBar) / 2, middle = y + kBar / 2;
    const double end = at(bar.value), from = std::min(end, at(chart.mark)), to = std::max(end, at(chart.mark));
    out += formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='#56b4e9'/>\n", from, y, to - from, kBar);
    if (bar.low < bar.high) out += lineFrom(at(bar.low), middle, at(bar.high), middle, "#222222");
    out += textAt(left - 6, middle + 4, "end", bar.name);
    out +=
        textAt(at(std::max({bar.value, bar.high, chart.mark})) + 5, middle + 4, "start", formatted("%.2f", bar.value));
  }
  out += lineFrom(at(chart.mark), top, at(chart.mark), bottom, "#d55e00");
  out += textAt(left + kBars / 2, bottom + 33, "middle", chart.xLabel);
  return out + "</svg>\n";
}

}  // namespace gnosphere::bench
