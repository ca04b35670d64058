// SPDX-License-Identifier: Apache-2.0
// Files that were read, as reports and data sets name them.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "base/file.hpp"
#include "base/sha256.hpp"

namespace gnosphere {

/// Returns the path of a file as the user states it, and the number and the SHA-256 of its bytes. A pipe, which cannot
/// be read again, has its path alone.
inline nlohmann::ordered_json inputJson(const std::string& path, const std::filesystem::path& place) {
  nlohmann::ordered_json input = {{"path", path}};
  if (std::error_code absent;
      std::filesystem::exists(place, absent) && !std::filesystem::is_regular_file(place, absent))
    return input;
  const std::string bytes = readWholeFile(place);
  input["bytes"] = bytes.size();
  input["sha256"] = sha256Text(bytes);
  return input;
}

}  // namespace gnosphere
