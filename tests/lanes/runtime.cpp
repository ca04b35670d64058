// SPDX-License-Identifier: Apache-2.0
// CUDA's runtime functions over watched memory on the host.
#include "cuda/host_runtime.hpp"
#include "lanes/accesses.hpp"
#include "lanes/schedule.hpp"

namespace gnosphere::cuda {
namespace {

void launchNamed(Kernel kernel, const Job& job, uint32_t workgroupsX, uint32_t workgroupsY) {
  lanes::setKernel(nameOf(kernel));
  parity::launch(kernel, job, workgroupsX, workgroupsY);
}

}  // namespace

Device chooseDevice(const DeviceChoice&) {
  Device device = hostDevice("lanes on the host");
  device.workgroups = 3;
  device.launch = launchNamed;
  // The smallest subgroups, so that two places per lane are enough for 7 sub-rays in subgroups of any size.
  device.info.subgroupSize = 4;
  device.spreadsRays = true;
  return device;
}

std::byte* allocate(const char* name, uint64_t bytes) {
  return lanes::allocate(name, bytes);
}

void release(void* memory) {
  lanes::release(memory);
}

}  // namespace gnosphere::cuda
