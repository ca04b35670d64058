// SPDX-License-Identifier: Apache-2.0
#include "vulkan/memory.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

namespace gnosphere::vulkan {

VulkanMemory::VulkanMemory(const Device& device, const char* name, uint64_t bytes, MemoryKind kind) {
  const bool copied = kind == MemoryKind::readback && !device.unifiedMemory();
  buffer_ = Buffer(device, name, bytes, copied ? MemoryKind::device : kind);
  if (copied) copy_ = Buffer(device, name, bytes, kind);
}

RecordedMemory::RecordedMemory(const Device& device, Recordings& recordings, const char* name, uint64_t bytes,
                               MemoryKind kind)
    : VulkanMemory(device, name, bytes, kind), recordings_(recordings) {
  recordings_.enter();
}

RecordedMemory::~RecordedMemory() {
  recordings_.forget(*this);
  for (Buffer* buffer : {&buffer_, &copy_})
    if (buffer->handle()) recordings_.retire(std::move(*buffer));
  recordings_.leave();
}

void RecordedMemory::prepareWrite(uint64_t place, uint64_t bytes) {
  if (written_.size() < place + bytes) written_.resize(place + bytes);
  recordings_.prepareAdd(*this);
  if (spare_) return;
  Runs made;
  made.emplace(0, 0);
  spare_ = made.extract(made.begin());
}

void RecordedMemory::write(uint64_t place, std::span<const std::byte> data) {
  if (data.empty()) return;
  prepareWrite(place, data.size());
  std::copy(data.begin(), data.end(), written_.begin() + static_cast<ptrdiff_t>(place));
  spare_.key() = place;
  spare_.mapped() = place + data.size();
  recordings_.add(*this, std::move(spare_));
}

void RecordedMemory::read(uint64_t place, std::span<std::byte> data) const {
  const uint64_t known = place < written_.size() ? std::min<uint64_t>(data.size(), written_.size() - place) : 0;
  std::copy_n(written_.begin() + static_cast<ptrdiff_t>(known > 0 ? place : 0), known, data.begin());
  std::fill(data.begin() + static_cast<ptrdiff_t>(known), data.end(), std::byte{0});
}

void Recordings::enter() {
  makeRoom(retired_, retired_.size() + 2 * (memories_ + 1));
  ++memories_;
}

void Recordings::retire(Buffer buffer) noexcept {
  if (recording_ == 0) return;
  retired_.push_back({recording_, std::move(buffer)});  // enter() has made room
}

// Runs of one memory that touch are joined: the copies of a recording are not ordered, so they must not overlap.
void Recordings::join(Runs& runs, Runs::node_type node) noexcept {
  uint64_t place = node.key(), end = node.mapped();
  auto next = runs.upper_bound(place);
  if (next != runs.begin() && std::prev(next)->second >= place) --next;
  while (next != runs.end() && next->first <= end) {
    place = std::min(place, next->first);
    end = std::max(end, next->second);
    next = runs.erase(next);
  }
  node.key() = place;
  node.mapped() = end;
  runs.insert(std::move(node));
}

void Recordings::add(const RecordedMemory& memory, Runs::node_type run) noexcept {
  join(writes_.find(&memory)->second, std::move(run));
}

void Recordings::forget(const RecordedMemory& memory) {
  writes_.erase(&memory);
  for (Frame& frame : frames_) frame.taken.erase(&memory);
}

// Joins what the recording has taken with what has been written since, without allocating anything.
void Recordings::abandon(size_t number) noexcept {
  if (number >= frames_.size()) return;
  Frame& frame = frames_[number];
  frame.recording = 0;  // when the frame comes again, the recordings before this one need not have completed
  while (!frame.taken.empty()) {
    auto node = frame.taken.extract(frame.taken.begin());
    const auto since = writes_.find(node.key());
    if (since == writes_.end()) {
      writes_.insert(std::move(node));
      continue;
    }
    Runs& runs = node.mapped();
    while (!runs.empty()) join(since->second, runs.extract(runs.begin()));
  }
}

// A run of a recording may begin at any byte of a chunk: copies have no alignment.
void Recordings::Frame::reserve(const Device& device, uint64_t bytes, uint64_t most) {
  if (bytes > 0 && bytes <= most) {
    staging.resize(std::min<size_t>(staging.size(), 1));
    if (staging.empty() || staging[0].bytes() < bytes) {
      staging.clear();
      staging.push_back(Buffer::staging(device, std::min(bytes + bytes / 4, most), false));
    }
    return;
  }
  uint64_t room = 0;
  for (const Buffer& buffer : staging) room += buffer.bytes();
  for (; room < bytes; room += staging.back().bytes())
    staging.push_back(Buffer::staging(device, std::min(most, bytes - room), false));
}

void Recordings::begin(CommandBuffer& commands, size_t number) {
  while (frames_.size() <= number) frames_.emplace_back();
  Frame& frame = frames_[number];
  // The recordings run in the order of their numbers, so with this one all before it have completed, too.
  std::erase_if(retired_, [&](const Retired& retired) { return retired.recording <= frame.recording; });
  frame.taken.clear();
  uint64_t bytes = 0;
  for (const auto& [memory, runs] : writes_)
    for (const auto& [place, end] : runs) bytes += end - place;
  frame.reserve(device_, bytes, mostBytes_);
  frame.recording = ++recording_;
  commands.fullBarrier();
  if (bytes == 0) return;
  size_t chunk = 0;
  uint64_t at = 0;
  for (const auto& [memory, runs] : writes_)
    for (const auto& [first, end] : runs)
      for (uint64_t place = first; place < end;) {
        if (at == frame.staging[chunk].bytes()) {
          ++chunk;
          at = 0;
        }
        const Buffer& staging = frame.staging[chunk];
        const uint64_t size = std::min(end - place, staging.bytes() - at);
        std::memcpy(static_cast<std::byte*>(staging.mapped()) + at, memory->written() + place, size);
        commands.copy(staging, memory->buffer(), {at, place, size});
        place += size;
        at += size;
      }
  frame.taken = std::exchange(writes_, {});
  for (const Buffer& staging : frame.staging) staging.flush();
  commands.barrier();
}

}  // namespace gnosphere::vulkan
