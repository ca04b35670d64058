// SPDX-License-Identifier: Apache-2.0
// The rows of a cloud file to write, and the parts of the file that differ between formats.
#pragma once

#include <string>
#include <vector>

#include "output/rows.hpp"
#include "scan/fields.hpp"

namespace gnosphere {

/// The rows to write, their layout in memory, and the columns of the file.
struct CloudRows {
  Rows rows;
  RecordLayout layout;
  std::vector<ColumnInfo> columns;
};

std::string pcdHeader(const CloudRows& rows, bool ascii);
std::string plyHeader(const CloudRows& rows, bool ascii);
std::string npyHeader(const CloudRows& rows, bool ascii);
std::string csvHeader(const CloudRows& rows, bool ascii);

}  // namespace gnosphere
