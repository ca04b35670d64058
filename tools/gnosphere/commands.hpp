// SPDX-License-Identifier: Apache-2.0
// The subcommands of the program. Each function adds its options to `app` and returns the action that runs it; its
// result is the exit status.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace gnosphere::cli {

using Action = std::function<int()>;

Action addScan(CLI::App& app);
Action addPlan(CLI::App& app);
Action addAccuracy(CLI::App& app);
Action addCompare(CLI::App& app);
Action addDevices(CLI::App& app);
Action addSensors(CLI::App& app);
Action addEffects(CLI::App& app);
Action addOptions(CLI::App& app);
Action addInfo(CLI::App& app);
Action addTown(CLI::App& app);
Action addDrive(CLI::App& app);
Action addView(CLI::App& app);

}  // namespace gnosphere::cli
