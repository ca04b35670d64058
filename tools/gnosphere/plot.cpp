// SPDX-License-Identifier: Apache-2.0
#include "plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "console.hpp"
#include "svg.hpp"

namespace gnosphere::cli {
namespace {

constexpr double kLeft = 66, kRight = 16, kTop = 30, kBottom = 46, kBand = 24, kLetter = 6.1, kLabel = 14;

std::string markerAt(const PlotSeries& s, double x, double y) {
  const double r = s.size;
  const std::string style = " fill='white' fill-opacity='0.6' stroke='" + s.colour + "' stroke-width='1.6'/>\n";
  switch (s.marker) {
    case Marker::circle: return formatted("<circle cx='%.1f' cy='%.1f' r='%.1f'", x, y, r) + style;
    case Marker::square:
      return formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f'", x - r, y - r, 2 * r, 2 * r) + style;
    case Marker::triangle: return formatted("<path d='M%.1f %.1fl%.1f %.1fh%.1fz'", x, y - r, r, 2 * r, -2 * r) + style;
    case Marker::diamond:
      return formatted("<path d='M%.1f %.1fl%.1f %.1fl%.1f %.1fl%.1f %.1fz'", x, y - r, r, r, -r, r, -r, -r) + style;
    case Marker::cross: break;
  }
  return formatted("<path d='M%.1f %.1fl%.1f %.1fm0 %.1fl%.1f %.1f'", x - r, y - r, 2 * r, 2 * r, -2 * r, -2 * r,
                   2 * r) +
         style;
}

/// A logarithmic axis from pixel `from` to pixel `to`.
struct Axis {
  double low = 1, high = 10, from = 0, to = 1;

  /// Covers the positive values of `values` with a margin, and at least a ratio of `span`, so that small variations
  /// look small.
  Axis(std::vector<double> values, double span, double begin, double end) : from(begin), to(end) {
    values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return !(v > 0) || !std::isfinite(v); }),
                 values.end());
    if (values.empty()) return;
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const double ratio = *most / *least;
    const double air = std::max({std::pow(ratio, 0.08), 1.03, std::sqrt(span / ratio)});
    low = *least / air;
    high = *most * air;
  }
  double at(double value) const { return from + (to - from) * std::log(value / low) / std::log(high / low); }

  std::vector<double> ticks() const {
    static const std::array<std::vector<double>, 4> kSteps = {
        {{1}, {1, 3}, {1, 2, 5}, {1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9}}};
    const double decades = std::log10(high / low);
    const size_t steps = decades > 4 ? 0 : decades > 2.5 ? 1 : decades > 0.9 ? 2 : 3;
    const int every = std::max(1, static_cast<int>(std::ceil(decades / 7)));
    std::vector<double> list;
    for (int e = static_cast<int>(std::floor(std::log10(low))); e <= std::log10(high); ++e) {
      if (steps == 0 && e % every != 0) continue;
      for (double step : kSteps[steps])
        if (const double tick = step * std::pow(10, e); tick >= low && tick <= high) list.push_back(tick);
    }
    return list.size() < 2 ? linearTicks() : list;
  }

 private:
  /// Ticks for an axis so short that it is nearly linear.
  std::vector<double> linearTicks() const {
    const double rough = (high - low) / 5, decade = std::pow(10, std::floor(std::log10(rough)));
    const double step = decade * (rough / decade < 2 ? 2 : rough / decade < 5 ? 5 : 10);
    std::vector<double> list;
    for (double tick = std::ceil(low / step) * step; tick <= high; tick += step) list.push_back(tick);
    return list;
  }
};

std::string tickLabel(double value) {
  if (value >= 0.9999e10 || value < 0.9999e-3) {
    const double exponent = std::floor(std::log10(value) + 1e-9), mantissa = value / std::pow(10, exponent);
    const std::string factor = std::abs(mantissa - 1) < 1e-6 ? "" : formatted("%.3g", mantissa) + "\u00b7";
    return factor + formatted("10<tspan dy='-4' font-size='8'>%.0f</tspan>", exponent);
  }
  if (value >= 0.9999e6) return formatted("%.4gM", value * 1e-6);
  if (value >= 0.9999e4) return formatted("%.4gk", value * 1e-3);
  return formatted("%.4g", value);
}

/// Keeps track of occupied areas, so that no label covers another or a marker.
class Labels {
 public:
  Labels(double left, double top, double right, double bottom) : frame_{left, top, right, bottom} {}

  void keepFree(double left, double right, double y, double reach) {
    taken_.push_back({left - reach, y - reach, right + reach, y + reach});
  }

  /// Places a label beside the marker and its bar if there is room, else farther away with a thin line to it.
  std::string put(double x, double y, double low, double high, double reach, const std::string& text) {
    const bool bold = reach > 5;
    const double width = kLetter * static_cast<double>(text.size()) * (bold ? 1.06 : 1) + 2;
    const double right = std::max(high, x + reach) + 4, left = std::min(low, x - reach) - 4 - width;
    for (double rise : {0.0, -15.0, 15.0, -30.0, 30.0, -45.0, 45.0, -60.0, 60.0, -75.0, 75.0}) {
      for (double at : {rise == 0 ? right : x - width / 2, rise == 0 ? left : x, x - width}) {
        if (rise == 0 && at == x - width) continue;
        const Box box = {at, y + rise - kLabel / 2, at + width, y + rise + kLabel / 2};
        if (!isFree(box)) continue;
        taken_.push_back(box);
        const double end = rise > 0 ? box.top + 1 : box.bottom - 1;
        const std::string leader = std::abs(rise) < 20
                                       ? ""
                                       : lineFrom(x, y + (rise > 0 ? reach : -reach), std::clamp(x, at, at + width),
                                                  end, "stroke='#999999' stroke-width='0.7'");
        return leader + textAt(at + 1, y + rise + 4, "start", escaped(text), bold ? " font-weight='bold'" : "");
      }
    }
    return textAt(x, y - reach - 3, "middle", escaped(text));
  }

 private:
  struct Box {
    double left, top, right, bottom;
  };
  bool isFree(const Box& box) const {
    if (box.left < frame_.left || box.right > frame_.right || box.top < frame_.top || box.bottom > frame_.bottom)
      return false;
    return std::none_of(taken_.begin(), taken_.end(), [&](const Box& other) {
      return box.left < other.right && other.left < box.right && box.top < other.bottom && other.top < box.bottom;
    });
  }
  Box frame_;
  std::vector<Box> taken_;
};

/// Draws one panel with its corner at (left, top).
class PanelDrawing {
 public:
  PanelDrawing(const PlotPanel& panel, double left, double top, double width, double height)
      : panel_(panel),
        left_(left + kLeft),
        right_(left + width - kRight),
        top_(top + kTop),
        bottom_(top + height - kBottom),
        zeros_(any([](const PlotPoint& p) { return p.y == 0; })),
        xAxis_(all([](const PlotPoint& p) {
                 return std::vector{p.x, p.xLow, p.xHigh};
               }),
               1, left_ + 8, right_ - 8),
        yAxis_(all([](const PlotPoint& p) { return std::vector{p.y}; }), 100, bottom_ - (zeros_ ? kBand : 0) - 4,
               top_ + 4) {}

  std::string svg() const { return frame() + data(); }

 private:
  template <class Test>
  bool any(Test test) const {
    for (const PlotSeries& series : panel_.series)
      if (std::any_of(series.points.begin(), series.points.end(), test)) return true;
    return false;
  }
  template <class Get>
  std::vector<double> all(Get get) const {
    std::vector<double> values;
    for (const PlotSeries& series : panel_.series)
      for (const PlotPoint& point : series.points)
        for (double value : get(point)) values.push_back(value);
    return values;
  }
  bool hasValues() const {
    return any([](const PlotPoint& p) { return p.y > 0 && std::isfinite(p.y); });
  }
  double yOf(double value) const { return value == 0 ? bottom_ - kBand / 2 : yAxis_.at(value); }

  std::string frame() const {
    const char* grid = "stroke='#e3e3e3' stroke-width='1'";
    std::string out;
    if (zeros_) {
      out += formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='#f0f0ea'/>\n", left_, bottom_ - kBand,
                       right_ - left_, kBand);
      out += textAt(left_ - 6, bottom_ - kBand / 2 + 4, "end", "0");
    }
    for (double tick : xAxis_.ticks()) {
      out += lineFrom(xAxis_.at(tick), top_, xAxis_.at(tick), bottom_, grid);
      out += textAt(xAxis_.at(tick), bottom_ + 15, "middle", tickLabel(tick));
    }
    for (double tick : hasValues() ? yAxis_.ticks() : std::vector<double>()) {
      out += lineFrom(left_, yAxis_.at(tick), right_, yAxis_.at(tick), grid);
      out += textAt(left_ - 6, yAxis_.at(tick) + 4, "end", tickLabel(tick));
    }
    out += formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='none' stroke='#555555'/>\n", left_, top_,
                     right_ - left_, bottom_ - top_);
    out += textAt(left_, top_ - 9, "start", escaped(panel_.title), " font-weight='bold'");
    out += textAt((left_ + right_) / 2, bottom_ + 32, "middle", escaped(panel_.xLabel));
    const double x = left_ - 48, y = (top_ + bottom_) / 2;
    return out + textAt(x, y, "middle", escaped(panel_.yLabel),
                        formatted(" transform='rotate(-90 %.1f %.1f)'", x, y).c_str());
  }

  std::string data() const {
    std::string lines, markers, labels;
    Labels places(left_, top_, right_, bottom_);
    for (const PlotSeries& series : panel_.series) {
      std::string path;
      for (const PlotPoint& p : series.points) {
        if (!std::isfinite(p.y)) continue;
        const double x = xAxis_.at(p.x), y = yOf(p.y);
        path += formatted("%s%.1f %.1f", path.empty() ? "M" : "L", x, y);
        if (p.xLow < p.xHigh) {
          lines += lineFrom(xAxis_.at(p.xLow), y, xAxis_.at(p.xHigh), y,
                            ("stroke-width='1' stroke='" + series.colour + "'").c_str());
          places.keepFree(xAxis_.at(p.xLow), xAxis_.at(p.xHigh), y, 1);
        }
        markers += markerAt(series, x, y);
        places.keepFree(x, x, y, series.size);
      }
      if (path.empty() || series.dash == "none") continue;
      lines += "<path d='" + path + "' fill='none' stroke='" + series.colour + "' stroke-width='1.6'" +
               (series.dash.empty() ? "" : " stroke-dasharray='" + series.dash + "'") + "/>\n";
    }
    for (const PlotSeries& series : panel_.series) {
      for (const PlotPoint& p : series.points) {
        if (p.label.empty() || !std::isfinite(p.y)) continue;
        const double x = xAxis_.at(p.x);
        const bool bar = p.xLow < p.xHigh;
        labels +=
            places.put(x, yOf(p.y), bar ? xAxis_.at(p.xLow) : x, bar ? xAxis_.at(p.xHigh) : x, series.size, p.label);
      }
    }
    return lines + markers + labels;
  }

  const PlotPanel& panel_;
  double left_, right_, top_, bottom_;
  bool zeros_;
  Axis xAxis_, yAxis_;
};

constexpr double kLegendLine = 20;

double legendWidth(const PlotSeries& series) {
  return 76 + kLetter * static_cast<double>(series.name.size());
}

// Positions of the legend's entries, broken into lines of the given width.
std::vector<std::array<double, 2>> legendPlaces(const PlotPanel& panel, double width) {
  std::vector<std::array<double, 2>> places;
  double x = 18, y = 0;
  for (const PlotSeries& series : panel.series) {
    if (x > 18 && x + legendWidth(series) > width) {
      x = 18;
      y += kLegendLine;
    }
    places.push_back({x, y});
    x += legendWidth(series);
  }
  return places;
}

std::string legendAt(const PlotPanel& panel, const std::vector<std::array<double, 2>>& places, double top) {
  std::string out;
  for (size_t i = 0; i < places.size(); ++i) {
    const PlotSeries& series = panel.series[i];
    const double x = places[i][0], y = top + places[i][1];
    const std::string dash = series.dash.empty() ? "" : " stroke-dasharray='" + series.dash + "'";
    if (series.dash != "none")
      out += lineFrom(x, y - 4, x + 44, y - 4, ("stroke-width='1.6' stroke='" + series.colour + "'" + dash).c_str());
    out += markerAt(series, x + 22, y - 4) + textAt(x + 52, y, "start", escaped(series.name));
  }
  return out;
}

}  // namespace

std::string toSvg(const Plot& plot) {
  const double rows = std::ceil(static_cast<double>(plot.panels.size()) / static_cast<double>(plot.columns));
  const double width = plot.panelWidth * static_cast<double>(plot.columns);
  const auto places =
      plot.legend && !plot.panels.empty() ? legendPlaces(plot.panels[0], width) : std::vector<std::array<double, 2>>();
  const double notes = 30 + kNoteLine * static_cast<double>(plot.notes.size());
  const double head = notes + (places.empty() ? 0 : 24 + places.back()[1]) + 8, height = head + rows * plot.panelHeight;
  std::string out = svgHead(width, height, plot.title, plot.notes);
  if (!places.empty()) out += legendAt(plot.panels[0], places, notes + 22);
  for (size_t i = 0; i < plot.panels.size(); ++i) {
    const double column = static_cast<double>(i % plot.columns), row = static_cast<double>(i / plot.columns);
    out += PanelDrawing(plot.panels[i], column * plot.panelWidth, head + row * plot.panelHeight, plot.panelWidth,
                        plot.panelHeight)
               .svg();
  }
  return out + "</svg>\n";
}

}  // namespace gnosphere::cli
