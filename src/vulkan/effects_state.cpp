// SPDX-License-Identifier: Apache-2.0
#include "vulkan/effects_state.hpp"

#include <algorithm>

namespace gnosphere::vulkan {

EffectsState::EffectsState(const Device& device, const SensorPlan& plan, std::span<const gpu::Row> rows,
                           uint64_t firstBeam)
    : device_(device), plan_(plan), firstBeam_(firstBeam) {
  make(lastingArrays(plan, rows, firstBeam));
}

void EffectsState::makeOutputs(std::span<const Output> outputs, uint64_t beams) {
  for (const Output& output : outputs)
    if (output.binding >= gpu::kWorkBindingCount)
      buffers_[output.binding] = Buffer(device_, "results", beams * output.bytesPerBeam, Memory::device);
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
  make(projectedArrays(plan_, count));
}

void EffectsState::prepare(EffectsBuffers& frame, const Shot& shot, const ShotMotion* motion) const {
  for (const EffectsArray& array : shotArrays(plan_, firstBeam_, shot, motion)) {
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
