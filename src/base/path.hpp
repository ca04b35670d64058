// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace gnosphere {

/// The path that a text in UTF-8 names. The constructor of std::filesystem::path takes a text in the encoding of the
/// system, which is another one on Windows.
inline std::filesystem::path pathOf(std::string_view text) {
  return std::u8string(text.begin(), text.end());
}

}  // namespace gnosphere
