// SPDX-License-Identifier: Apache-2.0
// Formats outcomes as tables, JSON and plots.
#pragma once

#include <string>
#include <vector>

#include "bars.hpp"
#include "console.hpp"
#include "contest.hpp"
#include "json.hpp"
#include "plot.hpp"

namespace gnosphere::bench {

struct Table {
  std::string note;  ///< printed below it
  std::vector<cli::TableRow> rows;
};

/// The results of a case.
struct Report {
  std::vector<Outcome> outcomes;
  std::vector<Table> tables;
  std::string xLabel;                    ///< label of the plot's x axis
  BarChart bars = {};                    ///< its plot; if there are no bars, the outcomes are plotted over their x
  cli::PlotPanel panel = {};             ///< its plot, if it has series
  cli::Json more = cli::Json::object();  ///< further measurements
  bool wrong = false;                    ///< whether a result was wrong; the rest is reported all the same
};

/// A row for every contender in every outcome: its times of build, update, scan and device, their total, its speed
/// relative to GnoSphere's, and the differences of its clouds.
Table timesTable(const std::vector<Outcome>& outcomes);
/// Mean, and variances across frames and runs, as in Tables 3 and 4 of the paper.
Table varianceTable(const std::vector<Outcome>& outcomes);
/// Medians of the stages' times.
Table stagesTable(const std::vector<Outcome>& outcomes);
/// GnoSphere by Vulkan and by CUDA, step by step; empty without CUDA.
Table cudaTable(const std::vector<Outcome>& outcomes);
/// GnoSphere alone: least possible time and memory.
Table floorTable(const std::vector<Outcome>& outcomes);

cli::Json toJson(const Report& report);
/// Rounds to five digits, more than a clock resolves.
double rounded(double value);
cli::Json medianJson(const Spread& spread);
cli::Json errorJson(const Comparison& comparison);
/// JSON that people can read, too: values that fit a line are written on one line.
std::string compact(const cli::Json& json);
/// Plots the times of all contenders over the outcomes' x.
cli::Plot plotOf(const Report& report, const std::string& title, const DeviceInfo& device);

}  // namespace gnosphere::bench
