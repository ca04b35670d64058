// SPDX-License-Identifier: Apache-2.0
// The functions of libcuda.so.1 that import memory, with the structures as cuda.h 12 declares them.
#include "vulkan/fake_cuda.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>

using gnosphere::test::FakeCuda;

namespace {

constexpr int kInvalidValue = 1, kFailed = 999;
constexpr int kDevice = 1;
char context, memory;

FakeCuda& fake() {
  static FakeCuda one;
  return one;
}

bool fails() {
  return ++fake().calls == fake().failAt;
}

struct HandleDesc {
  int type;
  int padding;
  int fd;
  int rest[3];
  unsigned long long size;
  unsigned int flags;
  unsigned int reserved[16];
};
struct BufferDesc {
  unsigned long long offset, size;
  unsigned int flags;
  unsigned int reserved[16];
};

}  // namespace

#define FAKE extern "C" __attribute__((visibility("default")))

FAKE FakeCuda* fakeCuda() {
  return &fake();
}

FAKE int cuInit(unsigned int flags) {
  return fails() ? kFailed : flags == 0 ? 0 : kInvalidValue;
}
FAKE int cuGetErrorName(int error, const char** name) {
  *name = error == kFailed ? "CUDA_ERROR_UNKNOWN" : "CUDA_ERROR_INVALID_VALUE";
  return 0;
}
FAKE int cuDeviceGetCount(int* count) {
  *count = 2;
  return fails() ? kFailed : 0;
}
FAKE int cuDeviceGetUuid(uint8_t* uuid, int device) {
  if (device == kDevice)
    std::copy_n(fake().uuid.data(), 16, uuid);
  else
    std::fill_n(uuid, 16, uint8_t{0xfe});
  return fails() ? kFailed : 0;
}
FAKE int cuDevicePrimaryCtxRetain(void** given, int device) {
  if (device != kDevice) return kInvalidValue;
  if (fails()) return kFailed;
  ++fake().retained;
  *given = &context;
  return 0;
}
FAKE int cuDevicePrimaryCtxRelease_v2(int device) {
  if (device != kDevice) return kInvalidValue;
  --fake().retained;
  return 0;
}
FAKE int cuCtxPushCurrent_v2(void* given) {
  if (given != &context) return kInvalidValue;
  if (fails()) return kFailed;
  ++fake().pushed;
  return 0;
}
FAKE int cuCtxPopCurrent_v2(void** given) {
  --fake().pushed;
  *given = &context;
  return 0;
}
FAKE int cuImportExternalMemory(void** imported, const HandleDesc* handle) {
  if (fake().pushed == 0 || handle->type != 1 || handle->flags != 0 || fcntl(handle->fd, F_GETFD) < 0)
    return kInvalidValue;
  if (fails()) return kFailed;
  close(handle->fd);  // the driver owns it
  ++fake().imported;
  fake().bytes = handle->size;
  *imported = &memory;
  return 0;
}
FAKE int cuExternalMemoryGetMappedBuffer(uint64_t* address, void* imported, const BufferDesc* buffer) {
  if (imported != &memory || buffer->offset != 0 || buffer->size > fake().bytes || buffer->flags != 0)
    return kInvalidValue;
  if (fails()) return kFailed;
  *address = gnosphere::test::kFakeAddress + static_cast<uint64_t>(fake().mapped++) * (1 << 20);
  return 0;
}
FAKE int cuDestroyExternalMemory(void* imported) {
  if (imported != &memory || fake().pushed == 0) return kInvalidValue;
  --fake().imported;
  return 0;
}
FAKE int cuMemFree_v2(uint64_t address) {
  if (address < gnosphere::test::kFakeAddress || fake().pushed == 0) return kInvalidValue;
  --fake().mapped;
  return 0;
}
