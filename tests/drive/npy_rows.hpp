// SPDX-License-Identifier: Apache-2.0
// Points that drives of tests have written.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace gnosphere::test {

/// A row of the .npy files of smallDrive().
struct Row {
  float x, y, z, range, time;
  uint16_t category;
  uint32_t instance;
};

/// Reads a structured array without numpy: the data comes after a text whose length stands at byte 8.
inline std::vector<Row> rowsOf(const std::string& bytes) {
  uint16_t header = 0;
  std::memcpy(&header, bytes.data() + 8, 2);
  constexpr size_t kStride = 26;
  std::vector<Row> rows;
  for (size_t at = 10 + header; at + kStride <= bytes.size(); at += kStride) {
    Row row;
    std::memcpy(&row, bytes.data() + at, 20);
    std::memcpy(&row.category, bytes.data() + at + 20, 2);
    std::memcpy(&row.instance, bytes.data() + at + 22, 4);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace gnosphere::test
