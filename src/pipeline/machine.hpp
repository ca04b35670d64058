// SPDX-License-Identifier: Apache-2.0
// Interface to a device: it allocates memory and runs the steps of a scan. Implemented by vulkan/ and cuda/.
#pragma once

#include <array>
#include <bit>
#include <chrono>
#include <memory>
#include <span>

#include "common/arrays.h"
#include "gnosphere/simulator.hpp"
#include "pipeline/device_memory.hpp"
#include "pipeline/result_ring.hpp"
#include "pipeline/steps.hpp"

namespace gnosphere {

/// Properties of a device on which the choice of kernels and the sizes of dispatches depend.
struct Traits {
  DeviceInfo info;
  bool cpu = false;           ///< true for a software device
  bool int64Atomics = false;  ///< the device has a 64-bit atomic minimum on storage buffers
  bool float64 = false;
  bool spreadsRays = false;    ///< kernels can spread the sub-rays of a beam over the lanes of a subgroup
  uint32_t workgroups = 4096;  ///< number that fills the device; kernels loop until all items are done
};

/// The memory of every array of a scan, indexed by gpu::Array; null if no kernel of the scan uses the array.
using BoundArrays = std::array<DeviceMemory*, gpu::kArrayCount>;

/// Returns the table by which the kernels find the arrays.
inline gpu::Addresses addressesOf(const BoundArrays& arrays) {
  std::array<uint64_t, gpu::kArrayCount> addresses = {};
  for (size_t i = 0; i < arrays.size(); ++i)
    if (arrays[i]) addresses[i] = arrays[i]->address();
  return std::bit_cast<gpu::Addresses>(addresses);
}

class Machine {
 public:
  virtual ~Machine() = default;
  virtual const Traits& traits() const = 0;
  /// Throws Error(outOfMemory) that names the array. `name` must outlive the memory.
  virtual std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind kind) = 0;
  /// Compiles the kernels that are not yet compiled, on all threads of the host. A machine may leave that to the first
  /// scan that needs them.
  virtual void prepare(std::span<const Variant> variants) = 0;
  /// Adds what the driver says of a compiled kernel, if that is known.
  virtual void describe(const Variant& /*variant*/, Plan::Pipeline& /*pipeline*/) const {}
  /// Called after the last of a series of prepare() calls.
  virtual void prepared() {}
  /// Number of submissions that may be in flight together. Each has a slot, numbered from 0.
  virtual size_t slots() const = 0;
  /// How long submit() and record() have compiled kernels until now.
  virtual std::chrono::steady_clock::duration compiling() const { return {}; }
  /// Starts the steps in a slot. wait() must have been called for its previous submission.
  virtual void submit(size_t slot, std::span<const Step> steps, const BoundArrays& arrays) = 0;
  /// Waits until the slot is done; returns at once if it is not running.
  virtual void wait(size_t slot) = 0;
  /// Adds the stage times of the slot to `timings`; call wait() first.
  virtual void readTimings(size_t slot, Timings& timings) = 0;
  /// Turns the measurement of workMs() on or off for the submissions that follow. On a CPU it takes 0.1 ms of each.
  virtual void timeWork(bool /*on*/) {}
  /// Returns how many milliseconds the device worked on the slot, or 0 if that was not measured; call wait() first.
  virtual double workMs(size_t /*slot*/) { return 0; }
  /// Throws Error(device) with the messages of the validation layer, if it is on and there are any.
  virtual void throwOnMessages() {}

  /// Whether results stay on the device. Then submit() is not called; scans are recorded between beginRecording() and
  /// endRecording(), into command buffers of the caller or of a ResultRing. Memory that is destroyed stays until no
  /// recorded scan uses it, and what is written to memory of the kind `device` arrives with the next recording.
  virtual bool recordsOnly() const { return false; }
  /// Whether the library submits what is recorded, so that steps may be divided into several submissions.
  virtual bool submits() const { return !recordsOnly(); }
  /// Begins to record as frame in flight `frame`, whose commands have completed: into a command buffer of the caller,
  /// or into the commands of a ring that have been begun.
  virtual void beginRecording(void* /*commands*/, ResultRing* /*ring*/, size_t /*frame*/) {}
  /// Records the steps of a scan. `addresses` has room for gpu::Addresses and is of the kind `upload`; the commands
  /// that were recorded with it before have completed.
  virtual void record(DeviceMemory& /*addresses*/, std::span<const Step> /*steps*/, const BoundArrays& /*arrays*/) {}
  virtual void endRecording() {}
  /// The commands of the last recording of this frame will never run.
  virtual void abandonRecording(size_t /*frame*/) noexcept {}
  /// Makes buffers for the results of recorded scans on a device of our own, of so many bytes each, the first
  /// `hostBytes` of which the host reads. The machine must outlive them.
  virtual std::unique_ptr<ResultRing> makeRing(size_t /*buffers*/, uint64_t /*bytes*/, uint64_t /*hostBytes*/) {
    return nullptr;
  }
};

}  // namespace gnosphere
