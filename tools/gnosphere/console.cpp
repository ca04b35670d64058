// SPDX-License-Identifier: Apache-2.0
#include "console.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string_view>
#include <system_error>

#include "base/os.hpp"
#include "base/path.hpp"

namespace gnosphere::cli {

bool parsePair(const std::string& text, char separator, bool optional, uint64_t& a, uint64_t& b) {
  const size_t at = text.find(separator);
  if (at == text.npos) return false;
  const auto parse = [&](const char* begin, const char* end, uint64_t& number) {
    if (begin == end) return optional;
    const auto result = std::from_chars(begin, end, number);
    return result.ec == std::errc() && result.ptr == end;
  };
  return parse(text.data(), text.data() + at, a) && parse(text.data() + at + 1, text.data() + text.size(), b);
}

namespace {

/// Whether a progress bar can be drawn and erased.
bool showsProgress() {
  const char* kind = std::getenv("TERM");
  return os::isTerminal(stderr) && !(kind && std::string_view(kind) == "dumb");
}

bool barIsShown = false;  // on the last line of the terminal

}  // namespace

void complain(const std::string& message) {
  std::string line = message;
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::fflush(stdout);  // keeps the order of the two streams on a terminal
  std::fprintf(stderr, "%sgnosphere: %s\n", barIsShown ? "\r\x1b[K" : "", printable(line).c_str());
  barIsShown = false;
}

void warnOfFloats(const std::string& file, double step, const char* option, double distance) {
  if (step <= distance) return;
  complain("warning: " + file +
           formatted(": its coordinates are 32-bit floats, whose steps of %g m are more than ", step) + option +
           formatted(" %g; write doubles, or coordinates from an origin nearby", distance));
}

int checkedOutput(int status, int failed) {
  if (std::fflush(stdout) == 0) {
    if (std::ferror(stdout) == 0) return status;
    errno = 0;
    std::clearerr(stdout);  // what failed before has left no reason; one more byte fails for the same
    std::fputc('\n', stdout);
    std::fflush(stdout);
  }
  constexpr int kBrokenPipe = 128 + 13;  // what shells report of a program that the signal SIGPIPE ends
  if (errno == EPIPE) return kBrokenPipe;
  complain("the standard output is not complete: it cannot be written" +
           (errno == 0 ? std::string() : std::string(": ") + std::strerror(errno)));
  return failed;
}

std::string grouped(uint64_t number) {
  std::string text = std::to_string(number);
  for (size_t at = text.size(); at > 3;) text.insert(at -= 3, 1, ',');
  return text;
}

std::string counted(uint64_t count, const char* one, const char* many) {
  return grouped(count) + " " + (count == 1 ? one : many);
}

std::string printable(const std::string& text) {
  std::string shown;
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    const bool isLead = byte == 0xc2 && next >= 0x80 && next < 0xa0;  // of a control character in UTF-8
    if (byte < 0x20 || byte == 0x7f || isLead)
      shown += formatted("\\x%02x", isLead ? next : byte);
    else
      shown += text[i];
    i += isLead;
  }
  return shown;
}

std::string formatted(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  return text;
}

std::string metres(double value) {
  return value == 0 ? "0" : formatted("%.2e", value);
}

std::string percent(double share) {
  return share == 0 ? "0" : formatted(share < 1e-4 ? "%.1e %%" : "%.3g %%", 100 * share);
}

std::string milliseconds(double ms) {
  if (ms >= 10000) return formatted("%.1f s", ms / 1000);
  return formatted(ms < 1 ? "%.3f ms" : ms < 10 ? "%.2f ms" : ms < 100 ? "%.1f ms" : "%.0f ms", ms);
}

std::string bareMs(double ms) {
  return formatted(ms < 1 ? "%.3f" : "%.2f", ms);
}

std::string fileSize(const std::string& file) {
  std::error_code unknown;
  const auto bytes = static_cast<double>(std::filesystem::file_size(pathOf(file), unknown));
  if (unknown) return "";
  if (bytes < 1e3) return formatted("%.0f bytes", bytes);
  return bytes < 1e6 ? formatted("%.1f kB", bytes / 1e3) : formatted("%.1f MB", bytes / 1e6);
}

size_t textColumns() {
  constexpr size_t kLeast = 40, kMost = 120, kUsual = 80;
  const size_t columns = os::terminalColumns(stdout);
  return columns == 0 ? kUsual : std::clamp(columns, kLeast, kMost);
}

std::string wrapped(const std::string& text, size_t columns, size_t indent) {
  std::string all;
  size_t used = indent;  // of the line, which may begin behind something else
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find_first_of(" \n", begin), text.size());
    const bool starts = all.empty() || all.back() == '\n';
    if (!starts && used + 1 + (end - begin) > columns) all += '\n';
    if (!all.empty() && all.back() == '\n') {
      all.append(indent, ' ');
      used = indent;
    } else if (!all.empty()) {
      all += ' ';
      ++used;
    }
    all.append(text, begin, end - begin);
    used += end - begin;
    if (end < text.size() && text[end] == '\n') all += '\n';
    begin = end + 1;
  }
  return all;
}

void say(const char* label, const std::string& text) {
  std::printf("%-10s %s\n", label, printable(text).c_str());
  std::fflush(stdout);
}

namespace {
std::string typed;
}

void rememberCommand(int argc, char** argv) {
  typed = pathOf(argv[0]).filename().string();
  for (int i = 1; i < argc; ++i) typed.append(" ").append(argv[i]);
}

const std::string& commandLine() {
  return typed;
}

double nowMs() {
  using namespace std::chrono;
  return duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
}

bool ProgressLines::isDue(uint64_t done, uint64_t total, double nowMs) {
  constexpr double kPauseMs = 10'000;
  if (done >= total || nowMs - lastMs_ < kPauseMs || 10 * done / total == tenths_) return false;
  tenths_ = 10 * done / total;
  lastMs_ = nowMs;
  return true;
}

Progress::Progress(const char* what, uint64_t total, bool lines)
    : what_(what),
      total_(total),
      terminal_(showsProgress()),
      inLines_(lines && !terminal_),
      startMs_(nowMs()),
      lastMs_(startMs_),
      lines_(startMs_) {}

Progress::~Progress() {
  if (!shown_ || !barIsShown) return;
  std::fprintf(stderr, "\r\x1b[K");
  barIsShown = false;
}

namespace {

std::string timeText(double seconds) {
  const auto whole = static_cast<uint64_t>(seconds + 0.5);
  const unsigned long long hours = whole / 3600, minutes = whole / 60 % 60, rest = whole % 60;
  return hours > 0 ? formatted("%llu:%02llu:%02llu", hours, minutes, rest) : formatted("%llu:%02llu", minutes, rest);
}

}  // namespace

void Progress::step(uint64_t done, uint64_t total) {
  const double now = nowMs();
  if (done == 0 || done > total) return;
  const double left = (now - startMs_) / 1000 * static_cast<double>(total - done) / static_cast<double>(done);
  const std::string text = what_ + (" " + grouped(done)) + " of " + grouped(total) + ", " + timeText(left) + " left";
  if (inLines_ && lines_.isDue(done, total, now)) std::fprintf(stderr, "gnosphere: %s\n", text.c_str());
  if (!terminal_ || now - startMs_ < 1000 || now - lastMs_ < 100) return;
  lastMs_ = now;
  shown_ = barIsShown = true;
  constexpr uint64_t kCells = 24;
  const uint64_t full = kCells * done / total, columns = os::terminalColumns(stderr);
  const std::string bar = "[" + std::string(full, '#') + std::string(kCells - full, ' ') + "] ";
  std::string line = columns == 0 || bar.size() + text.size() < columns ? bar + text : text;
  if (columns > 0 && line.size() >= columns) line.resize(columns - 1);
  std::fprintf(stderr, "\r\x1b[K%s", line.c_str());
}

std::function<void(const char*, uint64_t, uint64_t)> stepProgress() {
  struct State {
    std::string name;
    std::unique_ptr<Progress> progress;
  };
  return [state = std::make_shared<State>()](const char* step, uint64_t done, uint64_t total) {
    if (state->name != step) {
      state->name = step;
      state->progress = nullptr;  // erases the line before the next step writes its own
      state->progress = std::make_unique<Progress>(state->name.c_str(), total);
    }
    state->progress->step(done);
  };
}

namespace {

std::vector<size_t> widthsOf(const std::vector<TableRow>& rows) {
  std::vector<size_t> widths;
  for (const TableRow& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  return widths;
}

}  // namespace

void printTable(const std::vector<TableRow>& given, size_t leftColumns) {
  std::vector<TableRow> rows = given;
  for (TableRow& row : rows)
    for (std::string& cell : row) cell = printable(cell);
  const std::vector<size_t> widths = widthsOf(rows);
  for (const TableRow& row : rows) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) {
      const std::string gap(widths[i] - row[i].size(), ' ');
      line.append(i ? "  " : "").append(i < leftColumns ? row[i] + gap : gap + row[i]);
    }
    std::printf("%s\n", line.c_str());
  }
  std::fflush(stdout);
}

void printMarkdown(const std::vector<TableRow>& rows) {
  const std::vector<size_t> widths = widthsOf(rows);
  for (size_t r = 0; r < rows.size(); ++r) {
    std::string line = "|", rule = "|";
    for (size_t i = 0; i < rows[r].size(); ++i) {
      const std::string gap(widths[i] - rows[r][i].size(), ' ');
      line.append(" ").append(i ? gap + rows[r][i] : rows[r][i] + gap).append(" |");
      rule.append(widths[i] + 1, '-').append(i ? ":|" : "-|");
    }
    std::printf("%s\n", line.c_str());
    if (r == 0) std::printf("%s\n", rule.c_str());
  }
  std::fflush(stdout);
}

}  // namespace gnosphere::cli
