// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace gnosphere::drive {

/// Appends a number in the byte order of the machine, which is little-endian.
template <typename T>
void append(std::string& bytes, T value) {
  static_assert(std::is_arithmetic_v<T>);
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

/// Appends a text, cut or filled with zeros to a fixed number of bytes.
inline void appendFixed(std::string& bytes, std::string_view text, size_t count) {
  bytes.append(text.substr(0, count));
  bytes.append(count - std::min(count, text.size()), '\0');
}

}  // namespace gnosphere::drive
