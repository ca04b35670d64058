// SPDX-License-Identifier: Apache-2.0
// Reads NPY 1.0 to 3.0 with a structured type, as numpy.save() and writeCloud() write it.
#include <limits>

#include "base/npy.hpp"
#include "output/cloud_table.hpp"

namespace gnosphere {
namespace {

void addColumns(CloudTable& table, const NpyHeader& header) {
  if (!header.type.empty()) table.refuse("NPY array has no field names; a cloud needs x, y, z ...");
  for (const auto& [name, type] : header.columns) {
    const bool known = type.size() == 3 && (type[0] == '<' || type[0] == '|') &&
                       std::string_view("fui").find(type[1]) != std::string_view::npos &&
                       std::string_view(type[1] == 'f' ? "48" : "1248").find(type[2]) != std::string_view::npos;
    if (!known) table.refuse("NPY field '" + name + "' has the type '" + type + "', which is not read");
    CloudColumn column;
    column.name = name;
    column.type = type[1] == 'f' ? 'F' : type[1] == 'u' ? 'U' : 'I';
    column.size = static_cast<size_t>(type[2] - '0');
    table.columns.push_back(column);
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
  const std::vector<uint64_t>& shape = header.shape;
  addColumns(table, header);
  if (table.columns.empty()) table.refuse("NPY header names no field");
  if (shape.empty() || shape.size() > 2) table.refuse("NPY array must have one or two dimensions");
  for (uint64_t extent : shape) {
    if (extent > std::numeric_limits<uint32_t>::max()) table.refuse("NPY shape is beyond 32 bits");
  }
  if (header.fortran && shape.size() > 1) table.refuse("NPY array is in Fortran order; save it in C order");
  table.rows = shape[0] * (shape.size() == 2 ? shape[1] : 1);
  if (shape.size() == 2) {
    table.height = static_cast<uint32_t>(shape[0]);
    table.width = static_cast<uint32_t>(shape[1]);
  }
  table.layRows(header.dataAt);
  return table;
}

}  // namespace gnosphere
