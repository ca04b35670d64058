// SPDX-License-Identifier: Apache-2.0
// Reads NPY 1.0 to 3.0 as numpy.save() writes it: arrays of a structured type, as those of writeCloud(), and plain
// arrays of x, y, z and perhaps the intensity.
#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

#include "base/npy.hpp"
#include "output/cloud_table.hpp"

namespace gnosphere {
namespace {

/// Whether a type is a gap between the fields of an aligned type: |V and a number of bytes.
bool isGap(const std::string& type, size_t& bytes) {
  if (!type.starts_with("|V")) return false;
  const char* end = type.data() + type.size();
  const auto result = std::from_chars(type.data() + 2, end, bytes);
  return result.ec == std::errc() && result.ptr == end && bytes > 0 && bytes <= 65536;
}

void addColumn(CloudTable& table, const std::string& name, const std::string& type) {
  CloudColumn column;
  if (isGap(type, column.count)) {
    column.name = kGapName;
    column.type = 'U';
    column.size = 1;
    table.columns.push_back(column);
    return;
  }
  const bool known = type.size() == 3 && std::string_view("<>|").find(type[0]) != std::string_view::npos &&
                     std::string_view("fui").find(type[1]) != std::string_view::npos &&
                     std::string_view(type[1] == 'f' ? "48" : "1248").find(type[2]) != std::string_view::npos;
  if (!known) table.refuse("NPY field '" + name + "' has the type '" + type + "', which is not read");
  column.name = name;
  column.type = type[1] == 'f' ? 'F' : type[1] == 'u' ? 'U' : 'I';
  column.size = static_cast<size_t>(type[2] - '0');
  table.columns.push_back(column);
}

/// Lays out a plain array whose rows are points; in Fortran order it has one column after the other.
void layPlain(CloudTable& table, const NpyHeader& header) {
  const std::vector<uint64_t>& shape = header.shape;
  const bool isFloat = header.type.size() == 3 && header.type[1] == 'f';
  if (!isFloat || shape.size() != 2 || (shape[1] != 3 && shape[1] != 4))
    table.refuse(
        "NPY array has no field names, and is no array of floats with the shape (N, 3) for x, y, z or (N, 4) for "
        "x, y, z, intensity; save a structured array");
  for (const char* name : {"x", "y", "z", "intensity"})
    if (table.columns.size() < shape[1]) addColumn(table, name, header.type);
  table.rows = shape[0];
  table.layRows(header.dataAt);
  if (!header.fortran) return;
  for (size_t i = 0; i < table.columns.size(); ++i) {
    CloudColumn& column = table.columns[i];
    column.step = column.size;
    column.offset = header.dataAt + i * column.size * table.rows;
  }
}

/// Lays out an array of a structured type: rows, channels x columns, or channels x columns x returns.
void layStructured(CloudTable& table, const NpyHeader& header) {
  const std::vector<uint64_t>& shape = header.shape;
  for (const auto& [name, type] : header.columns) addColumn(table, name, type);
  if (table.columns.empty()) table.refuse("NPY header names no field");
  if (shape.empty() || shape.size() > 3) table.refuse("NPY array must have one to three dimensions");
  if (header.fortran && shape.size() > 1) table.refuse("NPY array is in Fortran order; save it in C order");
  table.rows = shape[0] * (shape.size() > 1 ? shape[1] : 1);
  if (shape.size() == 2) {
    table.height = static_cast<uint32_t>(shape[0]);
    table.width = static_cast<uint32_t>(shape[1]);
  }
  if (shape.size() == 3) {
    if (shape[2] > 0 && table.rows > std::numeric_limits<uint32_t>::max() / shape[2])
      table.refuse("has more points than a 32-bit index holds");
    table.rows *= shape[2];
    table.gridChannels = static_cast<uint32_t>(shape[0]);
    table.gridColumns = static_cast<uint32_t>(shape[1]);
    table.gridReturns = static_cast<uint32_t>(shape[2]);
  }
  table.layRows(header.dataAt);
}

/// Turns the bytes of the values whose types are big-endian.
void turnBytes(CloudTable& table, const NpyHeader& header) {
  for (size_t i = 0; i < table.columns.size(); ++i) {
    if ((header.type.empty() ? header.columns[i].type : header.type)[0] != '>') continue;
    const CloudColumn& column = table.columns[i];
    for (size_t row = 0; row < table.rows; ++row) {
      char* const value = table.bytes.data() + column.offset + row * column.step;
      std::reverse(value, value + column.size);
    }
  }
}

}  // namespace

CloudTable readNpy(std::string bytes, const std::string& source) {
  CloudTable table;
  table.source = source;
  table.bytes = std::move(bytes);
  const std::string_view all = table.bytes;
  if (all.size() < 12 || all.substr(0, 6) != "\x93NUMPY") table.refuse("is not an NPY file");
  const NpyHeader header = readNpyHeader(all, source);
  for (uint64_t extent : header.shape) {
    if (extent > std::numeric_limits<uint32_t>::max()) table.refuse("NPY shape is beyond 32 bits");
  }
  if (header.type.empty())
    layStructured(table, header);
  else
    layPlain(table, header);
  turnBytes(table, header);
  return table;
}

}  // namespace gnosphere
