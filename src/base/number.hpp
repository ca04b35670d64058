// SPDX-License-Identifier: Apache-2.0
// Parses words and numbers of text formats.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <string_view>
#include <system_error>

namespace gnosphere {

/// Removes the next word from `text` and returns it; empty at the end.
inline std::string_view nextWord(std::string_view& text) {
  constexpr std::string_view kBlank = " \t\r\n\v\f";
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  const std::string_view word = text.substr(0, std::min(text.find_first_of(kBlank), text.size()));
  text.remove_prefix(word.size());
  return word;
}

/// Whether the number of a word that no double can hold is too small, and not too large.
inline bool isTooSmall(std::string_view word) {
  const size_t mark = std::min(word.find_first_of("eE"), word.size());
  const std::string_view digits = word.substr(0, mark);
  std::string_view power = word.substr(mark);
  if (!power.empty()) power.remove_prefix(1);
  if (power.starts_with('+')) power.remove_prefix(1);
  int64_t exponent = 0;
  const auto result = std::from_chars(power.data(), power.data() + power.size(), exponent);
  if (result.ec == std::errc::result_out_of_range) return power.starts_with('-');
  constexpr int64_t kFar = int64_t{1} << 62;  // farther than a word has digits
  exponent = std::clamp(exponent, -kFar, kFar);
  // How far the point is behind the first digit that is not 0.
  const auto point = static_cast<int64_t>(std::min(digits.find('.'), digits.size()));
  const auto first = static_cast<int64_t>(std::min(digits.find_first_of("123456789"), digits.size()));
  return point - first + exponent < 0;
}

/// Parses a word as the nearest double. Reads nan and inf; values too large become infinity, values too small 0.
/// Returns false if the word is not a number.
inline bool parseNumber(std::string_view word, double& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const std::from_chars_result result = std::from_chars(word.data(), end, value);
  if (word.empty() || result.ptr != end || result.ec == std::errc::invalid_argument) return false;
  if (result.ec == std::errc::result_out_of_range) {
    const bool isSmall = isTooSmall(word);
    value = isSmall ? 0 : std::numeric_limits<double>::infinity();
    if (!isSmall && word.starts_with('-')) value = -value;
  }
  return true;
}

}  // namespace gnosphere
