// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace gnosphere::bench {

/// Adds its options to `app` and returns what runs it: the result is the exit status.
std::function<int()> addStability(CLI::App& app);

}  // namespace gnosphere::bench
