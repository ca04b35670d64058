// SPDX-License-Identifier: Apache-2.0
// Counts the library's calls of some functions of a Vulkan device, by a table between the library and the loader.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "engine/vulkan_app.hpp"

namespace gnosphere::test {

/// A function that is counted: what the library calls, the driver's own, and the number of calls.
struct CountedCall {
  std::string_view name;
  PFN_vkVoidFunction call;
  PFN_vkVoidFunction* real;
  int* count;
};

template <size_t kIndex, typename Function>
struct Counter;
template <size_t kIndex, typename Result, typename... Arguments>
struct Counter<kIndex, Result(VKAPI_PTR*)(Arguments...)> {
  static inline PFN_vkVoidFunction real = nullptr;
  static inline int count = 0;
  static VKAPI_ATTR Result VKAPI_CALL call(Arguments... arguments) {
    ++count;
    return reinterpret_cast<Result(VKAPI_PTR*)(Arguments...)>(real)(arguments...);
  }
};

template <size_t kIndex, typename Function>
CountedCall counted(std::string_view name) {
  using Calls = Counter<kIndex, Function>;
  return {name, reinterpret_cast<PFN_vkVoidFunction>(Calls::call), &Calls::real, &Calls::count};
}

/// The functions that allocate, submit or wait.
inline const std::array kCostlyCalls = {counted<0, PFN_vkAllocateMemory>("vkAllocateMemory"),
                                        counted<1, PFN_vkCreateBuffer>("vkCreateBuffer"),
                                        counted<2, PFN_vkWaitForFences>("vkWaitForFences"),
                                        counted<3, PFN_vkQueueWaitIdle>("vkQueueWaitIdle"),
                                        counted<4, PFN_vkQueueSubmit>("vkQueueSubmit"),
                                        counted<5, PFN_vkMapMemory>("vkMapMemory"),
                                        counted<6, PFN_vkCreateCommandPool>("vkCreateCommandPool"),
                                        counted<7, PFN_vkCreateComputePipelines>("vkCreateComputePipelines")};
/// The functions that record dispatches.
inline const std::array kDispatchCalls = {counted<8, PFN_vkCmdDispatch>("vkCmdDispatch"),
                                          counted<9, PFN_vkCmdDispatchIndirect>("vkCmdDispatchIndirect")};

inline int callsOf(std::span<const CountedCall> functions) {
  int sum = 0;
  for (const CountedCall& function : functions) sum += *function.count;
  return sum;
}

inline void forgetCalls() {
  for (const CountedCall& function : kCostlyCalls) *function.count = 0;
  for (const CountedCall& function : kDispatchCalls) *function.count = 0;
}

/// Returns the function by which the loader's own functions are found.
inline PFN_vkGetInstanceProcAddr loaderLookUp() {
  return reinterpret_cast<PFN_vkGetInstanceProcAddr>(
      dlsym(dlopen("libvulkan.so.1", RTLD_NOW), "vkGetInstanceProcAddr"));
}

/// Returns a table with which VulkanApp counts the library's calls, from now on.
inline PFN_vkGetInstanceProcAddr countingLookUp() {
  static PFN_vkGetDeviceProcAddr ofDevice = nullptr;
  forgetCalls();
  static const PFN_vkGetDeviceProcAddr countingDevice = [](VkDevice device, const char* name) {
    const PFN_vkVoidFunction real = ofDevice(device, name);
    for (const std::span<const CountedCall> functions : {std::span<const CountedCall>(kCostlyCalls), {kDispatchCalls}})
      for (const CountedCall& function : functions)
        if (function.name == name) {
          *function.real = real;
          return function.call;
        }
    return real;
  };
  return [](VkInstance instance, const char* name) {
    static const PFN_vkGetInstanceProcAddr loader = loaderLookUp();
    const PFN_vkVoidFunction real = loader(instance, name);
    if (std::string_view(name) != "vkGetDeviceProcAddr") return real;
    ofDevice = reinterpret_cast<PFN_vkGetDeviceProcAddr>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(countingDevice);
  };
}

}  // namespace gnosphere::test
