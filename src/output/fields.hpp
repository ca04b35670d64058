// SPDX-License-Identifier: Apache-2.0
// What a cloud file may hold, and which kinds of file there are.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "gnosphere/output.hpp"

namespace gnosphere {

/// `type` and `size` in PCD's letters: F4, U4, U2, U1.
struct FieldInfo {
  Field field;
  const char* name;
  char type;
  uint8_t size;
};

const std::array<FieldInfo, 10>& allFields();
const FieldInfo& fieldInfo(Field field);
/// By name, whatever the case; null for a name that is not one of ours.
const FieldInfo* findField(std::string_view name);

enum class CloudFormat { pcd, ply, kitti, npy, csv };
/// By the ending. Throws Error(invalidArgument) with the endings there are.
CloudFormat cloudFormat(const std::filesystem::path& file);

/// A cloud that keeps only some beams says in a comment of PCD and PLY which grid they come from.
inline constexpr const char* kGridComment = "gnosphere columns %u channels %u";

}  // namespace gnosphere
