// SPDX-License-Identifier: Apache-2.0
// Buffers of a device that get the results of batches in turn, and the submissions that fill them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

namespace gnosphere {

class ResultRing {
 public:
  virtual ~ResultRing() = default;
  /// Begins the commands that fill a buffer, after wait() for the commands before. A Recording whose frame in flight is
  /// the number of the buffer adds to them.
  virtual void begin(size_t buffer) = 0;
  /// Submits the commands, which fill the first `bytes` of the buffer.
  virtual void submit(size_t buffer, uint64_t bytes) = 0;
  /// Waits until the buffer is filled; returns at once if nothing was submitted since the last call.
  virtual void wait(size_t buffer) = 0;
  /// Address by which kernels access the buffer.
  virtual uint64_t address(size_t buffer) const = 0;
  /// After wait(), the results as the host sees them: all of them if device and host share their memory, otherwise as
  /// many bytes as the ring was made to copy.
  virtual const std::byte* host(size_t buffer) const = 0;
  /// Whether host() has all results of a buffer.
  virtual bool hostHasAll(size_t buffer) const = 0;
  /// Returns the bytes that all buffers and their copies take.
  virtual uint64_t bytes() const = 0;
  /// Returns a new file descriptor of the buffer's memory, and the size of that memory. Throws Error(device) if the
  /// device exports none.
  virtual std::pair<int, uint64_t> fd(size_t buffer) const = 0;
  /// Returns the buffer's address in CUDA's primary context of the same card, and the card's number there. Throws
  /// Error(device) if there is none.
  virtual std::pair<uint64_t, int> cudaAddress(size_t buffer) = 0;
};

}  // namespace gnosphere
