// SPDX-License-Identifier: Apache-2.0
// Owning handle of a Vulkan object.
#pragma once

#include <vulkan/vulkan_core.h>

#include <atomic>
#include <tuple>
#include <utility>

namespace gnosphere::vulkan {

/// Counts the submissions of a device that it has not ended in the time that they may take. While there are any it may
/// use every object that it has, so none of them may be destroyed.
using HangCount = std::atomic<int>;

/// Owns a Vulkan object and destroys it in the destructor. `Owner` is VkDevice or VkInstance, and empty for handles of
/// these two types. An object whose device hangs at that time is left as it is until the process ends.
template <typename T, typename... Owner>
class Handle {
 public:
  using Destroy = void(VKAPI_PTR*)(Owner..., T, const VkAllocationCallbacks*);

  Handle() = default;
  /// `hangs` belongs to the device and must outlive the handle; null for objects of an instance.
  Handle(T object, Destroy destroy, Owner... owner, const HangCount* hangs)
      : object_(object), destroy_(destroy), owner_(owner...), hangs_(hangs) {}
  ~Handle() {
    if (object_ && !(hangs_ && *hangs_ > 0))
      std::apply([&](Owner... owner) { destroy_(owner..., object_, nullptr); }, owner_);
  }
  Handle(Handle&& other) noexcept { swap(other); }
  Handle& operator=(Handle&& other) noexcept {
    Handle(std::move(other)).swap(*this);
    return *this;
  }

  T get() const { return object_; }
  explicit operator bool() const { return object_ != VK_NULL_HANDLE; }

 private:
  void swap(Handle& other) noexcept {
    std::swap(object_, other.object_);
    std::swap(destroy_, other.destroy_);
    std::swap(owner_, other.owner_);
    std::swap(hangs_, other.hangs_);
  }

  T object_ = VK_NULL_HANDLE;
  Destroy destroy_ = nullptr;
  std::tuple<Owner...> owner_;
  const HangCount* hangs_ = nullptr;
};

template <typename T>
using DeviceHandle = Handle<T, VkDevice>;

}  // namespace gnosphere::vulkan
