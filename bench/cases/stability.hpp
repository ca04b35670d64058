// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "json.hpp"

namespace gnosphere::bench {

/// Adds its options to `app` and returns the action that runs it; the result is the exit status.
std::function<int()> addStability(CLI::App& app);

/// Returns the results of all families, for a file that holds other cases, too.
cli::Json stabilityOf(const std::string& device);

}  // namespace gnosphere::bench
