// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "json.hpp"

namespace gnosphere::bench {

/// Adds its options to `app` and returns what runs it: the result is the exit status.
std::function<int()> addStability(CLI::App& app);

/// The results of all families, for a file with those of other cases.
cli::Json stabilityOf(const std::string& device);

}  // namespace gnosphere::bench
