// SPDX-License-Identifier: Apache-2.0
// A Vulkan instance of our own, the messages of its validation layer, and the errors of Vulkan's calls.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "vulkan/functions.hpp"
#include "vulkan/handle.hpp"

namespace gnosphere::vulkan {

/// Returns the name of a VkResult, such as "VK_ERROR_DEVICE_LOST".
const char* resultName(VkResult result);

/// Throws Error with the call, the name of its result and the place, which is that of the caller: clang 14 has no
/// std::source_location. Callers use the macro VK().
void check(VkResult result, const char* call, const char* file = __builtin_FILE(), uint32_t line = __builtin_LINE());
#define VK(call) ::gnosphere::vulkan::check(call, #call)

/// Collects the messages of the validation layer.
class Messages {
 public:
  void add(const char* text);
  /// Throws Error(device) with the messages since the last call, if there are any.
  void throwIfAny();

 private:
  std::mutex mutex_;
  std::vector<std::string> texts_;
};

/// A Vulkan instance, with the validation layer if requested.
class ApiInstance {
 public:
  explicit ApiInstance(bool validation);

  VkInstance handle() const { return instance_.get(); }
  const InstanceFunctions& functions() const { return functions_; }
  std::vector<VkPhysicalDevice> physicalDevices() const;
  void throwOnMessages() { messages_->throwIfAny(); }
  /// Shared, so that a caller can still read messages about the destruction of the instance and its devices.
  const std::shared_ptr<Messages>& messages() const { return messages_; }

 private:
  std::shared_ptr<Messages> messages_ = std::make_shared<Messages>();
  InstanceFunctions functions_;
  Handle<VkInstance> instance_;
  Handle<VkDebugUtilsMessengerEXT, VkInstance> messenger_;
};

}  // namespace gnosphere::vulkan
