// SPDX-License-Identifier: Apache-2.0
// Words in ASCII, compared without regard to case.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace gnosphere {

/// The character in lower case; one that is not an ASCII letter stays as it is, whatever the locale.
constexpr char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

inline std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = lower(c);
  return result;
}

inline bool sameWord(std::string_view a, std::string_view b) {
  return lower(a) == lower(b);
}

/// Whether `part` occurs in `text`.
inline bool containsWord(std::string_view text, std::string_view part) {
  return lower(text).find(lower(part)) != std::string::npos;
}

}  // namespace gnosphere
