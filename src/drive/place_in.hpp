// SPDX-License-Identifier: Apache-2.0
// Data sets are exchanged, and may have links that lead out of their folder. A drive writes, reads and removes nothing
// behind such a link, so it asks here for the places of its files.
#pragma once

#include <filesystem>

namespace gnosphere::drive {

/// Returns the place of a file that is replaced or removed, which may itself be any link. Throws Error(file) if a link
/// above it leads out of the folder. The folder may be reached through a link.
std::filesystem::path placeIn(const std::filesystem::path& folder, const std::filesystem::path& path);

/// Returns the place of a file that is opened. Throws Error(file), too, if it is itself a link that leads out.
std::filesystem::path fileIn(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace gnosphere::drive
