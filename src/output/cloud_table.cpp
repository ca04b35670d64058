// SPDX-License-Identifier: Apache-2.0
#include "output/cloud_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "base/number.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

template <class T>
double load(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return static_cast<double>(value);
}

/// Whether a number is one of 32-bit floats, or the shortest decimal of one, as text files have it.
bool wasFloat(double value) {
  const auto rounded = static_cast<float>(value);
  if (double{rounded} == value || !std::isfinite(value)) return true;
  char text[32];
  const auto end = std::to_chars(text, text + sizeof(text), rounded).ptr;
  double shortest = 0;
  std::from_chars(text, end, shortest);
  return shortest == value;
}

bool isSeparator(char c) {
  return c == ' ' || c == '\t' || c == ',' || c == '\n' || c == '\r';
}

/// Parses a number into its place. A number too large becomes infinity, and one too small 0.
template <class T>
bool storeFloat(std::string_view word, char* out) {
  T value = 0;
  double wide = 0;
  const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
  if (result.ptr != word.data() + word.size() || result.ec == std::errc::invalid_argument) return false;
  if (result.ec == std::errc::result_out_of_range && parseNumber(word, wide)) value = static_cast<T>(wide);
  std::memcpy(out, &value, sizeof(value));
  return true;
}

/// Parses one word of a text file into its packed place. Floats are parsed as floats, to avoid a second rounding.
bool storeText(std::string_view word, const CloudColumn& column, char* out) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  if (column.type == 'F') return column.size == 8 ? storeFloat<double>(word, out) : storeFloat<float>(word, out);
  // Other tools write whole numbers as "12.0" or "1e3".
  double value = 0;
  if (!parseNumber(word, value) || !(value >= 0 && value <= 4294967295.0) || value != std::floor(value)) return false;
  const auto whole = static_cast<uint32_t>(value);
  if (column.size < 4 && (whole >> (8 * column.size)) != 0) return false;
  std::memcpy(out, &whole, column.size);  // little endian: the low bytes come first
  return true;
}

}  // namespace

void CloudTable::refuse(const std::string& why) const {
  throw Error(ErrorCode::format, source + ": " + why);
}

const CloudColumn* CloudTable::find(std::string_view name) const {
  for (const CloudColumn& column : columns) {
    const ColumnInfo* info = findColumn(column.name);
    if (info && name == info->name) return &column;
  }
  return nullptr;
}

double CloudTable::value(const CloudColumn& column, size_t row) const {
  const char* at = bytes.data() + column.offset + row * column.step;
  switch (column.type) {
    case 'F': return column.size == 4 ? load<float>(at) : load<double>(at);
    case 'U':
      switch (column.size) {
        case 1: return load<uint8_t>(at);
        case 2: return load<uint16_t>(at);
        case 4: return load<uint32_t>(at);
        default: return load<uint64_t>(at);
      }
    default:
      switch (column.size) {
        case 1: return load<int8_t>(at);
        case 2: return load<int16_t>(at);
        case 4: return load<int32_t>(at);
        default: return load<int64_t>(at);
      }
  }
}

std::array<const CloudColumn*, 3> CloudTable::axes() const {
  return {find("x"), find("y"), find("z")};
}

Origin CloudTable::originNearby() const {
  constexpr double kGrid = 1024;
  const auto columnsOfAxes = axes();
  if (std::count(columnsOfAxes.begin(), columnsOfAxes.end(), nullptr) > 0) return {};
  for (size_t row = 0; row < rows; ++row) {
    Origin origin;
    for (size_t axis = 0; axis < 3; ++axis)
      origin[axis] = kGrid * std::round(value(*columnsOfAxes[axis], row) / kGrid) + 0.0;  // -0 becomes 0
    if (std::all_of(origin.begin(), origin.end(), [](double x) { return std::isfinite(x); })) return origin;
  }
  return {};
}

double CloudTable::floatStep(const Origin& origin) const {
  const auto columnsOfAxes = axes();
  float farthest = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    if (origin[axis] == 0) continue;
    if (!columnsOfAxes[axis] || !isRounded(*columnsOfAxes[axis])) return 0;
    farthest = std::max(farthest, static_cast<float>(std::abs(origin[axis])));
  }
  return farthest > 0 ? double{std::nextafter(farthest, HUGE_VALF)} - double{farthest} : 0;
}

bool CloudTable::isRounded(const CloudColumn& column) const {
  if (column.type != 'F') return false;
  for (size_t row = 0; column.size == sizeof(double) && row < rows; ++row)
    if (!wasFloat(value(column, row))) return false;
  return true;
}

void CloudTable::layRows(size_t offset) {
  size_t stride = 0;
  for (CloudColumn& column : columns) {
    column.offset = offset + stride;
    stride += column.size * column.count;
  }
  for (CloudColumn& column : columns) column.step = stride;
  const size_t room = bytes.size() - std::min(offset, bytes.size());
  if (stride == 0 || rows > room / stride) {
    refuse("is cut short: " + std::to_string(rows) + " points of " + std::to_string(stride) + " bytes are stated, " +
           std::to_string(room) + " bytes are there");
  }
}

void CloudTable::parseTextRows(size_t offset) {
  /// The words of a column in each row, and the place of the value in the packed row.
  struct ColumnWords {
    size_t count;
    const CloudColumn* target = nullptr;  ///< null: the words are skipped, because the column is no field
    size_t place = 0;
  };
  std::vector<CloudColumn> ours;
  ours.reserve(columns.size());
  std::vector<ColumnWords> words;
  size_t stride = 0, wordCount = 0;
  for (const CloudColumn& column : columns) {
    const ColumnInfo* info = column.count == 1 ? findColumn(column.name) : nullptr;
    words.push_back({column.count});
    wordCount += column.count;
    if (!info) continue;
    const bool isCoordinate = info->field == Field::x || info->field == Field::y || info->field == Field::z;
    ours.push_back({column.name, letterOf(info->type), isCoordinate ? sizeof(double) : sizeOf(info->type)});
    words.back() = {1, &ours.back(), stride};
    stride += ours.back().size;
  }
  // Every word takes at least two characters, so an absurd count is refused before memory is allocated.
  if (wordCount == 0 || rows > (bytes.size() - offset + 1) / (2 * wordCount))
    refuse("is cut short: " + std::to_string(rows) + " points of " + std::to_string(wordCount) + " values are stated");
  std::string packed(rows * stride, '\0');
  const char* at = bytes.data() + offset;
  const char* end = bytes.data() + bytes.size();
  for (size_t row = 0; row < rows; ++row) {
    for (const auto& [count, target, place] : words) {
      for (size_t k = 0; k < count; ++k) {
        at = std::find_if_not(at, end, isSeparator);
        const char* stop = std::find_if(at, end, isSeparator);
        const std::string_view text(at, static_cast<size_t>(stop - at));
        if (text.empty()) refuse("is cut short in point " + std::to_string(row) + " of " + std::to_string(rows));
        if (target && !storeText(text, *target, packed.data() + row * stride + place))
          refuse("point " + std::to_string(row) + ": '" + std::string(text.substr(0, 40)) +
                 "' does not fit the field '" + target->name + "'");
        at = stop;
      }
    }
  }
  bytes = std::move(packed);
  columns = std::move(ours);
  if (rows > 0 && stride > 0) layRows(0);
}

void CloudTable::readGridComment(std::string_view line) {
  const size_t start = line.find("gnosphere columns");
  if (start == line.npos) return;
  const std::string text(line.substr(start));
  const int count = std::sscanf(text.c_str(), kGridCommentReturns, &gridColumns, &gridChannels, &gridReturns);
  if (count < 2) gridColumns = gridChannels = 0;
  if (count < 3) gridReturns = 1;
  const size_t name = text.find(" sensor ");
  if (name != text.npos) sensor = text.substr(name + 8);
  skewed = std::string_view(text).substr(0, name).ends_with(kSkewed);
}

bool nextLine(std::string_view text, size_t& position, std::string_view& line) {
  if (position >= text.size()) return false;
  const size_t end = std::min(text.find('\n', position), text.size());
  line = text.substr(position, end - position);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  position = end + 1;
  return true;
}

std::vector<std::string_view> splitWords(std::string_view line) {
  std::vector<std::string_view> words;
  for (auto at = line.begin(); at != line.end();) {
    at = std::find_if_not(at, line.end(), isSeparator);
    const auto stop = std::find_if(at, line.end(), isSeparator);
    if (at != stop) words.emplace_back(&*at, static_cast<size_t>(stop - at));
    at = stop;
  }
  return words;
}

uint64_t parseCount(const CloudTable& table, std::string_view word, const char* what) {
  uint64_t value = 0;
  const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
  if (result.ec != std::errc() || result.ptr != word.data() + word.size()) {
    table.refuse(std::string(what) + " must be a count, is '" + std::string(word.substr(0, 40)) + "'");
  }
  return value;
}

}  // namespace gnosphere
