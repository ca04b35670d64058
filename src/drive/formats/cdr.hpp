// SPDX-License-Identifier: Apache-2.0
// ROS 2 messages in CDR (OMG DDSI-RTPS, plain CDR, little-endian).
#pragma once

#include <cstdint>
#include <string>

#include "base/nanoseconds.hpp"
#include "drive/bytes.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::drive {

/// Returns the size of a list as messages state it, in 32 bits. Throws Error(invalidArgument) for a longer list.
inline uint32_t cdrSize(uint64_t size) {
  if (size > UINT32_MAX)
    throw Error(ErrorCode::invalidArgument, "a list of " + std::to_string(size) +
                                                " bytes does not fit into a message of ROS 2; write fewer fields, or "
                                                "scan fewer beams");
  return static_cast<uint32_t>(size);
}

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
    const uint32_t count = cdrSize(bytes_.size() - start);
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
