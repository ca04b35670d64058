// SPDX-License-Identifier: Apache-2.0
// Helpers for text: words without regard to case, blanks, lines, and numbers as text.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
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

/// Returns a text without the blanks around it.
inline std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r\n") {
  const size_t begin = text.find_first_not_of(blanks);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

/// Returns the number of the line that has the byte at `offset`, from 1 on.
inline size_t lineNumber(std::string_view text, std::ptrdiff_t offset) {
  const auto before = static_cast<size_t>(std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text)));
  return 1 + static_cast<size_t>(std::ranges::count(text.substr(0, before), '\n'));
}

/// Returns a text in which every byte that is no printable ASCII is a question mark.
inline std::string plainAscii(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 32 || c > 126; }, '?');
  return text;
}

/// Returns bytes as hexadecimal digits, two for each.
inline std::string hexText(std::string_view bytes) {
  std::string digits;
  for (const char byte : bytes)
    for (const int shift : {4, 0}) digits += "0123456789abcdef"[static_cast<unsigned char>(byte) >> shift & 15];
  return digits;
}

/// Returns the shortest text that reads back to the same bits, with a point whatever the locale.
inline std::string numberText(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

/// Returns a number of bytes as "1.5 MiB", or as "9.5 KiB" or "95 bytes" where it would be 0.0 of the larger unit.
inline std::string mebibytes(uint64_t bytes) {
  if (bytes < 52) return std::to_string(bytes) + " bytes";
  const bool small = bytes < 52 * 1024;
  char buffer[32];
  const double value = static_cast<double>(bytes) / (small ? 1 << 10 : 1 << 20);
  char* const end = std::to_chars(buffer, buffer + sizeof(buffer), value, std::chars_format::fixed, 1).ptr;
  return std::string(buffer, end) + (small ? " KiB" : " MiB");
}

}  // namespace gnosphere
