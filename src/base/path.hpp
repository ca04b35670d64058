// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/text.hpp"

namespace gnosphere {

/// The path that a text in UTF-8 names. The constructor of std::filesystem::path takes a text in the encoding of the
/// system, which is another one on Windows.
inline std::filesystem::path pathOf(std::string_view text) {
  return std::u8string(text.begin(), text.end());
}

/// Whether Windows takes a file or folder of this name for a device. Capital letters, blanks and an ending make no
/// difference there.
inline bool namesDevice(std::string_view name) {
  const std::string word = lower(trimmed(name.substr(0, name.find('.')), " "));
  const bool isNumbered = word.size() == 4 && word[3] >= '1' && word[3] <= '9';
  return word == "con" || word == "prn" || word == "aux" || word == "nul" ||
         (isNumbered && (word.starts_with("com") || word.starts_with("lpt")));
}

}  // namespace gnosphere
