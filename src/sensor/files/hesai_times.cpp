// SPDX-License-Identifier: Apache-2.0
// Hesai's firing times, in one of these layouts, which the headers tell apart:
//   Channel, fire time (us)                            one time per channel
//   Channel, even and odd fire time (ns)               two kinds, which alternate
//   Operational State ... / Azimuth State ... / rows   in us; the kinds of one state alternate, "-" does not fire
//   EEFF ... / Channel num, N, Loop num, L / header    L pairs of a channel and its time (us) per row
//   EEFF ... / Channel num, N, Block num, B / header   a channel configuration: each cell of a column is a channel that
//                                                      fires in columns of a kind, at no stated time; 0 is none
//   three lines, then a channel and 16 times (ns)      two times, for far and for near surfaces, for each of four kinds
//                                                      of state 0, two of state 2 and two of state 3; a kind in which
//                                                      both are 0 does not fire
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/file.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "base/utf8.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

/// A table of firing times that is being read.
struct Table {
  const SensorSource& source;
  size_t channels;
  FireTimes times;

  void addKinds(size_t count) { times.resize(times.size() + count, std::vector<double>(channels, kNever)); }

  void set(size_t kind, std::string_view channel, std::string_view time, double unit, const std::string& where) {
    const double id = numberOf(source, channel, where + ", channel");
    if (!(id >= 1 && id <= static_cast<double>(channels)) || id != std::floor(id))
      source.refuse(where + ": the channel is " + std::string(channel) + ", the angle correction has 1 to " +
                    std::to_string(channels));
    times[kind][static_cast<size_t>(id) - 1] = time == "-" ? kNever : unit * numberOf(source, time, where + ", time");
  }
};

/// Which columns of a table are the kinds of the state that the options ask for, or of the first state.
std::vector<size_t> columnsOfState(const SensorSource& source, const std::vector<std::string_view>& states,
                                   const std::string& mode) {
  const std::string_view wanted = mode.empty() && states.size() > 1 ? states[1] : std::string_view(mode);
  std::vector<size_t> columns;
  for (size_t i = 1; i < states.size(); ++i)
    if (states[i] == wanted) columns.push_back(i);
  if (columns.empty()) source.refuse("there is no operational state '" + std::string(wanted) + "'");
  return columns;
}

/// How the rows of a file are read.
struct Layout {
  std::vector<size_t> kinds;  ///< the cell of each kind in a row
  bool pairs = false;         ///< whether a kind is a channel and its time; else the row's first cell is the channel
  bool channelsOnly = false;  ///< whether a kind is a channel
  bool farNear = false;       ///< whether a kind is a time for far and one for near surfaces
  double unit = kMicro;
  size_t firstLine = 1, cells = 0;  ///< cells of a row
};

Layout layoutOf(SensorSource& angles, const SensorSource& source, const std::vector<std::string_view>& lines) {
  Layout layout;
  if (lines.empty()) source.refuse("is empty");
  const std::vector<std::string_view> header = cellsOf(lines[0]);
  layout.cells = header.size();
  const bool hasStates = containsWord(lines[0], "operational");
  if (hasStates) {
    layout.kinds = columnsOfState(source, header, source.options.mode);
    layout.firstLine = 2;
  } else if (containsWord(lines[0], "eeff")) {
    if (lines.size() < 3) source.refuse("ends before the names of its columns, in line 3");
    const auto counts = cellsOf(lines[1]), names = cellsOf(lines[2]);
    if (counts.size() < 4) source.refuse("line 2: expected is 'Channel num, N, Loop num, L'");
    layout.channelsOnly = containsWord(counts[2], "block");
    const double loops = layout.channelsOnly
                             ? static_cast<double>(names.size() - std::count(names.begin(), names.end(), ""))
                             : numberOf(source, counts[3], "line 2, loop number");
    if (!(loops >= 1 && loops <= 16)) source.refuse("line 2: the loop number must be 1 to 16");
    layout.pairs = !layout.channelsOnly;
    for (size_t i = 0; i < static_cast<size_t>(loops); ++i) layout.kinds.push_back(layout.pairs ? 2 * i : i);
    layout.firstLine = 3;
    layout.cells = (layout.pairs ? 2 : 1) * layout.kinds.size();
    if (layout.channelsOnly) angles.assume("that the channels of a column fire at once, as no firing times are stated");
  } else if (lines.size() > 3 && cellsOf(lines[3]).size() >= 17) {
    const std::string& mode = source.options.mode;
    if (mode.empty() || mode == "0")
      layout.kinds = {1, 3, 5, 7};
    else if (mode == "2" || mode == "3")
      layout.kinds = mode == "2" ? std::vector<size_t>{9, 11} : std::vector<size_t>{13, 15};
    else
      source.refuse("there is no operational state '" + mode + "', but 0, 2 and 3");
    angles.ignore("firing times for near surfaces");
    layout.farNear = true;
    layout.unit = kNano;
    layout.firstLine = 3;
    layout.cells = 17;
  } else if (containsWord(lines[0], "fire")) {
    for (size_t i = 1; i < header.size(); ++i) layout.kinds.push_back(i);
    if (containsWord(lines[0], "(ns)") || containsWord(lines[0], "/ns")) layout.unit = kNano;
  } else {
    source.refuse("is no file of Hesai's firing times");
  }
  if (!hasStates && !layout.farNear && !source.options.mode.empty())
    source.refuse("has no operational states, of which --mode names one");
  return layout;
}

}  // namespace

double startOfScan(SensorSource& source, const FireTimes& times) {
  double first = 0;
  for (const std::vector<double>& kind : times)
    for (const double time : kind)
      if (time < first) first = time;
  if (first < 0)
    source.assume("that a scan starts when its first beam fires, " + numberText(-1e6 * first) +
                  " us before its first column");
  return first;
}

FireTimes readFireTimes(SensorSource& angles, size_t channels) {
  const std::string bytes = readWholeFile(angles.options.fireTimes, size_t{16} << 20);
  const std::string name = angles.options.fireTimes.string();
  SensorSource source{textOfFile(bytes, name), name, angles.options, angles.file};
  const std::vector<std::string_view> lines = linesOf(source.bytes);
  const Layout layout = layoutOf(angles, source, lines);
  Table table{source, channels, {}};
  table.addKinds(layout.kinds.size());
  for (size_t i = layout.firstLine; i < lines.size(); ++i) {
    const std::vector<std::string_view> cells = cellsOf(lines[i]);
    if (cells[0].size() > 8 || (cells.size() == 1 && cells[0].empty())) continue;  // a checksum, or an empty line
    const std::string where = "line " + std::to_string(i + 1);
    refuseSurplus(source, cells, layout.cells, where);
    for (size_t kind = 0; kind < layout.kinds.size(); ++kind) {
      const size_t cell = layout.kinds[kind];
      if (cell + (layout.pairs || layout.farNear ? 1 : 0) >= cells.size())
        source.refuse(where + " has " + std::to_string(cells.size()) + " cells, expected are more");
      const bool silent = layout.farNear && cells[cell] == "0" && cells[cell + 1] == "0";
      if (!layout.pairs && !layout.channelsOnly)
        table.set(kind, cells[0], silent ? "-" : cells[cell], layout.unit, where);
      else if (!cells[cell].empty() && cells[cell] != "0" && !cells[cell].starts_with('-'))
        table.set(kind, cells[cell], layout.pairs ? cells[cell + 1] : "0", layout.unit, where);
    }
  }
  for (size_t channel = 0; channel < channels; ++channel) {
    bool fires = false;
    for (const std::vector<double>& kind : table.times) fires = fires || !std::isnan(kind[channel]);
    if (!fires) source.refuse("channel " + std::to_string(channel + 1) + " of the angle correction is missing");
  }
  return table.times;
}

}  // namespace gnosphere
