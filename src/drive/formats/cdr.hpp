// SPDX-License-Identifier: Apache-2.0
// ROS 2 messages in CDR (OMG DDSI-RTPS, plain CDR, little-endian).
#pragma once

#include <cstdint>
#include <string>

#include "drive/bytes.hpp"

namespace gnosphere::drive {

class CdrWriter {
 public:
  CdrWriter() : bytes_("\x00\x01\x00\x00", 4) {}

  /// Numbers are aligned to their own size, counted from the end of the head of 4 bytes.
  template <typename T>
  CdrWriter& number(T value) {
    while ((bytes_.size() - kHead) % sizeof(T) != 0) bytes_ += '\0';
    append(bytes_, value);
    return *this;
  }
  CdrWriter& text(const std::string& value) {
    number(static_cast<uint32_t>(value.size() + 1));
    bytes_.append(value).append(1, '\0');
    return *this;
  }
  CdrWriter& blob(const std::string& value) {
    number(static_cast<uint32_t>(value.size()));
    constexpr size_t kRest = 64;  // what may follow fits in without a copy of the blob
    bytes_.reserve(bytes_.size() + value.size() + kRest);
    bytes_ += value;
    return *this;
  }
  /// std_msgs/Header; nanoseconds since 1970.
  CdrWriter& header(int64_t time, const std::string& frame) {
    constexpr int64_t kSecond = 1'000'000'000;
    number(static_cast<int32_t>(time / kSecond));
    number(static_cast<uint32_t>(time % kSecond));
    return text(frame);
  }
  std::string take() { return std::move(bytes_); }

 private:
  static constexpr size_t kHead = 4;
  std::string bytes_;
};

}  // namespace gnosphere::drive
