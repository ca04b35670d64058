// SPDX-License-Identifier: Apache-2.0
// What a cloud file may hold, and which kinds of file there are.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "gnosphere/output.hpp"

namespace gnosphere {

/// One column of a cloud file. Most fields are one column, a vector is one per component. `type` and `size` in PCD's
/// letters: F4, U4, U2, U1.
struct ColumnInfo {
  Field field;
  const char* name;
  char type;
  uint8_t size;
  uint8_t component = 0;  ///< of `components` that lie side by side in the scan's array
  uint8_t components = 1;
  const char* fieldName = name;  ///< to ask for the field by
};

/// Every column there is, in the order of Field.
std::span<const ColumnInfo> allColumns();
std::vector<ColumnInfo> columnsOf(const std::vector<Field>& fields);
const char* fieldName(Field field);
/// By name, whatever the case; null for a name that is not one of ours.
const ColumnInfo* findColumn(std::string_view name);

/// Whether a scan holds the field only where SimulatorOptions::fields asks for it.
bool isAskedFor(Field field);

enum class CloudFormat { pcd, ply, kitti, npy, csv };
/// By the ending. Throws Error(invalidArgument) with the endings there are.
CloudFormat cloudFormat(const std::filesystem::path& file);

/// A cloud that keeps only some beams says in a comment of PCD and PLY which grid they come from, and how many returns
/// a beam may have where that is more than one.
inline constexpr const char* kGridComment = "gnosphere columns %u channels %u";
inline constexpr const char* kGridCommentReturns = "gnosphere columns %u channels %u returns %u";

}  // namespace gnosphere
