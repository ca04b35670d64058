// SPDX-License-Identifier: Apache-2.0
// What the pipeline asks of a device: memory, and to run the steps of a scan. Implemented by vulkan/ and cuda/.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "arrays.h"
#include "gnosphere/simulator.hpp"
#include "pipeline/device_memory.hpp"
#include "pipeline/steps.hpp"

namespace gnosphere {

/// What the choice of kernels and the sizes of dispatches depend on.
struct Traits {
  DeviceInfo info;
  bool cpu = false;           ///< a software device
  bool int64Atomics = false;  ///< 64-bit atomic minimum on storage
  bool float64 = false;
  uint32_t groups = 4096;  ///< workgroups that fill the device: kernels loop over however many items there are
};

/// The memory of every array of a scan, by gpu::Array; null: no kernel of the scan uses it.
using BoundArrays = std::array<DeviceMemory*, gpu::kArrayCount>;

class Machine {
 public:
  virtual ~Machine() = default;
  virtual const Traits& traits() const = 0;
  /// Throws Error(outOfMemory) that names the array. `name` must outlive the memory.
  virtual std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind kind) = 0;
  /// Compiles a kernel, if it is not there already.
  virtual void prepare(const Variant& variant) = 0;
  /// After the last prepare() of a simulator.
  virtual void prepared() {}
  /// Scans that may be under way at a time.
  virtual size_t framesInFlight() const = 0;
  /// Begins to run the steps as frame in flight `frame`, which must have been waited for.
  virtual void submit(size_t frame, std::span<const Step> steps, const BoundArrays& arrays) = 0;
  /// Until the frame is done; returns at once where none is under way.
  virtual void wait(size_t frame) = 0;
  /// Adds the times of the stages of a frame that was waited for.
  virtual void readTimings(size_t frame, Timings& timings) = 0;
  /// Throws what the device's validation has found, if it is on.
  virtual void throwOnMessages() {}
};

}  // namespace gnosphere
