// SPDX-License-Identifier: Apache-2.0
// Memory of a Vulkan device as CUDA sees it. CUDA's driver is looked up when it is needed, so no build needs CUDA.
#pragma once

#include <cstdint>

#include "gnosphere/simulator.hpp"

namespace gnosphere::vulkan {

/// Returns the number by which CUDA knows the device. Throws Error(device) that gives the reason if it does not.
int cudaNumberOf(const DeviceInfo& device);

/// Memory that is imported into the primary context of a device, which PyTorch and CUDA's runtime use, too.
class CudaMemory {
 public:
  /// Imports the memory of a file descriptor, and closes the descriptor in any case. Throws Error(device) that names
  /// the call of CUDA that failed.
  CudaMemory(const DeviceInfo& device, int number, int fd, uint64_t bytes);
  ~CudaMemory();
  CudaMemory(const CudaMemory&) = delete;
  CudaMemory& operator=(const CudaMemory&) = delete;

  /// The address of the first byte in CUDA.
  uint64_t address() const { return address_; }
  int device() const { return number_; }

 private:
  int number_;                // CUdevice
  void* context_ = nullptr;   // CUcontext
  void* imported_ = nullptr;  // CUexternalMemory
  uint64_t address_ = 0;      // CUdeviceptr
};

}  // namespace gnosphere::vulkan
