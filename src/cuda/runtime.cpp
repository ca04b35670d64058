// SPDX-License-Identifier: Apache-2.0
#include "cuda/runtime.hpp"

#include <cuda_runtime_api.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <system_error>

#include "base/text.hpp"
#include "gnosphere/error.hpp"
#include "pipeline/backend.hpp"

namespace gnosphere::cuda {
namespace {

void check(cudaError_t result, const char* call) {
  if (result == cudaSuccess) return;
  throw Error(ErrorCode::device,
              std::string(call) + ": " + cudaGetErrorName(result) + ", " + cudaGetErrorString(result));
}
#define CUDA(call_) check(call_, #call_)

std::string versionText(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

DeviceInfo infoOf(int index) {
  cudaDeviceProp properties;
  CUDA(cudaGetDeviceProperties(&properties, index));
  int driver = 0;
  CUDA(cudaDriverGetVersion(&driver));
  DeviceInfo info;
  info.name = "cuda:" + std::to_string(index) + " " + properties.name;
  info.type = "cuda";
  info.driver = "CUDA " + versionText(driver) + ", compute " + std::to_string(properties.major) + "." +
                std::to_string(properties.minor);
  info.maxBufferBytes = properties.totalGlobalMem;
  info.subgroupSize = static_cast<uint32_t>(properties.warpSize);
  std::copy(std::begin(properties.uuid.bytes), std::end(properties.uuid.bytes), info.uuid.begin());
  if (10 * properties.major + properties.minor < 75)
    info.reason = "it has compute capability " + std::to_string(properties.major) + "." +
                  std::to_string(properties.minor) + ", 7.5 is needed";
  info.usable = info.reason.empty();
  return info;
}
}  // namespace

std::vector<DeviceInfo> devices(std::string& problem) {
  int count = 0, driver = 0;
  if (cudaDriverGetVersion(&driver) == cudaSuccess && driver == 0) {
    problem = "no driver is installed";
    return {};
  }
  if (const cudaError_t result = cudaGetDeviceCount(&count); result != cudaSuccess) {
    problem = cudaGetErrorString(result);
    return {};
  }
  std::vector<DeviceInfo> result;
  for (int i = 0; i < count; ++i) result.push_back(infoOf(i));
  if (result.empty()) problem = "the driver sees none";
  return result;
}

Device chooseDevice(const DeviceChoice& choice) {
  std::string problem;
  const std::vector<DeviceInfo> all = devices(problem);
  const std::string which = "device '" + nameOf(choice) + "': ";
  if (all.empty()) throw Error(ErrorCode::device, which + "there is no CUDA device here (" + problem + ")");
  size_t index = 0;
  if (choice.uuid != DeviceChoice().uuid) {
    while (index < all.size() && all[index].uuid != choice.uuid) ++index;
    if (index == all.size()) throw Error(ErrorCode::device, "the CUDA device with the chosen UUID is no longer there");
  } else if (!choice.name.empty()) {
    const char* end = choice.name.data() + choice.name.size();
    const auto [ptr, error] = std::from_chars(choice.name.data(), end, index);
    if (error != std::errc() || ptr != end)
      throw Error(ErrorCode::device, which + "a CUDA device is named by a number from 0 on");
  }
  if (index >= all.size()) throw Error(ErrorCode::device, which + "the last CUDA device here is " + all.back().name);
  Device device;
  device.workgroups = 4096;
  device.index = static_cast<int>(index);
  device.launch = choice.kind == DeviceChoice::Kind::cudaFast ? fast::launch : parity::launch;
  device.info = all[index];
  if (!device.info.usable)
    throw Error(ErrorCode::device, "device '" + device.info.name + "' cannot be used: " + device.info.reason);
  return device;
}

void use(const Device& device) {
  CUDA(cudaSetDevice(device.index));
}

std::byte* allocate(const char* name, uint64_t bytes) {
  void* memory = nullptr;
  const cudaError_t result = cudaMalloc(&memory, bytes);
  if (result == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    throw Error(ErrorCode::outOfMemory,
                "cannot allocate " + mebibytes(bytes) + " for '" + name + "' on the CUDA device");
  }
  check(result, "cudaMalloc");
  return static_cast<std::byte*>(memory);
}

void release(void* memory) {
  cudaFree(memory);
}

void copyToDevice(void* to, const void* from, uint64_t bytes) {
  if (bytes > 0) CUDA(cudaMemcpy(to, from, bytes, cudaMemcpyHostToDevice));
}

void copyToHost(void* to, const void* from, uint64_t bytes) {
  CUDA(cudaGetLastError());  // reports the error of an earlier launch
  if (bytes > 0) CUDA(cudaMemcpy(to, from, bytes, cudaMemcpyDeviceToHost));
}

void fill(void* memory, uint8_t value, uint64_t bytes) {
  if (bytes > 0) CUDA(cudaMemsetAsync(memory, value, bytes));
}

void copy(void* to, const void* from, uint64_t bytes) {
  if (bytes > 0) CUDA(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice));
}

Stopwatch::Stopwatch() = default;

Stopwatch::~Stopwatch() {
  for (void* event : events_) cudaEventDestroy(static_cast<cudaEvent_t>(event));
}

void Stopwatch::start() {
  stages_.clear();
  finished("");
}

void Stopwatch::finished(const char* stage) {
  if (events_.size() <= stages_.size()) {
    cudaEvent_t event = nullptr;
    CUDA(cudaEventCreate(&event));
    events_.push_back(event);
  }
  CUDA(cudaEventRecord(static_cast<cudaEvent_t>(events_[stages_.size()])));
  stages_.push_back(stage);
}

void Stopwatch::read(Timings& timings) {
  for (size_t i = 1; i < stages_.size(); ++i) {
    float ms = 0;
    CUDA(cudaEventSynchronize(static_cast<cudaEvent_t>(events_[i])));
    CUDA(cudaEventElapsedTime(&ms, static_cast<cudaEvent_t>(events_[i - 1]), static_cast<cudaEvent_t>(events_[i])));
    timings.gpuMs += ms;
    timings.add(stages_[i], ms);
  }
}

}  // namespace gnosphere::cuda
