// SPDX-License-Identifier: Apache-2.0
// The cases. Each adds its options to `app` and returns what runs it: the result is the exit status.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace gnosphere::bench {

using Action = std::function<int()>;

Action addStability(CLI::App& app);
Action addFigure7(CLI::App& app);
Action addDynamic(CLI::App& app);

/// A row of the table of cases.
struct Case {
  const char* name;
  const char* description;
  Action (*add)(CLI::App&);
};

inline constexpr Case kCases[] = {
    {"stability", "Error of every accuracy over the hardness of a case", addStability},
    {"figure7", "Times of the paper's five sensors over a town (its Figure 7)", addFigure7},
    {"dynamic", "Everything may move: rivals renew their structure for every scan", addDynamic},
};

}  // namespace gnosphere::bench
