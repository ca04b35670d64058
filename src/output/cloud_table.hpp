// SPDX-License-Identifier: Apache-2.0
// The rows of a cloud file as they lie in memory: the one form that every reader produces and readCloud() places by
// beam.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "output/cloud_format.hpp"
#include "scan/fields.hpp"

namespace gnosphere {

struct CloudColumn {
  std::string name;
  char type = 'F';  ///< PCD's letters: F float, U unsigned, I signed
  size_t size = 4;  ///< bytes of one value
  size_t count = 1;
  size_t offset = 0;  ///< of the first row, from the start of `bytes`
  size_t step = 0;    ///< from row to row
};

struct CloudTable {
  std::string source;  ///< for messages
  std::string bytes;
  std::vector<CloudColumn> columns;
  size_t rows = 0;
  /// How the rows lie, where the file says so: width x height = rows.
  uint32_t width = 0, height = 0;
  /// The sensor's grid, where a comment of ours says so.
  uint32_t gridColumns = 0, gridChannels = 0, gridReturns = 1;
  std::string sensor;

  [[noreturn]] void refuse(const std::string& why) const;  ///< throws Error(format)
  const CloudColumn* find(std::string_view name) const;
  double value(const CloudColumn& column, size_t row) const;

  /// Packed rows of `columns` from `offset` on. Refuses if the bytes do not suffice.
  void layRows(size_t offset);
  /// Text rows from `offset` on, separated by spaces, tabs or commas: replaces bytes and columns by those of our
  /// fields.
  void parseTextRows(size_t offset);
  /// Takes the grid from a comment line, if it is one that we write.
  void readGridComment(std::string_view line);
};

CloudTable readPcd(std::string bytes, const std::string& source);
CloudTable readPly(std::string bytes, const std::string& source);
CloudTable readNpy(std::string bytes, const std::string& source);
CloudTable readCsv(std::string bytes, const std::string& source);

/// readCloud() of a file's content; `source` names it in messages. Throws Error(format).
Scan readCloudBytes(CloudFormat format, std::string bytes, const std::string& source);

/// The next line from `position` on without its end, which may be \n or \r\n. False at the end of the text.
bool nextLine(std::string_view text, size_t& position, std::string_view& line);
std::vector<std::string_view> splitWords(std::string_view line);
/// The whole word as a count. Refuses anything else.
uint64_t parseCount(const CloudTable& table, std::string_view word, const char* what);

}  // namespace gnosphere
