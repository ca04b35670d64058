// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>
#include <vector>

namespace gnosphere {

/// Parses finite numbers separated by `separator` (spaces around it are allowed); empty if the text is anything else.
inline std::vector<double> parseNumbers(std::string_view text, char separator) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* end = at + text.size();
  const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (at <= end) {
    while (at < end && (isBlank(*at) || *at == '+')) ++at;
    double value = 0;
    const auto result = std::from_chars(at, end, value);
    if (result.ec != std::errc() || !std::isfinite(value)) return {};
    numbers.push_back(value);
    at = result.ptr;
    while (at < end && isBlank(*at)) ++at;
    if (at == end) break;
    const bool separated = separator == ' ' ? at > result.ptr : *at == separator;
    if (!separated) return {};
    if (separator != ' ') ++at;
  }
  return numbers;
}

}  // namespace gnosphere
