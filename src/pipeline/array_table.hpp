// SPDX-License-Identifier: Apache-2.0
// The memory of some of the arrays of a scan.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <utility>

#include "pipeline/machine.hpp"

namespace gnosphere {

class ArrayTable {
 public:
  /// The memory of an array; null if this table has none.
  std::unique_ptr<DeviceMemory>& operator[](gpu::Array array) { return memory_[static_cast<size_t>(array)]; }
  const std::unique_ptr<DeviceMemory>& operator[](gpu::Array array) const {
    return memory_[static_cast<size_t>(array)];
  }
  uint64_t bytes() const {
    uint64_t sum = 0;
    for (const auto& memory : memory_) sum += memory ? memory->bytes() : 0;
    return sum;
  }
  void bind(BoundArrays& arrays) const {
    for (size_t i = 0; i < memory_.size(); ++i)
      if (memory_[i]) arrays[i] = memory_[i].get();
  }
  bool holds(gpu::Array array, uint64_t bytes) const {
    const auto& memory = (*this)[array];
    return memory && memory->bytes() >= bytes;
  }

  /// Allocates an array anew; its old memory is freed first.
  void allocate(Machine& machine, gpu::Array array, uint64_t bytes, MemoryKind kind) {
    (*this)[array].reset();
    (*this)[array] = machine.allocate(gpu::nameOf(array), bytes, kind);
  }
  /// Replaces an array by one of the kind `device` with this content. If that fails, the old one stays.
  template <typename Entries>
  void upload(Machine& machine, gpu::Array array, const Entries& content) {
    const std::span all(content);
    auto memory = machine.allocate(gpu::nameOf(array), all.size_bytes(), MemoryKind::device);
    memory->write(0, std::as_bytes(all));
    (*this)[array] = std::move(memory);
  }
  /// Makes room for `bytes` bytes. Existing memory that is too small is replaced with some reserve, so that a growing
  /// scene does not allocate with every scan. The old content is lost.
  void makeRoom(Machine& machine, gpu::Array array, uint64_t bytes, MemoryKind kind) {
    if (holds(array, bytes)) return;
    const uint64_t limit = std::max(bytes, machine.traits().info.maxBufferBytes);
    allocate(machine, array, (*this)[array] ? std::min(bytes + bytes / 4, limit) : bytes, kind);
  }
  /// Makes room for entries that the host writes or reads, and returns their place.
  template <typename T>
  T* entries(Machine& machine, gpu::Array array, uint64_t count, MemoryKind kind = MemoryKind::upload) {
    makeRoom(machine, array, count * sizeof(T), kind);
    return static_cast<T*>((*this)[array]->host());
  }
  /// Makes room for `bytes` bytes of the kind `upload`, and writes the content to their start.
  void load(Machine& machine, gpu::Array array, uint64_t bytes, std::span<const std::byte> content) {
    std::ranges::copy(content, entries<std::byte>(machine, array, bytes));
    (*this)[array]->flush();
  }
  template <typename Entries>
  void load(Machine& machine, gpu::Array array, const Entries& content) {
    const std::span all(content);
    load(machine, array, all.size_bytes(), std::as_bytes(all));
  }

 private:
  std::array<std::unique_ptr<DeviceMemory>, gpu::kArrayCount> memory_;
};

}  // namespace gnosphere
