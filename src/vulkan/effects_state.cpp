// SPDX-License-Identifier: Apache-2.0
#include "vulkan/effects_state.hpp"

#include <algorithm>

namespace gnosphere::vulkan {

EffectsState::EffectsState(const Device& device, EffectsArrays arrays, bool copied)
    : device_(device), arrays_(std::move(arrays)) {
  make(arrays_.lasting());
  if (copied) make(arrays_.outputs());
}

void EffectsState::make(const std::vector<EffectsArray>& arrays) {
  Uploader uploader(device_);
  for (const EffectsArray& array : arrays) {
    Buffer& buffer = buffers_[array.binding];
    buffer = Buffer(device_, array.name, array.bytes, Memory::device);
    uploader.write<std::byte>(array.content, buffer, 0);
  }
}

void EffectsState::growProjected(uint64_t count) {
  make(arrays_.projected(count));
}

void EffectsState::prepare(EffectsBuffers& frame, const Shot& shot, const ShotMotion* motion) const {
  for (const EffectsArray& array : arrays_.ofShot(shot, motion)) {
    Buffer& buffer = frame[array.binding];
    if (!buffer.handle() || buffer.bytes() < array.bytes)
      buffer = Buffer(device_, array.name, array.bytes, Memory::upload);
    std::copy(array.content.begin(), array.content.end(), static_cast<std::byte*>(buffer.mapped()));
    buffer.flush();
  }
}

void EffectsState::bind(const EffectsBuffers& frame, Bindings& bindings) const {
  for (const EffectsBuffers* buffers : {&buffers_, &frame})
    for (size_t i = 0; i < bindings.size(); ++i)
      if ((*buffers)[i].handle()) bindings[i] = &(*buffers)[i];
}

uint64_t EffectsState::bytes() const {
  uint64_t sum = 0;
  for (const Buffer& buffer : buffers_) sum += buffer.bytes();
  return sum;
}

void EffectsState::list(std::vector<Plan::Buffer>& to) const {
  for (const Buffer& buffer : buffers_)
    if (buffer.bytes() > 0) to.push_back({buffer.name(), buffer.bytes()});
}

}  // namespace gnosphere::vulkan
