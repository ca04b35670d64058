// SPDX-License-Identifier: Apache-2.0
// Which kinds of cloud file there are, and what they say of the grid of a sensor.
#pragma once

#include <filesystem>

namespace gnosphere {

enum class CloudFormat { pcd, ply, kitti, npy, csv };
/// By the ending. Throws Error(invalidArgument) with the endings there are.
CloudFormat cloudFormat(const std::filesystem::path& file);

/// A cloud that keeps only some beams says in a comment of PCD and PLY which grid they come from, and how many returns
/// a beam may have where that is more than one.
inline constexpr const char* kGridComment = "gnosphere columns %u channels %u";
inline constexpr const char* kGridCommentReturns = "gnosphere columns %u channels %u returns %u";

}  // namespace gnosphere
