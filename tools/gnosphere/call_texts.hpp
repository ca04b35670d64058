// SPDX-License-Identifier: Apache-2.0
// The help of a program with subcommands, and what is wrong with a call of it.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

namespace gnosphere::cli {

/// Help whose lines fit the terminal, with any version of CLI11.
std::shared_ptr<CLI::FormatterBase> helpFormatter();

/// Returns what is wrong with a call, and which help tells more. `subcommand` is what the program calls one.
std::string wrongCall(const CLI::App& app, const CLI::ParseError& error, const char* subcommand);

}  // namespace gnosphere::cli
