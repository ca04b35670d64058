// SPDX-License-Identifier: Apache-2.0
// The kinds of cloud files, and the names and comments in them.
#pragma once

#include <filesystem>

namespace gnosphere {

enum class CloudFormat { pcd, ply, kitti, npy, csv };
/// Returns the format for a file ending. Throws Error(invalidArgument) with the known endings.
CloudFormat cloudFormat(const std::filesystem::path& file);

/// Names in PLY files that differ from ours, because readers of PLY expect them.
struct PlyName {
  const char* name;
  const char* inPly;
};
inline constexpr PlyName kPlyNames[] = {{"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"}};

/// Comments of PCD and PLY files. A cloud that keeps only some beams states the grid they come from, and the number of
/// returns per beam if it is more than one.
inline constexpr const char* kGridComment = "gnosphere columns %u channels %u";
inline constexpr const char* kGridCommentReturns = "gnosphere columns %u channels %u returns %u";

}  // namespace gnosphere
