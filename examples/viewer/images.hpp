// SPDX-License-Identifier: Apache-2.0
// The images of the window.
#pragma once

#include <vector>

#include "device.hpp"

namespace viewer {

/// The images of a window of one size, with a depth buffer.
class Images {
 public:
  Images(const Device& on, VkExtent2D size, VkRenderPass pass, VkSurfaceFormatKHR format);
  ~Images();
  Images(const Images&) = delete;
  Images& operator=(const Images&) = delete;

  VkExtent2D size;
  VkSwapchainKHR swapchain = VK_NULL_HANDLE;
  bool readable = false;  ///< images can be copied from
  std::vector<VkImage> images;
  std::vector<VkFramebuffer> framebuffers;
  std::vector<VkSemaphore> drawn;  ///< per image: its drawing has ended

 private:
  void createDepth();

  const Device& on_;
  std::vector<VkImageView> views_;
  VkImage depth_ = VK_NULL_HANDLE;
  VkDeviceMemory depthMemory_ = VK_NULL_HANDLE;
  VkImageView depthView_ = VK_NULL_HANDLE;
};

}  // namespace viewer
