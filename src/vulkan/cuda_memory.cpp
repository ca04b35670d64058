// SPDX-License-Identifier: Apache-2.0
#include "vulkan/cuda_memory.hpp"

#include <algorithm>
#include <string>

#include "base/os.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::vulkan {
namespace {

// The part of cuda.h, since CUDA 10, that imports memory of other interfaces; see "External Resource Interoperability"
// in NVIDIA's manual of the driver API.
using Result = int;
constexpr int kOpaqueFd = 1;  // CU_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD

struct MemoryHandle {  // CUDA_EXTERNAL_MEMORY_HANDLE_DESC
  int type = kOpaqueFd;
  union {
    int fd;
    void* pointers[2];
  } handle = {};
  unsigned long long size = 0;
  unsigned int flags = 0;
  unsigned int reserved[16] = {};
};
struct MappedBuffer {  // CUDA_EXTERNAL_MEMORY_BUFFER_DESC
  unsigned long long offset = 0, size = 0;
  unsigned int flags = 0;
  unsigned int reserved[16] = {};
};
static_assert(sizeof(MemoryHandle) == 104 && sizeof(MappedBuffer) == 88);

struct Driver {
  Result (*cuInit)(unsigned int flags) = nullptr;
  Result (*cuGetErrorName)(Result error, const char** name) = nullptr;
  Result (*cuDeviceGetCount)(int* count) = nullptr;
  Result (*cuDeviceGetUuid)(uint8_t uuid[16], int device) = nullptr;
  Result (*cuDevicePrimaryCtxRetain)(void** context, int device) = nullptr;
  Result (*cuDevicePrimaryCtxRelease_v2)(int device) = nullptr;
  Result (*cuCtxPushCurrent_v2)(void* context) = nullptr;
  Result (*cuCtxPopCurrent_v2)(void** context) = nullptr;
  Result (*cuImportExternalMemory)(void** memory, const MemoryHandle* handle) = nullptr;
  Result (*cuExternalMemoryGetMappedBuffer)(uint64_t* address, void* memory, const MappedBuffer* buffer) = nullptr;
  Result (*cuDestroyExternalMemory)(void* memory) = nullptr;
  Result (*cuMemFree_v2)(uint64_t address) = nullptr;
  std::string problem;  // why it cannot be used; empty if it can
};

Driver openDriver() {
  Driver driver;
  void* const library = os::openLibrary("libcuda.so.1");
  if (!library) {
    driver.problem = "CUDA's driver (libcuda.so.1) was not found";
    return driver;
  }
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::decay_t<decltype(function)>>(os::symbolOf(library, name));
    if (!function) driver.problem = std::string("CUDA's driver has no ") + name;
  };
#define GNO_FIND(name_) find(driver.name_, #name_);
  GNO_FIND(cuInit)
  GNO_FIND(cuGetErrorName)
  GNO_FIND(cuDeviceGetCount)
  GNO_FIND(cuDeviceGetUuid)
  GNO_FIND(cuDevicePrimaryCtxRetain)
  GNO_FIND(cuDevicePrimaryCtxRelease_v2)
  GNO_FIND(cuCtxPushCurrent_v2)
  GNO_FIND(cuCtxPopCurrent_v2)
  GNO_FIND(cuImportExternalMemory)
  GNO_FIND(cuExternalMemoryGetMappedBuffer)
  GNO_FIND(cuDestroyExternalMemory)
  GNO_FIND(cuMemFree_v2)
#undef GNO_FIND
  return driver;
}

// The driver is opened once, and stays open until the process ends.
const Driver& cuda() {
  static const Driver& driver = *new Driver(openDriver());
  return driver;
}

[[noreturn]] void refuse(const DeviceInfo& device, const std::string& why) {
  throw Error(ErrorCode::device, "CUDA cannot have the results on '" + device.name + "': " + why);
}

void check(const DeviceInfo& device, Result result, const char* call) {
  if (result == 0) return;
  const char* name = nullptr;
  cuda().cuGetErrorName(result, &name);
  refuse(device,
         std::string(call) + " gave " + (name ? name : "an unknown error") + " (" + std::to_string(result) + ")");
}

}  // namespace

int cudaNumberOf(const DeviceInfo& device) {
  if (!cuda().problem.empty()) refuse(device, cuda().problem);
  check(device, cuda().cuInit(0), "cuInit()");
  int count = 0;
  check(device, cuda().cuDeviceGetCount(&count), "cuDeviceGetCount()");
  for (int i = 0; i < count; ++i) {
    decltype(device.uuid) uuid = {};
    check(device, cuda().cuDeviceGetUuid(uuid.data(), i), "cuDeviceGetUuid()");
    if (uuid == device.uuid) return i;
  }
  refuse(device, "it is not a device of CUDA");
}

CudaMemory::CudaMemory(const DeviceInfo& device, int number, int fd, uint64_t bytes) : number_(number) {
  const Driver& driver = cuda();
  Result result = driver.cuDevicePrimaryCtxRetain(&context_, number_);
  const char* call = "cuDevicePrimaryCtxRetain()";
  const auto then = [&](const char* name, const auto& next) {
    if (result != 0) return;
    call = name;
    result = next();
  };
  const bool retained = result == 0;
  then("cuCtxPushCurrent()", [&] { return driver.cuCtxPushCurrent_v2(context_); });
  const bool pushed = result == 0;
  then("cuImportExternalMemory()", [&] {
    MemoryHandle handle;
    handle.handle.fd = fd;
    handle.size = bytes;
    return driver.cuImportExternalMemory(&imported_, &handle);
  });
  const bool imported = result == 0;
  then("cuExternalMemoryGetMappedBuffer()", [&] {
    MappedBuffer buffer;
    buffer.size = bytes;
    return driver.cuExternalMemoryGetMappedBuffer(&address_, imported_, &buffer);
  });
  if (!imported) os::closeFile(fd);  // otherwise the descriptor is CUDA's
  if (result != 0 && imported) driver.cuDestroyExternalMemory(imported_);
  void* popped = nullptr;
  if (pushed) driver.cuCtxPopCurrent_v2(&popped);
  if (result != 0 && retained) driver.cuDevicePrimaryCtxRelease_v2(number_);
  check(device, result, call);
}

CudaMemory::~CudaMemory() {
  const Driver& driver = cuda();
  void* popped = nullptr;
  if (driver.cuCtxPushCurrent_v2(context_) == 0) {
    driver.cuMemFree_v2(address_);
    driver.cuDestroyExternalMemory(imported_);
    driver.cuCtxPopCurrent_v2(&popped);
  }
  driver.cuDevicePrimaryCtxRelease_v2(number_);
}

}  // namespace gnosphere::vulkan
