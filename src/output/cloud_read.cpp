// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>
#include <unordered_map>

#include "base/file.hpp"
#include "base/text.hpp"
#include "base/utf8.hpp"
#include "base/vector.hpp"
#include "gnosphere/error.hpp"
#include "output/cloud_table.hpp"
#include "scan/columns.hpp"
#include "scan/image_order.hpp"

namespace gnosphere {
namespace {

/// Limit on the grid of a file that holds only some of its beams. The limit bounds the memory (450 MiB) that a small,
/// invalid file can make us allocate: twice the largest sensor model we know, or more if the file has a point for one
/// beam in 64.
uint64_t maxSparseBeams(const CloudTable& table) {
  return std::max(uint64_t{1} << 24, uint64_t{64} * table.rows);
}

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Limit on returns per beam, more than any sensor gives. The limit bounds the memory that one invalid value can make
/// us allocate.
constexpr uint32_t kMostReturns = 16;

struct Grid {
  uint32_t columns = 0, channels = 0;
  bool stated = true;  ///< whether no beam may lie beyond the grid
  bool known = false;  ///< whether the file states its columns and channels, more than one
};

uint32_t whole(const CloudTable& table, const CloudColumn& column, size_t row) {
  const double value = table.value(column, row);
  if (!(value >= 0 && value <= 4294967295.0 && value == std::floor(value)))
    table.refuse("point " + std::to_string(row) + ": '" + column.name + "' is not a whole number of 32 bits");
  return static_cast<uint32_t>(value);
}

/// If the file does not state its grid, the rings may define one: every beam of ring j must lie in row j.
Grid gridFromRings(const CloudTable& table, const CloudColumn& beam, uint64_t beams) {
  const Grid line{static_cast<uint32_t>(beams), 1, false};
  const CloudColumn* ring = table.find("ring");
  if (!ring) return line;
  uint64_t channels = 1;
  for (size_t row = 0; row < table.rows; ++row) channels = std::max(channels, uint64_t{whole(table, *ring, row)} + 1);
  if (beams % channels != 0) return line;
  const uint64_t columns = beams / channels;
  for (size_t row = 0; row < table.rows; ++row) {
    if (whole(table, beam, row) / columns != whole(table, *ring, row)) return line;
  }
  return {static_cast<uint32_t>(columns), static_cast<uint32_t>(channels), false};
}

/// Whether the file has a row for every entry of the grid that it states.
bool hasEveryEntry(const CloudTable& table) {
  const uint64_t beams = uint64_t{table.gridColumns} * table.gridChannels;
  return table.gridReturns > 0 && table.rows % table.gridReturns == 0 && table.rows / table.gridReturns == beams;
}

/// Returns per beam: the number that the file states, or the largest that its rows need.
uint32_t findReturns(const CloudTable& table, const std::vector<uint32_t>& numbers) {
  if (numbers.empty() && table.rows > 0 && !hasEveryEntry(table)) return 1;
  uint32_t returns = std::max(1u, table.gridReturns);
  for (const uint32_t number : numbers) returns = std::max(returns, number);
  if (returns > kMostReturns) {
    table.refuse("has a return number " + std::to_string(returns) + "; there may be " + std::to_string(kMostReturns));
  }
  return returns;
}

/// `returns` is the largest number of returns per beam.
Grid findGrid(const CloudTable& table, const CloudColumn* beam, uint32_t returns) {
  if (table.rows > 0xfffffffeu) table.refuse("has more points than a 32-bit index holds");
  const uint64_t fewest = (table.rows + returns - 1) / returns;  // least number of beams that can have these rows
  // Rows are returns where beams have several, and without the column `beam` nothing tells whose, unless all are there.
  if (table.gridColumns > 0 && (beam || table.gridReturns <= 1 || hasEveryEntry(table))) {
    const uint64_t beams = uint64_t{table.gridColumns} * table.gridChannels;
    if (beams < fewest || (beams > fewest && beams > maxSparseBeams(table) / returns)) {
      table.refuse("its grid of " + std::to_string(table.gridColumns) + " columns x " +
                   std::to_string(table.gridChannels) + " channels does not suit " + std::to_string(table.rows) +
                   " points");
    }
    // If there are fewer points than beams, only the column `beam` tells which beam a point belongs to.
    if (beam || beams * returns == table.rows)
      return {table.gridColumns, table.gridChannels, true, table.gridChannels > 1};
  }
  uint64_t beams = fewest;
  for (size_t row = 0; beam && row < table.rows; ++row) beams = std::max(beams, uint64_t{whole(table, *beam, row)} + 1);
  if (table.height > 1) {
    // The returns of a beam stand side by side, as writeCloud() writes them, if all beams have a place then.
    const uint32_t columns = table.width % returns == 0 ? table.width / returns : table.width;
    return {beams > uint64_t{columns} * table.height ? table.width : columns, table.height, true, true};
  }
  if (!beam) return {static_cast<uint32_t>(table.rows), 1};
  if (beams > fewest && beams * returns > maxSparseBeams(table)) {
    table.refuse("has " + std::to_string(table.rows) + " points of at least " + std::to_string(beams) + " beams");
  }
  return gridFromRings(table, *beam, beams);
}

/// Returns the entry in the scan's arrays for each row; empty if entry = row.
std::vector<size_t> placeRows(const CloudTable& table, const CloudColumn* beam, const std::vector<uint32_t>& numbers,
                              size_t beamCount, uint32_t returns) {
  std::vector<size_t> entries;
  if (!beam) return entries;
  std::vector<bool> taken(beamCount * returns, false);
  entries.reserve(table.rows);
  for (size_t row = 0; row < table.rows; ++row) {
    const uint32_t b = whole(table, *beam, row);
    if (b >= beamCount) {
      table.refuse("point " + std::to_string(row) + " is of beam " + std::to_string(b) + ", the grid has " +
                   std::to_string(beamCount));
    }
    const uint32_t k = numbers.empty() ? 1 : numbers[row];
    const size_t entry = size_t{b} * returns + k - 1;
    if (taken[entry]) {
      table.refuse((returns > 1 ? "return " + std::to_string(k) + " of beam " : std::string("beam ")) +
                   std::to_string(b) + " occurs twice");
    }
    taken[entry] = true;
    entries.push_back(entry);
  }
  return entries;
}

/// Copies columns of the table into a scan; entries without a row keep the values of a miss.
class Placer {
 public:
  Placer(const CloudTable& table, size_t entryCount, std::vector<size_t> entries)
      : table_(table), entryCount_(entryCount), entries_(std::move(entries)) {}

  /// Copies the column of that name, if the table has it.
  template <class T>
  void place(const char* name, std::vector<T>& out, T none) const {
    const CloudColumn* column = table_.find(name);
    if (!column || entryCount_ == 0) return;
    out.resize(entryCount_, none);
    put(*column, out.data(), 1);
  }

  /// Copies the points, relative to an origin.
  void placePoints(const Origin& origin, std::vector<float>& out) const {
    out.resize(3 * entryCount_, kNaN);
    const auto axes = table_.axes();
    for (size_t axis = 0; axis < 3; ++axis)
      for (size_t row = 0; row < table_.rows; ++row)
        out[3 * entryOf(row) + axis] = static_cast<float>(table_.value(*axes[axis], row) - origin[axis]);
  }

  /// Copies the columns of a field, as far as the table has them.
  void placeField(Field field, ScanColumns& columns) const {
    switch (fieldInfo(field).type) {
      case ValueType::f32: return placeField(field, kNaN, columns);
      case ValueType::u32: return placeField(field, kNoTriangle, columns);
      case ValueType::u16: return placeField(field, uint16_t{0}, columns);
      case ValueType::u8: return placeField(field, noneOf(field), columns);
      case ValueType::f64: return;
    }
  }

 private:
  static uint8_t noneOf(Field field) {
    return field == Field::cause ? static_cast<uint8_t>(Cause::noSurface) : uint8_t{0};
  }

  template <class T>
  void placeField(Field field, T none, ScanColumns& columns) const {
    const std::vector<ColumnInfo> infos = columnsOf({field});
    for (const ColumnInfo& info : infos) {
      const CloudColumn* column = table_.find(info.name);
      if (!column) continue;
      if (!columns.data<T>(field)) columns.fill(field, none);
      if (entryCount_ == 0) return;
      put(*column, columns.data<T>(field) + info.component, infos.size());
    }
  }

  template <class T>
  void put(const CloudColumn& column, T* out, size_t step) const {
    for (size_t row = 0; row < table_.rows; ++row) out[entryOf(row) * step] = value<T>(column, row);
  }

  size_t entryOf(size_t row) const { return entries_.empty() ? row : entries_[row]; }

  template <class T>
  T value(const CloudColumn& column, size_t row) const {
    if constexpr (std::is_same_v<T, float>) {
      return static_cast<float>(table_.value(column, row));
    } else {
      const uint32_t number = whole(table_, column, row);
      if (number > std::numeric_limits<T>::max()) {
        table_.refuse("point " + std::to_string(row) + ": '" + column.name + "' is " + std::to_string(number) +
                      ", more than the field holds");
      }
      return static_cast<T>(number);
    }
  }

  const CloudTable& table_;
  size_t entryCount_;
  std::vector<size_t> entries_;
};

/// Refuses a table with two columns of one field.
void refuseTwins(const CloudTable& table) {
  std::set<std::string_view> found;
  for (const CloudColumn& column : table.columns) {
    const ColumnInfo* info = findColumn(column.name);
    if (info && !found.insert(info->name).second) table.refuse("has the field '" + std::string(info->name) + "' twice");
  }
}

/// The values of a line of a CSV file.
struct CsvLine {
  size_t values = 0;
  bool hasGap = false;  ///< whether a comma has no value before it
};

CsvLine readCsvLine(std::string_view line) {
  CsvLine read;
  bool inValue = false, filled = false;  // whether the last character was of a value, and any since the last comma was
  for (const char c : line) {
    const bool isValue = c != ' ' && c != '\t' && c != ',' && c != '\r';
    read.values += isValue && !inValue;
    read.hasGap |= c == ',' && !filled;
    filled = isValue || (filled && c != ',');
    inValue = isValue;
  }
  return read;
}

/// Reads the line with the names of the columns; afterwards `position` is the start of the next line, and `number` the
/// number of the line with the names, counted from 1. Lines that begin with # are comments, but the last of them has
/// the names if a line of numbers follows.
void readCsvHead(CloudTable& table, size_t& position, size_t& number) {
  std::string_view head, line;
  size_t below = position;
  while (nextLine(table.bytes, below, line)) {
    const std::string_view text = trimmed(line);
    const bool isComment = text.starts_with('#'), startsNumber = text.find_first_of("0123456789+-.") == 0;
    if (startsNumber && !head.empty()) break;
    ++number;
    position = std::min(below, table.bytes.size());
    if (!text.empty()) head = trimmed(text.substr(isComment));
    if (!isComment && !text.empty()) break;
  }
  if (head.empty()) table.refuse("is empty, a CSV cloud starts with the names of its fields");
  for (const std::string_view name : splitWords(head)) table.columns.push_back({std::string(trimmed(name, "\""))});
  if (std::none_of(table.columns.begin(), table.columns.end(), [](const auto& c) { return findColumn(c.name); }))
    table.refuse("its first line must have the names of fields with commas between, as x,y,z,range, and has '" +
                 plainAscii(std::string(head.substr(0, 60))) + "'");
}

}  // namespace

CloudTable readCloudTable(const CloudFormat& format, std::string bytes, const std::string& source) {
  if (format.read) {
    CloudTable table = format.read(std::move(bytes), source);
    refuseTwins(table);
    return table;
  }
  throw Error(ErrorCode::invalidArgument, source + ": a " + (*format.name ? format.name : format.ending) +
                                              " cloud does not say which beams its points are of; read " +
                                              cloudEndings("or", true));
}

std::vector<uint32_t> numberReturns(const CloudTable& table) {
  const CloudColumn *beam = table.find("beam"), *number = beam ? table.find("return") : nullptr;
  const bool statesOne = table.gridColumns > 0 && table.gridReturns == 1;
  std::vector<uint32_t> numbers;
  if (!beam || (!number && statesOne)) return numbers;
  std::unordered_map<uint32_t, uint32_t> found;
  numbers.reserve(table.rows);
  for (size_t row = 0; row < table.rows; ++row)
    numbers.push_back(number ? whole(table, *number, row) : ++found[whole(table, *beam, row)]);
  if (std::ranges::count(numbers, 0u) == 0) return numbers;
  for (size_t row = 0; row < table.rows; ++row) {
    uint32_t& last = found[whole(table, *beam, row)];
    last = std::max(last, numbers[row]);
  }
  for (size_t row = 0; row < table.rows; ++row)
    if (numbers[row] == 0) numbers[row] = ++found[whole(table, *beam, row)];
  return numbers;
}

CloudTable readCsv(std::string bytes, const std::string& source) {
  CloudTable table;
  table.source = source;
  table.bytes = std::move(bytes);
  if (table.bytes.find('\n') == std::string::npos)  // lines may end with \r alone
    std::replace(table.bytes.begin(), table.bytes.end(), '\r', '\n');
  size_t position = table.bytes.size() - textOfFile(table.bytes, source).size(), number = 0;
  readCsvHead(table, position, number);
  std::string_view line;
  for (size_t at = position; nextLine(table.bytes, at, line);) {
    const CsvLine row = readCsvLine(line);
    ++number;
    if (row.values == 0 && !row.hasGap) continue;
    const std::string where = "line " + std::to_string(number);
    if (row.hasGap) table.refuse(where + " has an empty value; write nan for a number that is not known");
    if (row.values != table.columns.size())
      table.refuse(where + " has " + std::to_string(row.values) + " values, the head names " +
                   std::to_string(table.columns.size()));
    ++table.rows;
  }
  table.parseTextRows(position);
  return table;
}

namespace {

/// Sorts the rows of a table by beam; points are from `origin`.
CloudFile cloudOf(const CloudTable& table, const Origin& origin) {
  const bool hasPoints = table.find("x") && table.find("y") && table.find("z");
  if (!hasPoints && !table.find("range")) table.refuse("has neither x, y, z nor range: not a cloud");
  const CloudColumn* beam = table.find("beam");
  const std::vector<uint32_t> numbers = numberReturns(table);
  CloudFile read;
  read.origin = origin;
  read.floatStep = hasPoints ? table.floatStep(origin) : 0;
  Scan& scan = read.scan;
  scan.sensor = table.sensor;
  scan.skewed = table.skewed;
  scan.poseKnown = table.pose.has_value();
  scan.pose = table.pose.value_or(Pose());
  scan.returns = findReturns(table, numbers);
  const Grid grid = findGrid(table, beam, scan.returns);
  read.statesGrid = grid.stated;
  scan.columns = grid.columns;
  scan.channels = grid.channels;
  scan.gridKnown = grid.known;
  const size_t beamCount = size_t{grid.columns} * grid.channels, entryCount = beamCount * scan.returns;
  const Placer placer(table, entryCount, placeRows(table, beam, numbers, beamCount, scan.returns));
  if (hasPoints) placer.placePoints(origin, scan.points);
  placer.place("range", scan.ranges, kNaN);
  if (scan.ranges.empty()) {
    scan.ranges.reserve(entryCount);
    for (size_t entry = 0; entry < entryCount; ++entry) {
      const float* p = &scan.points[3 * entry];
      scan.ranges.push_back(static_cast<float>(lengthOf({p[0], p[1], p[2]})));
    }
  }
  placer.place("triangle", scan.triangles, kNoTriangle);
  placer.place("instance", scan.instances, kNoTriangle);
  ScanColumns columns(scan);
  columns.setUnknown(Field::triangle, !table.find("triangle"));
  columns.setUnknown(Field::instance, !table.find("instance"));
  columns.setUnknown(Field::x, !hasPoints);
  scan.triangles.resize(entryCount, kNoTriangle);
  scan.instances.resize(entryCount, kNoTriangle);
  for (const ColumnInfo& column : allColumns()) {
    const Field field = column.field;
    if (column.component > 0 || isOfEveryScan(field) || followsFromIndex(field)) continue;
    // A compact file of several returns has no rows for beams without any, so it cannot say why they are empty.
    if (field != Field::cause || scan.returns == 1 || table.rows == entryCount) placer.placeField(field, columns);
  }

  scan.counters.beams = beamCount;
  for (size_t b = 0; b < beamCount; ++b) {
    const auto* first = &scan.ranges[b * scan.returns];
    scan.counters.hits += std::any_of(first, first + scan.returns, [](float range) { return !std::isnan(range); });
  }
  scan.counters.misses = beamCount - scan.counters.hits;
  const ImageOrder order = imageOrderOf(scan);
  scan.firstRowOnTop = order.firstRowOnTop;
  scan.firstColumnOnLeft = order.firstColumnOnLeft;
  return read;
}

CloudTable tableOf(const std::filesystem::path& file) {
  const CloudFormat& format = cloudFormat(file, true);
  std::string bytes = format.read ? readWholeFile(file) : "";  // otherwise the file is refused before it is read
  return readCloudTable(format, std::move(bytes), file.string());
}

}  // namespace

CloudFile readCloudBytes(const CloudFormat& format, std::string bytes, const std::string& source) {
  return cloudOf(readCloudTable(format, std::move(bytes), source), {});
}

Scan readCloud(const std::filesystem::path& file) {
  return readCloudFile(file).scan;
}

CloudFile readCloudFile(const std::filesystem::path& file) {
  return cloudOf(tableOf(file), {});
}

std::pair<CloudFile, CloudFile> readCloudFiles(const std::filesystem::path& reference,
                                               const std::filesystem::path& other) {
  std::pair<CloudFile, CloudFile> read;
  {
    const CloudTable table = tableOf(reference);  // its memory is free when the other is read
    read.first = cloudOf(table, table.originNearby());
  }
  read.second = cloudOf(tableOf(other), read.first.origin);
  return read;
}

}  // namespace gnosphere
