// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/text.hpp"
#include "base/utf8.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

/// The path that a text in UTF-8 names. The constructor of std::filesystem::path takes a text in the encoding of the
/// system, which is another one on Windows. There, a text that is not UTF-8 names no file and is an
/// Error(invalidArgument); elsewhere a name may have any bytes.
inline std::filesystem::path pathOf(std::string_view text) {
  try {
    return std::u8string(text.begin(), text.end());
  } catch (const std::filesystem::filesystem_error&) {
    throw Error(ErrorCode::invalidArgument,
                "the name of a file '" + toUtf8(text) + "' is not in UTF-8, in which names are given");
  }
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
