// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "gnosphere/error.hpp"

namespace gnosphere {

/// Number of bytes of the character at the start of a text that is not empty, or 0 if these bytes are no UTF-8.
inline size_t utf8Length(std::string_view text) {
  const auto at = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned lead = at(0);
  if (lead < 0x80) return 1;
  const size_t length = lead >= 0xc2 && lead < 0xe0   ? 2
                        : lead >= 0xe0 && lead < 0xf0 ? 3
                        : lead >= 0xf0 && lead < 0xf5 ? 4
                                                      : 0;
  for (size_t i = 1; i < length; ++i)
    if ((at(i) & 0xc0) != 0x80) return 0;
  const bool overlong = (lead == 0xe0 && at(1) < 0xa0) || (lead == 0xf0 && at(1) < 0x90);
  const bool surrogate = lead == 0xed && at(1) >= 0xa0, beyond = lead == 0xf4 && at(1) >= 0x90;
  return overlong || surrogate || beyond ? 0 : length;
}

/// Returns a text in UTF-8. A byte that is none is taken for a character of Latin-1, as older files have it.
inline std::string toUtf8(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const size_t length = utf8Length(text);
    if (length > 0) {
      result += text.substr(0, length);
    } else {
      const auto byte = static_cast<unsigned char>(text[0]);
      result += static_cast<char>(0xc0 | byte >> 6);
      result += static_cast<char>(0x80 | (byte & 0x3f));
    }
    text.remove_prefix(length > 0 ? length : 1);
  }
  return result;
}

/// Returns the text of a file, without a mark of UTF-8. Every reader of text calls this. Throws Error(format) if the
/// file begins with a mark of UTF-16, as files do that `>` writes in Windows PowerShell.
inline std::string_view textOfFile(std::string_view bytes, const std::string& name) {
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff"))
    throw Error(ErrorCode::format, name + ": is text in UTF-16; save it as UTF-8");
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);
  return bytes;
}

}  // namespace gnosphere
