// SPDX-License-Identifier: Apache-2.0
// A recording of calls: a list of function names with arguments as YAML, and the arrays beside it in a binary file.
#pragma once

#include <rgl/api/core.h>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>

namespace gnosphere::rgl {

/// An array argument: its bytes go to the binary file, and the tape has their place in it.
struct Array {
  const void* data;
  size_t bytes;
};
template <class T>
Array arrayOf(const T* data, int64_t count) {
  return {data, data && count > 0 ? static_cast<size_t>(count) * sizeof(T) : 0};
}

/// An array whose elements have a size that is known after the call.
struct RowArray {
  const void* data;
  int64_t count;
  const size_t& stride;
};

/// A handle that a call gives: the tape has its value after the call.
template <class Handle>
struct Out {
  const Handle* handle;
};
template <class Handle>
Out<Handle> out(const Handle* handle) {
  return {handle};
}

class Tape {
 public:
  bool recording() const { return recording_; }
  void begin(const char* path);
  void end();

  /// Notes a call that has succeeded. If there is no memory or room to note it, end() says so.
  template <class... Arguments>
  void record(const char* name, const Arguments&... arguments) noexcept {
    try {
      std::ostringstream list;
      [[maybe_unused]] const char* separator = "";
      ((list << std::exchange(separator, ", ") << text(arguments)), ...);
      write(name, list.str());
    } catch (...) {
      whole_ = false;
    }
  }

 private:
  template <class T>
  std::string text(const T& value) {
    if constexpr (std::is_same_v<T, Array>) {
      return place(value);
    } else if constexpr (std::is_same_v<T, RowArray>) {
      return place({value.data, static_cast<size_t>(value.count) * value.stride});
    } else if constexpr (std::is_same_v<T, std::string>) {
      return quoted(value);
    } else if constexpr (std::is_same_v<T, bool>) {
      return value ? "true" : "false";
    } else if constexpr (std::is_pointer_v<T>) {
      return std::to_string(reinterpret_cast<uintptr_t>(value));
    } else if constexpr (std::is_floating_point_v<T>) {
      return real(value);
    } else if constexpr (std::is_unsigned_v<T>) {
      return std::to_string(value);
    } else {
      return std::to_string(static_cast<int64_t>(value));
    }
  }
  template <class Handle>
  std::string text(const Out<Handle>& value) {
    return text(*value.handle);
  }
  static std::string quoted(const std::string& value);
  static std::string real(double value);
  std::string place(const Array& array);
  void write(const char* name, const std::string& arguments);

  bool recording_ = false, whole_ = true;
  std::ofstream yaml_, binary_;
  uint64_t offset_ = 0;
  std::chrono::steady_clock::time_point start_;
};

Tape& tape();

}  // namespace gnosphere::rgl
