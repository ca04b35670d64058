// SPDX-License-Identifier: Apache-2.0
#include "images.hpp"

#include <algorithm>

namespace viewer {
namespace {

constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

VkImageView viewOf(VkDevice device, VkImage image, VkFormat format, VkImageAspectFlags aspect) {
  VkImageViewCreateInfo create = {VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  create.image = image;
  create.viewType = VK_IMAGE_VIEW_TYPE_2D;
  create.format = format;
  create.subresourceRange = {aspect, 0, 1, 0, 1};
  VkImageView view;
  require(vkCreateImageView(device, &create, nullptr, &view), "vkCreateImageView");
  return view;
}

}  // namespace

Images::Images(const Device& on, VkExtent2D extent, VkRenderPass pass, VkSurfaceFormatKHR format)
    : size(extent), on_(on) {
  VkSurfaceCapabilitiesKHR surface;
  require(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(on.physical, on.surface, &surface), "the window's capabilities");
  if (surface.currentExtent.width != UINT32_MAX) size = surface.currentExtent;
  readable = surface.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  VkSwapchainCreateInfoKHR create = {VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
  create.surface = on.surface;
  create.minImageCount = std::max(surface.minImageCount, 3u);
  if (surface.maxImageCount > 0) create.minImageCount = std::min(create.minImageCount, surface.maxImageCount);
  create.imageFormat = format.format;
  create.imageColorSpace = format.colorSpace;
  create.imageExtent = size;
  create.imageArrayLayers = 1;
  create.imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | (readable ? VK_IMAGE_USAGE_TRANSFER_SRC_BIT : 0);
  create.preTransform = surface.currentTransform;
  create.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
  create.presentMode = VK_PRESENT_MODE_FIFO_KHR;
  create.clipped = VK_TRUE;
  require(vkCreateSwapchainKHR(on.device, &create, nullptr, &swapchain), "vkCreateSwapchainKHR");
  uint32_t count = 0;
  vkGetSwapchainImagesKHR(on.device, swapchain, &count, nullptr);
  images.resize(count);
  vkGetSwapchainImagesKHR(on.device, swapchain, &count, images.data());
  createDepth();
  for (VkImage image : images) {
    views_.push_back(viewOf(on.device, image, format.format, VK_IMAGE_ASPECT_COLOR_BIT));
    const VkImageView attachments[] = {views_.back(), depthView_};
    VkFramebufferCreateInfo frame = {VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO, nullptr, 0, pass, 2, attachments};
    frame.width = size.width;
    frame.height = size.height;
    frame.layers = 1;
    require(vkCreateFramebuffer(on.device, &frame, nullptr, &framebuffers.emplace_back()), "vkCreateFramebuffer");
    const VkSemaphoreCreateInfo semaphore = {VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    require(vkCreateSemaphore(on.device, &semaphore, nullptr, &drawn.emplace_back()), "vkCreateSemaphore");
  }
}

void Images::createDepth() {
  VkImageCreateInfo create = {VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  create.imageType = VK_IMAGE_TYPE_2D;
  create.format = kDepthFormat;
  create.extent = {size.width, size.height, 1};
  create.mipLevels = create.arrayLayers = 1;
  create.samples = VK_SAMPLE_COUNT_1_BIT;
  create.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  require(vkCreateImage(on_.device, &create, nullptr, &depth_), "vkCreateImage");
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(on_.device, depth_, &needs);
  VkMemoryAllocateInfo allocate = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size};
  allocate.memoryTypeIndex = on_.memoryType(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  require(vkAllocateMemory(on_.device, &allocate, nullptr, &depthMemory_), "vkAllocateMemory");
  require(vkBindImageMemory(on_.device, depth_, depthMemory_, 0), "vkBindImageMemory");
  depthView_ = viewOf(on_.device, depth_, kDepthFormat, VK_IMAGE_ASPECT_DEPTH_BIT);
}

Images::~Images() {
  for (VkSemaphore each : drawn) vkDestroySemaphore(on_.device, each, nullptr);
  for (VkFramebuffer each : framebuffers) vkDestroyFramebuffer(on_.device, each, nullptr);
  for (VkImageView each : views_) vkDestroyImageView(on_.device, each, nullptr);
  vkDestroyImageView(on_.device, depthView_, nullptr);
  vkDestroyImage(on_.device, depth_, nullptr);
  vkFreeMemory(on_.device, depthMemory_, nullptr);
  vkDestroySwapchainKHR(on_.device, swapchain, nullptr);
}

}  // namespace viewer
