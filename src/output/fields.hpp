// SPDX-License-Identifier: Apache-2.0
// The columns of cloud files, and the kinds of files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "gnosphere/output.hpp"

namespace gnosphere {

/// One column of a cloud file. Most fields are one column; a vector has one per component. `type` and `size` are
/// written as in PCD: F4, U4, U2, U1.
struct ColumnInfo {
  Field field;
  const char* name;
  char type;
  uint8_t size;
  uint8_t component = 0;  ///< one of the `components` that lie side by side in the scan's array
  uint8_t components = 1;
  const char* fieldName = name;  ///< the name by which the field is requested
};

/// All columns, in the order of Field.
std::span<const ColumnInfo> allColumns();
std::vector<ColumnInfo> columnsOf(const std::vector<Field>& fields);
const char* fieldName(Field field);
/// Finds a column by name, whatever the case; null if there is none.
const ColumnInfo* findColumn(std::string_view name);

/// Returns whether a scan holds the field only if SimulatorOptions::fields names it.
bool isAskedFor(Field field);

/// Names in PLY files that differ from ours, because readers of PLY expect them.
struct PlyName {
  const char* name;
  const char* inPly;
};
inline constexpr PlyName kPlyNames[] = {{"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"}};

enum class CloudFormat { pcd, ply, kitti, npy, csv };
/// Returns the format for a file ending. Throws Error(invalidArgument) with the known endings.
CloudFormat cloudFormat(const std::filesystem::path& file);

/// Comments of PCD and PLY files. A cloud that keeps only some beams states the grid they come from, and the number of
/// returns per beam if it is more than one.
inline constexpr const char* kGridComment = "gnosphere columns %u channels %u";
inline constexpr const char* kGridCommentReturns = "gnosphere columns %u channels %u returns %u";

}  // namespace gnosphere
