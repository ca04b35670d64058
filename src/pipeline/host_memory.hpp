// SPDX-License-Identifier: Apache-2.0
// Memory of a Machine that runs nothing: arrays of the host in place of a device's.
#pragma once

#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include "gnosphere/error.hpp"
#include "pipeline/device_memory.hpp"

namespace gnosphere {

/// Zeros that take no room until somebody writes to them.
class HostMemory final : public DeviceMemory {
 public:
  HostMemory(const char* name, uint64_t bytes)
      : bytes_(bytes), memory_(static_cast<std::byte*>(std::calloc(1, bytes > 0 ? bytes : 1)), std::free) {
    if (!memory_)
      throw Error(ErrorCode::outOfMemory, "the host has no " + std::to_string(bytes) + " bytes for '" + name + "'");
  }

  uint64_t bytes() const override { return bytes_; }
  uint64_t address() const override { return 0; }
  void* host() override { return memory_.get(); }
  void flush() override {}
  void invalidate() override {}
  void write(uint64_t place, std::span<const std::byte> data) override {
    if (!data.empty()) std::memcpy(memory_.get() + place, data.data(), data.size());
  }
  void read(uint64_t place, std::span<std::byte> data) const override {
    if (!data.empty()) std::memcpy(data.data(), memory_.get() + place, data.size());
  }

 private:
  uint64_t bytes_;
  std::unique_ptr<std::byte, decltype(&std::free)> memory_;
};

}  // namespace gnosphere
