// SPDX-License-Identifier: Apache-2.0
// What a person reads: numbers with separators, aligned lines, warnings.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace gnosphere::cli {

/// `gnosphere: message` as one line on stderr.
void complain(const std::string& message);

std::string grouped(uint64_t number);  ///< 1234567 -> 1,234,567
std::string formatted(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string milliseconds(double ms);  ///< three digits that mean something, with the unit
std::string bareMs(double ms);        ///< the same for the columns of a table in ms
std::string fileSize(const std::filesystem::path& file);

/// A line of a summary: the label in a column of its own.
void say(const char* label, const std::string& text);

/// "step 12 of 400" on one line of the terminal, once the work has taken more than a second; nothing in a pipe.
class Progress {
 public:
  Progress(const char* what, uint64_t total);
  ~Progress();
  void step(uint64_t done);

 private:
  const char* what_;
  uint64_t total_;
  bool terminal_, shown_ = false;
  double startMs_, lastMs_;
};

/// For work of several steps: called with the step's name, how much of it is done and how much there is.
std::function<void(const char*, uint64_t, uint64_t)> stepProgress();

using TableRow = std::vector<std::string>;
/// Columns aligned, the first `leftColumns` to the left and the others to the right.
void printTable(const std::vector<TableRow>& rows, size_t leftColumns = 1);
/// The same as Markdown.
void printMarkdown(const std::vector<TableRow>& rows);

/// The call as it was typed, the program by its name alone: results say how they were made.
void rememberCommand(int argc, char** argv);
const std::string& commandLine();

double nowMs();

}  // namespace gnosphere::cli
