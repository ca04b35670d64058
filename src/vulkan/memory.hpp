// SPDX-License-Identifier: Apache-2.0
// The memory of arrays: of scans that the host waits for, when the device is idle whenever the host writes to memory of
// the kind `device`, and of recorded scans, when earlier frames may still be running.
#pragma once

#include <algorithm>
#include <deque>
#include <map>
#include <vector>

#include "base/room.hpp"
#include "vulkan/command_buffer.hpp"
#include "vulkan/transfer.hpp"

namespace gnosphere::vulkan {

class VulkanMemory : public DeviceMemory {
 public:
  VulkanMemory(const Device& device, const char* name, uint64_t bytes, MemoryKind kind);

  uint64_t bytes() const override { return buffer_.bytes(); }
  uint64_t address() const override { return buffer_.address(); }
  void* host() override { return onHost().mapped(); }
  void flush() override { buffer_.flush(); }
  void invalidate() override { onHost().invalidate(); }

  const Buffer& buffer() const { return buffer_; }
  /// The buffer to which a scan copies its results for the host; without a handle if the host reads the buffer itself.
  const Buffer& copy() const { return copy_; }

 protected:
  Buffer buffer_, copy_;

 private:
  const Buffer& onHost() const { return copy_.handle() ? copy_ : buffer_; }
};

/// Memory on a device that the library has created; a Transfer carries its data.
class OwnMemory final : public VulkanMemory {
 public:
  OwnMemory(const Device& device, Transfer& transfer, const char* name, uint64_t bytes, MemoryKind kind)
      : VulkanMemory(device, name, bytes, kind), transfer_(transfer) {}

  void prepareWrite(uint64_t, uint64_t) override { transfer_.prepareWrite(buffer_); }
  void write(uint64_t place, std::span<const std::byte> data) override { transfer_.write(buffer_, place, data); }
  void read(uint64_t place, std::span<std::byte> data) const override { transfer_.read(buffer_, place, data); }
  void copyFrom(const DeviceMemory& other, uint64_t bytes) override {
    transfer_.copy(static_cast<const OwnMemory&>(other).buffer_, buffer_, bytes);
  }

 private:
  Transfer& transfer_;
};

class Recordings;
using Runs = std::map<uint64_t, uint64_t>;  ///< of bytes, from their place to their end

/// Memory of recorded scans, on the caller's device or on our own. The host keeps a copy of what it has written to
/// memory of the kind `device`; the next recording copies it to the device.
class RecordedMemory final : public VulkanMemory {
 public:
  RecordedMemory(const Device& device, Recordings& recordings, const char* name, uint64_t bytes, MemoryKind kind);
  ~RecordedMemory() override;

  void prepareWrite(uint64_t place, uint64_t bytes) override;
  void write(uint64_t place, std::span<const std::byte> data) override;
  void read(uint64_t place, std::span<std::byte> data) const override;
  const std::byte* written() const { return written_.data(); }

 private:
  Recordings& recordings_;
  std::vector<std::byte> written_;
  Runs::node_type spare_;  // for the next write()
};

/// Work that recordings must do for the memory of their scans: copy what the host has written, and destroy
/// buffers when no frame uses them any more.
class Recordings {
 public:
  /// No buffer that carries the host's data to the device has more than `mostBytes`.
  Recordings(const Device& device, uint64_t mostBytes)
      : device_(device), mostBytes_(std::min(mostBytes, kMostStagingBytes)) {}

  /// Begins the recording of a frame in flight whose commands have completed.
  void begin(CommandBuffer& commands, size_t frame);
  /// The commands of the frame's last recording will never run: the next recording copies again what it would have.
  void abandon(size_t frame) noexcept;

  /// Counts the memories that live, and makes room, so that retiring their buffers cannot throw.
  void enter();
  void leave() noexcept { --memories_; }
  /// Destroys the buffer as soon as the recordings so far have completed.
  void retire(Buffer buffer) noexcept;
  /// Makes the entry of a memory, so that add() cannot throw.
  void prepareAdd(const RecordedMemory& memory) { writes_.try_emplace(&memory); }
  /// Notes that bytes of the memory have been written: those from the key of the run to its value.
  void add(const RecordedMemory& memory, Runs::node_type run) noexcept;
  /// Forgets all writes to the memory.
  void forget(const RecordedMemory& memory);

 private:
  struct Retired {
    uint64_t recording;  // the last one that may use the buffer
    Buffer buffer;
  };
  using Writes = std::map<const RecordedMemory*, Runs>;
  struct Frame {
    uint64_t recording = 0;  // its last one; 0: none, or one that was abandoned
    std::vector<Buffer> staging;
    Writes taken;  // what this recording copies
    /// Makes room for so many bytes in all staging buffers together, of which none has more than `most`.
    void reserve(const Device& device, uint64_t bytes, uint64_t most);
  };

  static void join(Runs& runs, Runs::node_type node) noexcept;

  const Device& device_;
  uint64_t mostBytes_;      // of a staging buffer
  uint64_t recording_ = 0;  // number of the last recording
  std::deque<Frame> frames_;
  Writes writes_;  // what the next recording copies
  std::vector<Retired> retired_;
  size_t memories_ = 0;  // that live: each may retire two buffers
};

}  // namespace gnosphere::vulkan
