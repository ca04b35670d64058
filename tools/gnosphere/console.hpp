// SPDX-License-Identifier: Apache-2.0
// What a person reads: numbers with separators, aligned lines, warnings.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace gnosphere::cli {

/// `gnosphere: message` as one line on stderr.
void complain(const std::string& message);

std::string grouped(uint64_t number);  ///< 1234567 -> 1,234,567
std::string formatted(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string milliseconds(double ms);  ///< three digits that mean something
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

double nowMs();

}  // namespace gnosphere::cli
