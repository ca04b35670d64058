// SPDX-License-Identifier: Apache-2.0
#include "frames.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <stdexcept>

namespace viewer {
namespace {

constexpr VkClearColorValue kSky = {{0.012f, 0.016f, 0.026f, 1}};

VkSurfaceFormatKHR formatOf(const Device& on) {
  uint32_t count = 0;
  vkGetPhysicalDeviceSurfaceFormatsKHR(on.physical, on.surface, &count, nullptr);
  std::vector<VkSurfaceFormatKHR> formats(count);
  vkGetPhysicalDeviceSurfaceFormatsKHR(on.physical, on.surface, &count, formats.data());
  for (const VkSurfaceFormatKHR& each : formats)
    if (each.format == VK_FORMAT_B8G8R8A8_SRGB || each.format == VK_FORMAT_R8G8B8A8_SRGB) return each;
  throw std::runtime_error("the window has no format of 8-bit sRGB colours");
}

}  // namespace

Frames::Frames(const Device& on, GLFWwindow* window) : on_(on), window_(window), format_(formatOf(on)) {
  createPass();
  createImages();
  VkCommandPoolCreateInfo pools = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pools.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pools.queueFamilyIndex = on.family;
  require(vkCreateCommandPool(on.device, &pools, nullptr, &pool_), "vkCreateCommandPool");
  for (Flight& flight : flights_) {
    const VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool_,
                                                  VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    require(vkAllocateCommandBuffers(on.device, &allocate, &flight.commands), "vkAllocateCommandBuffers");
    const VkSemaphoreCreateInfo semaphore = {VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    require(vkCreateSemaphore(on.device, &semaphore, nullptr, &flight.acquired), "vkCreateSemaphore");
    const VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, VK_FENCE_CREATE_SIGNALED_BIT};
    require(vkCreateFence(on.device, &fence, nullptr, &flight.ended), "vkCreateFence");
  }
}

Frames::~Frames() {
  vkDeviceWaitIdle(on_.device);
  for (const Flight& flight : flights_) {
    vkDestroyFence(on_.device, flight.ended, nullptr);
    vkDestroySemaphore(on_.device, flight.acquired, nullptr);
  }
  vkDestroyCommandPool(on_.device, pool_, nullptr);
  images_.reset();
  vkDestroyRenderPass(on_.device, pass_, nullptr);
}

void Frames::createPass() {
  const VkAttachmentDescription attachments[] = {
      {0, format_.format, VK_SAMPLE_COUNT_1_BIT, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_STORE,
       VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
       VK_IMAGE_LAYOUT_PRESENT_SRC_KHR},
      {0, VK_FORMAT_D32_SFLOAT, VK_SAMPLE_COUNT_1_BIT, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_DONT_CARE,
       VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
       VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL}};
  const VkAttachmentReference colour = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  const VkAttachmentReference depth = {1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass = {};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &colour;
  subpass.pDepthStencilAttachment = &depth;
  // The frame before has ended with the depth buffer, and the image has come from the window. After the pass the image
  // may be copied.
  constexpr VkPipelineStageFlags kDepth =
      VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
  constexpr VkPipelineStageFlags kColour = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  constexpr VkAccessFlags kDepthAccess =
      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  const VkSubpassDependency dependencies[] = {
      {VK_SUBPASS_EXTERNAL, 0, kDepth | kColour, kDepth | kColour, VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
       kDepthAccess | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, 0},
      {0, VK_SUBPASS_EXTERNAL, kColour, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
       VK_ACCESS_TRANSFER_READ_BIT, 0}};
  VkRenderPassCreateInfo create = {VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  create.attachmentCount = 2;
  create.pAttachments = attachments;
  create.subpassCount = 1;
  create.pSubpasses = &subpass;
  create.dependencyCount = 2;
  create.pDependencies = dependencies;
  require(vkCreateRenderPass(on_.device, &create, nullptr, &pass_), "vkCreateRenderPass");
}

void Frames::createImages() {
  int width = 0, height = 0;
  for (glfwGetFramebufferSize(window_, &width, &height); width == 0 || height == 0;
       glfwGetFramebufferSize(window_, &width, &height))
    glfwWaitEvents();  // the window is minimised
  vkDeviceWaitIdle(on_.device);
  images_.reset();
  const VkExtent2D size = {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
  images_ = std::make_unique<Images>(on_, size, pass_, format_);
}

Frames::Frame Frames::begin() {
  const uint32_t number = next_;
  next_ = (next_ + 1) % kFramesInFlight;
  const Flight& flight = flights_[number];
  require(vkWaitForFences(on_.device, 1, &flight.ended, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  uint32_t image = 0;
  VkResult acquired;
  while ((acquired = vkAcquireNextImageKHR(on_.device, images_->swapchain, UINT64_MAX, flight.acquired, VK_NULL_HANDLE,
                                           &image)) == VK_ERROR_OUT_OF_DATE_KHR)
    createImages();
  if (acquired != VK_SUBOPTIMAL_KHR) require(acquired, "vkAcquireNextImageKHR");
  require(vkResetFences(on_.device, 1, &flight.ended), "vkResetFences");
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  require(vkBeginCommandBuffer(flight.commands, &begin), "vkBeginCommandBuffer");
  return {flight.commands, number, image};
}

void Frames::beginPass(const Frame& frame) const {
  VkClearValue clear[2] = {};
  clear[0].color = kSky;
  clear[1].depthStencil.depth = 1;
  VkRenderPassBeginInfo begin = {VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO, nullptr, pass_,
                                 images_->framebuffers[frame.image]};
  begin.renderArea.extent = size();
  begin.clearValueCount = 2;
  begin.pClearValues = clear;
  vkCmdBeginRenderPass(frame.commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
  const VkViewport viewport = {0, 0, static_cast<float>(size().width), static_cast<float>(size().height), 0, 1};
  const VkRect2D scissor = {{0, 0}, size()};
  vkCmdSetViewport(frame.commands, 0, 1, &viewport);
  vkCmdSetScissor(frame.commands, 0, 1, &scissor);
}

bool Frames::blueFirst() const {
  return format_.format == VK_FORMAT_B8G8R8A8_SRGB;
}

void Frames::copyImage(const Frame& frame, const Buffer& to) const {
  if (!images_->readable) throw std::runtime_error("the window's images cannot be read, so there is no picture");
  VkImageMemoryBarrier image = {VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
  image.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;  // the pass has made the colours available to transfers
  image.oldLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
  image.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
  image.srcQueueFamilyIndex = image.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  image.image = images_->images[frame.image];
  image.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  vkCmdPipelineBarrier(frame.commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0,
                       nullptr, 1, &image);
  VkBufferImageCopy copy = {};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  copy.imageExtent = {size().width, size().height, 1};
  vkCmdCopyImageToBuffer(frame.commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.buffer, 1, &copy);
  std::swap(image.oldLayout, image.newLayout);
  image.dstAccessMask = 0;
  const VkMemoryBarrier toHost = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_TRANSFER_WRITE_BIT,
                                  VK_ACCESS_HOST_READ_BIT};
  vkCmdPipelineBarrier(frame.commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_PIPELINE_STAGE_HOST_BIT | VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, 0, 1, &toHost, 0, nullptr, 1,
                       &image);
}

void Frames::end(const Frame& frame) {
  const Flight& flight = flights_[frame.number];
  require(vkEndCommandBuffer(frame.commands), "vkEndCommandBuffer");
  const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO, nullptr, 1, &flight.acquired, &stage, 1, &frame.commands};
  submit.signalSemaphoreCount = 1;
  submit.pSignalSemaphores = &images_->drawn[frame.image];
  require(vkQueueSubmit(on_.queue, 1, &submit, flight.ended), "vkQueueSubmit");
  const VkPresentInfoKHR present = {VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                    nullptr,
                                    1,
                                    &images_->drawn[frame.image],
                                    1,
                                    &images_->swapchain,
                                    &frame.image};
  const VkResult shown = vkQueuePresentKHR(on_.queue, &present);
  if (shown == VK_ERROR_OUT_OF_DATE_KHR || shown == VK_SUBOPTIMAL_KHR)
    createImages();
  else
    require(shown, "vkQueuePresentKHR");
}

}  // namespace viewer
