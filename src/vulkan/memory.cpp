// SPDX-License-Identifier: Apache-2.0
#include "vulkan/memory.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <utility>

namespace gnosphere::vulkan {
namespace {

// A staging buffer up to this size is kept for the next recording; a larger one served to load a scene.
constexpr uint64_t kKeptStagingBytes = 16 << 20;

}  // namespace

VulkanMemory::VulkanMemory(const Device& device, const char* name, uint64_t bytes, MemoryKind kind) {
  const bool copied = kind == MemoryKind::readback && !device.unifiedMemory();
  buffer_ = Buffer(device, name, bytes, copied ? MemoryKind::device : kind);
  if (copied) copy_ = Buffer(device, name, bytes, kind);
}

RecordedMemory::~RecordedMemory() {
  recordings_.forget(*this);
  for (Buffer* buffer : {&buffer_, &copy_})
    if (buffer->handle()) recordings_.retire(std::move(*buffer));
}

void RecordedMemory::write(uint64_t place, std::span<const std::byte> data) {
  if (data.empty()) return;
  if (written_.size() < place + data.size()) written_.resize(place + data.size());
  std::copy(data.begin(), data.end(), written_.begin() + static_cast<ptrdiff_t>(place));
  recordings_.add(*this, place, data.size());
}

void RecordedMemory::read(uint64_t place, std::span<std::byte> data) const {
  const uint64_t known = place < written_.size() ? std::min<uint64_t>(data.size(), written_.size() - place) : 0;
  std::copy_n(written_.begin() + static_cast<ptrdiff_t>(known > 0 ? place : 0), known, data.begin());
  std::fill(data.begin() + static_cast<ptrdiff_t>(known), data.end(), std::byte{0});
}

void Recordings::retire(Buffer buffer) {
  if (recording_ > 0) retired_.push_back({recording_, std::move(buffer)});
}

bool Recordings::join(Write& to, const Write& write) {
  if (to.memory != write.memory || write.place > to.place + to.bytes || to.place > write.place + write.bytes)
    return false;
  const uint64_t end = std::max(to.place + to.bytes, write.place + write.bytes);
  to.place = std::min(to.place, write.place);
  to.bytes = end - to.place;
  return true;
}

// Most writes continue the one before them.
void Recordings::add(const RecordedMemory& memory, uint64_t place, uint64_t bytes) {
  const Write write = {&memory, place, bytes};
  if (writes_.empty() || !join(writes_.back(), write)) writes_.push_back(write);
}

// The copies of one recording have no barriers between them, so no two of them may have a byte in common.
std::vector<Recordings::Write> Recordings::takeWrites() {
  std::vector<Write> writes = std::exchange(writes_, {});
  std::sort(writes.begin(), writes.end(), [](const Write& a, const Write& b) {
    return a.memory != b.memory ? std::less<>()(a.memory, b.memory) : a.place < b.place;
  });
  size_t count = 0;
  for (const Write& write : writes)
    if (count == 0 || !join(writes[count - 1], write)) writes[count++] = write;
  writes.resize(count);
  return writes;
}

void Recordings::forget(const RecordedMemory& memory) {
  std::erase_if(writes_, [&](const Write& write) { return write.memory == &memory; });
}

void Recordings::begin(CommandBuffer& commands, size_t number) {
  while (frames_.size() <= number) frames_.emplace_back();
  Frame& frame = frames_[number];
  // The recordings run in the order of their numbers, so with this one all before it have completed, too.
  std::erase_if(retired_, [&](const Retired& retired) { return retired.recording <= frame.recording; });
  const std::vector<Write> writes = takeWrites();
  uint64_t bytes = 0;
  for (const Write& write : writes) bytes += write.bytes;
  if (frame.staging.bytes() < bytes || frame.staging.bytes() > std::max(bytes, kKeptStagingBytes))
    frame.staging = bytes > 0 ? Buffer(device_, "staging", bytes + bytes / 4, MemoryKind::upload) : Buffer();
  frame.recording = ++recording_;
  commands.fullBarrier();
  uint64_t at = 0;
  for (const Write& write : writes) {
    std::memcpy(static_cast<std::byte*>(frame.staging.mapped()) + at, write.memory->written() + write.place,
                write.bytes);
    commands.copy(frame.staging, write.memory->buffer(), {at, write.place, write.bytes});
    at += write.bytes;
  }
  if (at == 0) return;
  frame.staging.flush();
  commands.barrier();
}

}  // namespace gnosphere::vulkan
