// SPDX-License-Identifier: Apache-2.0
// Owning handle of a Vulkan object.
#pragma once

#include <vulkan/vulkan_core.h>

#include <tuple>
#include <utility>

namespace gnosphere::vulkan {

/// Owns a Vulkan object and destroys it in the destructor. `Owner` is VkDevice or VkInstance, and empty for handles of
/// these two types.
template <typename T, typename... Owner>
class Handle {
 public:
  using Destroy = void(VKAPI_PTR*)(Owner..., T, const VkAllocationCallbacks*);

  Handle() = default;
  Handle(T object, Destroy destroy, Owner... owner) : object_(object), destroy_(destroy), owner_(owner...) {}
  ~Handle() {
    if (object_) std::apply([&](Owner... owner) { destroy_(owner..., object_, nullptr); }, owner_);
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
  }

  T object_ = VK_NULL_HANDLE;
  Destroy destroy_ = nullptr;
  std::tuple<Owner...> owner_;
};

template <typename T>
using DeviceHandle = Handle<T, VkDevice>;

}  // namespace gnosphere::vulkan
