// SPDX-License-Identifier: Apache-2.0
// ROS 2 messages in CDR (OMG DDSI-RTPS, plain CDR, little-endian).
#pragma once

#include <cstdint>
#include <string>

#include "base/nanoseconds.hpp"
#include "drive/bytes.hpp"

namespace gnosphere::drive {

class CdrWriter {
 public:
  /// Appends a message to `bytes`.
  explicit CdrWriter(std::string& bytes) : bytes_(bytes) {
    bytes_.append("\x00\x01\x00\x00", 4);
    start_ = bytes_.size();
  }

  /// Numbers are aligned to their own size, counted from the end of the head of 4 bytes.
  template <typename T>
  CdrWriter& number(T value) {
    while ((bytes_.size() - start_) % sizeof(T) != 0) bytes_ += '\0';
    append(bytes_, value);
    return *this;
  }
  CdrWriter& text(const std::string& value) {
    number(static_cast<uint32_t>(value.size() + 1));
    bytes_.append(value).append(1, '\0');
    return *this;
  }
  /// A list of bytes, which the function appends.
  template <typename Append>
  CdrWriter& blob(const Append& appendBytes) {
    number(uint32_t{0});
    const size_t start = bytes_.size();
    appendBytes(bytes_);
    const auto count = static_cast<uint32_t>(bytes_.size() - start);
    std::memcpy(bytes_.data() + start - sizeof(count), &count, sizeof(count));
    return *this;
  }
  /// Writes a builtin_interfaces/Time of nanoseconds since 1970.
  CdrWriter& time(int64_t time) {
    const auto [seconds, nanoseconds] = splitNanoseconds(time);
    return number(static_cast<int32_t>(seconds)).number(nanoseconds);
  }
  /// Writes a std_msgs/Header; its time is in nanoseconds since 1970.
  CdrWriter& header(int64_t stamp, const std::string& frame) { return time(stamp).text(frame); }

 private:
  std::string& bytes_;
  size_t start_;  // from where positions are counted
};

}  // namespace gnosphere::drive
