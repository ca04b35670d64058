// SPDX-License-Identifier: Apache-2.0
#include "failure/injection.hpp"

#include <dlfcn.h>
#include <execinfo.h>
#include <link.h>
#include <vulkan/vulkan_core.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "support.hpp"
#include "vulkan/shader_object.hpp"

extern "C" void* __real_dlsym(void* library, const char* name);

namespace gnosphere::test {
namespace {

std::atomic<bool> memoryArmed, filesArmed, deviceArmed;
std::atomic<bool> hit, lasting;
std::atomic<long> counted, failing;
thread_local bool looking = false;

struct Code {
  uintptr_t first = 0, end = 0;
  bool has(const void* address) const {
    const auto at = reinterpret_cast<uintptr_t>(address);
    return at >= first && at < end;
  }
};
Code program, standardLibrary;

int findCode(dl_phdr_info* info, size_t, void*) {
  const bool main = info->dlpi_name[0] == '\0';
  Code& code = main ? program : standardLibrary;
  if (!main && !std::strstr(info->dlpi_name, "libstdc++")) return 0;
  if (main && program.end != 0) return 0;
  for (int i = 0; i < info->dlpi_phnum; ++i)
    if (info->dlpi_phdr[i].p_type == PT_LOAD && (info->dlpi_phdr[i].p_flags & PF_X) != 0) {
      code.first = info->dlpi_addr + info->dlpi_phdr[i].p_vaddr;
      code.end = code.first + info->dlpi_phdr[i].p_memsz;
    }
  return 0;
}

// Whether the library calls, which is linked into this program, and not a driver; functions of the standard library
// that are not templates call on behalf of whoever calls them.
bool isOurs(const void* caller) {
  if (program.has(caller)) return true;
  if (!standardLibrary.has(caller) || looking) return false;
  looking = true;
  void* frames[16];
  const int count = backtrace(frames, 16);
  looking = false;
  int i = 0;
  while (i < count && !standardLibrary.has(frames[i])) ++i;
  while (i < count && standardLibrary.has(frames[i])) ++i;
  return i < count && program.has(frames[i]);
}

bool fails(const std::atomic<bool>& armed, const void* caller) {
  if (!armed || !isOurs(caller)) return false;
  const long count = ++counted;
  if (failing == 0 || count < failing || (count > failing && !lasting)) return false;
  hit = true;
  return true;
}

void* allocate(size_t bytes, size_t alignment, const void* caller) {
  if (fails(memoryArmed, caller)) throw std::bad_alloc();
  const size_t size = std::max<size_t>(bytes, 1);
  void* memory = alignment > alignof(std::max_align_t)
                     ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                     : std::malloc(size);
  if (!memory) throw std::bad_alloc();
  return memory;
}

void* allocateOrNull(size_t bytes, size_t alignment, const void* caller) noexcept {
  try {
    return allocate(bytes, alignment, caller);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

// The functions of devices that make something. All of them may fail for lack of memory.
// clang-format off
#define FAILING_FUNCTIONS(FUNCTION) \
  FUNCTION(vkAllocateCommandBuffers) \
  FUNCTION(vkAllocateMemory) \
  FUNCTION(vkBindBufferMemory) \
  FUNCTION(vkCreateBuffer) \
  FUNCTION(vkCreateCommandPool) \
  FUNCTION(vkCreateComputePipelines) \
  FUNCTION(vkCreateFence) \
  FUNCTION(vkCreatePipelineCache) \
  FUNCTION(vkCreatePipelineLayout) \
  FUNCTION(vkCreateQueryPool) \
  FUNCTION(vkCreateShaderModule) \
  FUNCTION(vkCreateShadersEXT) \
  FUNCTION(vkGetShaderBinaryDataEXT) \
  FUNCTION(vkMapMemory)
// clang-format on

PFN_vkGetInstanceProcAddr realInstanceFunction = nullptr;
PFN_vkGetDeviceProcAddr realDeviceFunction = nullptr;

// Stands in front of a function of any device. Drivers and layers have functions of their own for each, so the real one
// is looked up at every call.
template <typename Function>
struct Failing;
template <typename... Arguments>
struct Failing<VkResult(VKAPI_PTR*)(VkDevice, Arguments...)> {
  using Function = VkResult(VKAPI_PTR*)(VkDevice, Arguments...);
  template <auto kName>
  static VKAPI_ATTR VkResult VKAPI_CALL call(VkDevice device, Arguments... arguments) {
    if (fails(deviceArmed, __builtin_return_address(0))) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    return reinterpret_cast<Function>(realDeviceFunction(device, kName()))(device, arguments...);
  }
};

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL deviceFunction(VkDevice device, const char* name) {
#define TAKE_PLACE(function)                                                            \
  if (std::strcmp(name, #function) == 0) {                                              \
    constexpr auto kName = [] { return #function; };                                    \
    return reinterpret_cast<PFN_vkVoidFunction>(&Failing<PFN_##function>::call<kName>); \
  }
  FAILING_FUNCTIONS(TAKE_PLACE)
  return realDeviceFunction(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instanceFunction(VkInstance instance, const char* name) {
  const PFN_vkVoidFunction real = realInstanceFunction(instance, name);
  if (std::strcmp(name, "vkGetDeviceProcAddr") != 0) return real;
  realDeviceFunction = reinterpret_cast<PFN_vkGetDeviceProcAddr>(real);
  return reinterpret_cast<PFN_vkVoidFunction>(deviceFunction);
}

// Devices that are made from now on may fail, those of the library and those of tests.
PFN_vkVoidFunction failingLookUp(void* library) {
  realInstanceFunction = reinterpret_cast<PFN_vkGetInstanceProcAddr>(__real_dlsym(library, "vkGetInstanceProcAddr"));
  return reinterpret_cast<PFN_vkVoidFunction>(instanceFunction);
}

/// How many calls were made while something failed, and how many of these reported it.
struct Tried {
  long calls = 0, failed = 0;
};

Tried failEach(const std::string& name, Fails what, Lasts lasts, const Trial& trial) {
  long failed = 0, survived = 0, tried = 0, all = 0;
  // Calls that compile kernels make tens of thousands of allocations, most of them in the same loops.
  const auto following = [](long n) { return n + 1 + (everyCombination() ? n / 100 : n / 3); };
  for (long n = 1;; n = following(n)) {
    bool fired = false, threw = false;
    std::string problem;
    {
      Injection injection(what, n, lasts);
      try {
        trial.call();
      } catch (const Error&) {
        threw = true;
      } catch (const std::bad_alloc&) {
        threw = true;
      } catch (const std::exception& other) {
        problem = other.what();
        threw = true;
      }
      fired = injection.fired();
      all = injection.count();
    }
    INFO(name << ": failure " << n);
    CHECK(problem == "");
    if (!threw && trial.undo) trial.undo();
    ++tried;
    failed += threw;
    survived += fired && !threw;
    if (trial.check) trial.check();
    if (!fired) {
      CHECK_FALSE(threw);
      break;
    }
  }
  std::printf("%-56s %6ld of %6ld failures tried, %6ld reported, %4ld without effect\n", name.c_str(), tried - 1, all,
              failed, survived);
  return {failed + survived, failed};
}

}  // namespace

Injection::Injection(Fails what, long at, Lasts lasts) {
  if (program.end == 0) {
    dl_iterate_phdr(findCode, nullptr);
    void* frame;
    backtrace(&frame, 1);  // its first call loads a library
  }
  counted = 0;
  failing = at;
  hit = false;
  lasting = lasts == Lasts::forGood;
  (what == Fails::memory ? memoryArmed : what == Fails::files ? filesArmed : deviceArmed) = true;
}
Injection::~Injection() {
  memoryArmed = filesArmed = deviceArmed = false;
}
long Injection::count() const {
  return counted;
}
bool Injection::fired() const {
  return hit;
}

long failEach(const std::string& name, Fails what, const Trial& trial) {
  const Tried once = failEach(name, what, Lasts::once, trial);
  const Tried forGood = failEach(name + ", for good", what, Lasts::forGood, trial);
  INFO(name << ": nothing has failed");
  if (what != Fails::memory) CHECK(once.calls + forGood.calls > 0);
  return once.failed + forGood.failed;
}

}  // namespace gnosphere::test

using gnosphere::test::allocate, gnosphere::test::allocateOrNull;

void* operator new(size_t bytes) {
  return allocate(bytes, 0, __builtin_return_address(0));
}
void* operator new[](size_t bytes) {
  return allocate(bytes, 0, __builtin_return_address(0));
}
void* operator new(size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<size_t>(alignment), __builtin_return_address(0));
}
void* operator new[](size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<size_t>(alignment), __builtin_return_address(0));
}
void* operator new(size_t bytes, const std::nothrow_t&) noexcept {
  return allocateOrNull(bytes, 0, __builtin_return_address(0));
}
void* operator new[](size_t bytes, const std::nothrow_t&) noexcept {
  return allocateOrNull(bytes, 0, __builtin_return_address(0));
}
void* operator new(size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocateOrNull(bytes, static_cast<size_t>(alignment), __builtin_return_address(0));
}
void* operator new[](size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocateOrNull(bytes, static_cast<size_t>(alignment), __builtin_return_address(0));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, const std::nothrow_t&) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, size_t, std::align_val_t) noexcept {
  std::free(memory);
}

// The linker leads the program's own calls here (--wrap).
extern "C" {
size_t __real_fwrite(const void* data, size_t size, size_t count, std::FILE* stream);
int __real_fclose(std::FILE* stream);
int __real_fsync(int file);
int __real_rename(const char* from, const char* to);
std::FILE* __real_fopen(const char* name, const char* mode);

size_t __wrap_fwrite(const void* data, size_t size, size_t count, std::FILE* stream) {
  using namespace gnosphere::test;
  if (!fails(filesArmed, __builtin_return_address(0))) return __real_fwrite(data, size, count, stream);
  errno = ENOSPC;
  return 0;
}
int __wrap_fclose(std::FILE* stream) {
  using namespace gnosphere::test;
  const bool failing = fails(filesArmed, __builtin_return_address(0));
  const int result = __real_fclose(stream);
  if (failing) errno = EIO;
  return failing ? EOF : result;
}
int __wrap_fsync(int file) {
  using namespace gnosphere::test;
  if (!fails(filesArmed, __builtin_return_address(0))) return __real_fsync(file);
  errno = EIO;
  return -1;
}
int __wrap_rename(const char* from, const char* to) {
  using namespace gnosphere::test;
  if (!fails(filesArmed, __builtin_return_address(0))) return __real_rename(from, to);
  errno = EACCES;
  return -1;
}
std::FILE* __wrap_fopen(const char* name, const char* mode) {
  using namespace gnosphere::test;
  if (!fails(filesArmed, __builtin_return_address(0))) return __real_fopen(name, mode);
  errno = EMFILE;
  return nullptr;
}
void* __wrap_dlsym(void* library, const char* name) {
  using namespace gnosphere::test;
  if (std::strcmp(name, "vkGetInstanceProcAddr") != 0) return __real_dlsym(library, name);
  return reinterpret_cast<void*>(failingLookUp(library));
}
}
