// SPDX-License-Identifier: Apache-2.0
// Outcomes as tables, JSON and plots.
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
  std::string note;  ///< under it
  std::vector<cli::TableRow> rows;
};

/// What a case has found.
struct Report {
  std::vector<Outcome> outcomes;
  std::vector<Table> tables;
  std::string xLabel;                    ///< of a plot
  BarChart bars = {};                    ///< its plot, where it has no outcomes
  cli::Json more = cli::Json::object();  ///< what it has measured besides
};

/// Every contender in every outcome: build, renew, scan, device, total, how many times as fast ours is, what differs.
Table timesTable(const std::vector<Outcome>& outcomes);
/// Mean, and variances across frames and runs, as the paper's Tables 3 and 4.
Table varianceTable(const std::vector<Outcome>& outcomes);
/// Medians of what the time is made of.
Table stagesTable(const std::vector<Outcome>& outcomes);
/// Ours by Vulkan and by CUDA, stage by stage; no rows where CUDA has not taken part.
Table cudaTable(const std::vector<Outcome>& outcomes);
/// Ours alone: the floor and memory.
Table floorTable(const std::vector<Outcome>& outcomes);

cli::Json toJson(const Report& report);
/// To five digits, which is more than a clock is good for.
double rounded(double value);
/// JSON for people, too: what fits a line stands on one.
std::string compact(const cli::Json& json);
/// Times of all contenders over the outcomes' x.
cli::Plot plotOf(const Report& report, const std::string& title, const DeviceInfo& device);

}  // namespace gnosphere::bench
