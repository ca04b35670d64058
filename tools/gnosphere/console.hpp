// SPDX-License-Identifier: Apache-2.0
// Output for people: numbers with separators, aligned lines, warnings.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace gnosphere::cli {

/// Parses two whole numbers with a separator between; each may be left out if it is optional, and then stays.
bool parsePair(const std::string& text, char separator, bool optional, uint64_t& a, uint64_t& b);

/// Prints `gnosphere: message` as one line on stderr.
void complain(const std::string& message);

/// Warns if the coordinates of a cloud file are 32-bit floats whose step, if it is not 0, is more than the distance
/// that an option states.
void warnOfFloats(const std::string& file, double step, const char* option, double distance);

/// Returns the exit status of a call: `failed`, with a message, if the standard output has lost what was printed.
/// Whoever closes a pipe, as `head` does, wants no more, so then there is no message.
int checkedOutput(int status, int failed);

std::string grouped(uint64_t number);  ///< 1234567 -> 1,234,567
std::string formatted(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string metres(double value);     ///< 0.00059 -> 5.90e-04
std::string percent(double share);    ///< 0.0123 -> 1.23 %
std::string milliseconds(double ms);  ///< with three significant digits and the unit
std::string bareMs(double ms);        ///< the same without the unit, for table columns in ms
std::string fileSize(const std::string& file);

/// Returns "1 frame" or "1,000 frames"; `many` is the word for any other number than 1.
std::string counted(uint64_t count, const char* one, const char* many);
/// Returns text without characters that would control a terminal: each is written as \\x and two hexadecimal digits.
std::string printable(const std::string& text);

/// Returns the width of text for people in columns: that of the terminal, but from 40 to 120; without a terminal 80.
size_t textColumns();
/// Returns the text with line breaks at blanks, so that each line has at most `columns` characters. All lines but the
/// first begin with `indent` blanks, which count. A word that is longer than a line stays whole.
std::string wrapped(const std::string& text, size_t columns, size_t indent = 0);

/// Prints a line of a summary, with the label in its own column.
void say(const char* label, const std::string& text);

/// Decides when a long run that has no terminal prints how far it is: when another tenth of the work is done, but not
/// within ten seconds of the line before or of the start, and not at the end.
class ProgressLines {
 public:
  explicit ProgressLines(double startMs) : lastMs_(startMs) {}
  /// `nowMs` is a time in milliseconds of the clock of the start.
  bool isDue(uint64_t done, uint64_t total, double nowMs);

 private:
  double lastMs_;
  uint64_t tenths_ = 0;  // of the work, at the line before
};

/// Shows a bar, "step 12 of 400" and the time left on one line of the terminal once the work has taken more than a
/// second. Without a terminal it prints nothing, or if `lines` a line now and then, see ProgressLines.
class Progress {
 public:
  Progress(const char* what, uint64_t total, bool lines = false);
  ~Progress();
  void step(uint64_t done) { step(done, total_); }
  void step(uint64_t done, uint64_t total);

 private:
  const char* what_;
  uint64_t total_;
  bool terminal_, inLines_, shown_ = false;
  double startMs_, lastMs_;
  ProgressLines lines_;
};

/// Returns a function that shows the progress of work in several steps, called with the name of a step, how much of the
/// step is done, and all of it.
std::function<void(const char*, uint64_t, uint64_t)> stepProgress();

using TableRow = std::vector<std::string>;
/// Prints aligned columns, the first `leftColumns` to the left and the others to the right.
void printTable(const std::vector<TableRow>& rows, size_t leftColumns = 1);
/// Prints the same table as Markdown.
void printMarkdown(const std::vector<TableRow>& rows);

/// The call as it was typed, with the program's bare name: reports say how they were made.
void rememberCommand(int argc, char** argv);
const std::string& commandLine();

double nowMs();

}  // namespace gnosphere::cli
