// SPDX-License-Identifier: Apache-2.0
// The rows of a cloud file in memory. Every reader produces this form, and readCloud() sorts it by beam.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "output/cloud_file.hpp"
#include "output/cloud_format.hpp"
#include "scan/fields.hpp"

namespace gnosphere {

struct CloudColumn {
  std::string name;
  char type = 'F';  ///< PCD's letters: F float, U unsigned, I signed
  size_t size = 4;  ///< bytes of one value
  size_t count = 1;
  size_t offset = 0;  ///< of the first value, from the start of `bytes`
  size_t step = 0;    ///< from one row to the next
};

/// The name of a column that only fills a gap between others, as PCL pads its rows.
inline constexpr const char* kGapName = "_";

struct CloudTable {
  std::string source;  ///< for messages
  std::string bytes;
  std::vector<CloudColumn> columns;
  size_t rows = 0;
  /// The organisation of the rows, if the file states one: width x height = rows.
  uint32_t width = 0, height = 0;
  /// The sensor's grid, its name and Scan::skewed, if the file has the comment that writeCloud() writes.
  uint32_t gridColumns = 0, gridChannels = 0, gridReturns = 1;
  std::string sensor;
  bool skewed = false;
  std::optional<Pose> pose;  ///< the pose of the sensor, if the file states one

  [[noreturn]] void refuse(const std::string& why) const;  ///< throws Error(format)
  const CloudColumn* find(std::string_view name) const;
  double value(const CloudColumn& column, size_t row) const;
  /// The columns x, y, z; null for one that the table does not have.
  std::array<const CloudColumn*, 3> axes() const;
  /// The origin near the first point; that of the frame if there is none.
  Origin originNearby() const;
  /// The step between 32-bit floats at an origin, in metres, if the coordinates of the table have been rounded to such;
  /// otherwise, and at the frame's origin, 0.
  double floatStep(const Origin& origin) const;

  /// Lays out packed rows of `columns` from `offset` on. Refuses the file if it has too few bytes.
  void layRows(size_t offset);
  /// Parses text rows from `offset` on, separated by spaces, tabs or commas. Replaces bytes and columns by those of our
  /// fields, coordinates as doubles.
  void parseTextRows(size_t offset);
  /// Reads the grid, whether the points are skewed, and the sensor's name from a comment that writeCloud() wrote.
  void readGridComment(std::string_view line);

 private:
  bool isRounded(const CloudColumn& column) const;  ///< whether its values have been rounded to 32-bit floats
};

CloudTable readPcd(std::string bytes, const std::string& source);
CloudTable readPly(std::string bytes, const std::string& source);
CloudTable readNpy(std::string bytes, const std::string& source);
CloudTable readCsv(std::string bytes, const std::string& source);

/// Reads the rows of a file's content; `source` names it in messages. Throws Error(invalidArgument) if the format has
/// no reader.
CloudTable readCloudTable(const CloudFormat& format, std::string bytes, const std::string& source);
/// Does the work of readCloudFile() on a file's content; `source` names it in messages. Throws Error(format) if it is
/// bad.
CloudFile readCloudBytes(const CloudFormat& format, std::string bytes, const std::string& source);

/// Returns the return number of each row, counted from 1, as the column `return` states it. A row with the number 0 is
/// an entry without a return, and is numbered after the returns of its beam. Without that column the rows of a beam are
/// its returns in their order. The list is empty if every row is a beam of its own.
std::vector<uint32_t> numberReturns(const CloudTable& table);

/// Reads the next line from `position` on without its end, which is \n or \r\n. Returns false at the end of the text.
bool nextLine(std::string_view text, size_t& position, std::string_view& line);
std::vector<std::string_view> splitWords(std::string_view line);
/// Parses the whole word as a count. Refuses the file if it is anything else.
uint64_t parseCount(const CloudTable& table, std::string_view word, const char* what);

}  // namespace gnosphere
