// SPDX-License-Identifier: Apache-2.0
// ASCII text without regard to case, and numbers as text.
#pragma once

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

namespace gnosphere {

/// Returns the character in lower case. Only ASCII letters change, whatever the locale.
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

/// Returns whether `part` occurs in `text`.
inline bool containsWord(std::string_view text, std::string_view part) {
  return lower(text).find(lower(part)) != std::string::npos;
}

/// Returns the shortest text that reads back to the same bits, with a point whatever the locale.
inline std::string numberText(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

}  // namespace gnosphere
