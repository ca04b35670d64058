// SPDX-License-Identifier: Apache-2.0
#include "drive/place_in.hpp"

#include <algorithm>
#include <system_error>

#include "gnosphere/error.hpp"

namespace gnosphere::drive {
namespace {

namespace fs = std::filesystem;

/// Whether an existing place lies in a folder when all links are followed.
bool isIn(const fs::path& folder, const fs::path& place) {
  std::error_code absent, dangling;
  const fs::path outer = fs::canonical(folder.empty() ? "." : folder, absent), inner = fs::canonical(place, dangling);
  return !absent && !dangling &&
         std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

void checkLinks(const fs::path& folder, const fs::path& path) {
  fs::path place = folder;
  bool isBehindLink = false;
  for (const fs::path& part : path) {
    place /= part;
    std::error_code absent;
    const bool isLink = fs::is_symlink(place, absent);
    if ((isLink || (isBehindLink && part == "..")) && !isIn(folder, place))
      throw Error(ErrorCode::file, place.string() + ": is a link that leads out of the folder of the drive, " +
                                       "so nothing behind it is touched; remove the link, or choose another folder");
    isBehindLink |= isLink;
  }
}

}  // namespace

fs::path placeIn(const fs::path& folder, const fs::path& path) {
  checkLinks(folder, path.parent_path());
  return folder / path;
}

fs::path fileIn(const fs::path& folder, const fs::path& path) {
  checkLinks(folder, path);
  return folder / path;
}

}  // namespace gnosphere::drive
