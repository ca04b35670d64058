// SPDX-License-Identifier: Apache-2.0
// The frames in flight, which draw into the images of the window.
#pragma once

#include <array>
#include <memory>

#include "images.hpp"

namespace viewer {

inline constexpr uint32_t kFramesInFlight = 2;

/// Command buffers and images in turn.
class Frames {
 public:
  struct Frame {
    VkCommandBuffer commands;
    uint32_t number;  ///< of the frame in flight
    uint32_t image;
  };

  Frames(const Device& on, GLFWwindow* window);
  ~Frames();
  Frames(const Frames&) = delete;
  Frames& operator=(const Frames&) = delete;

  /// Waits until the commands that were recorded with this frame's number before have ended, and begins new ones.
  Frame begin();
  void beginPass(const Frame& frame) const;
  /// After the pass, appends a copy of the frame's image to the buffer: 4 bytes per pixel, row by row.
  void copyImage(const Frame& frame, const Buffer& to) const;
  /// Submits the commands and shows the image.
  void end(const Frame& frame);

  VkExtent2D size() const { return images_->size; }
  bool blueFirst() const;  ///< the order of the bytes in a pixel: blue, green, red rather than red, green, blue
  VkRenderPass pass() const { return pass_; }

 private:
  struct Flight {
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkSemaphore acquired = VK_NULL_HANDLE;
    VkFence ended = VK_NULL_HANDLE;
  };

  void createPass();
  void createImages();

  const Device& on_;
  GLFWwindow* window_;
  VkSurfaceFormatKHR format_ = {};
  VkRenderPass pass_ = VK_NULL_HANDLE;
  std::unique_ptr<Images> images_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  std::array<Flight, kFramesInFlight> flights_;
  uint32_t next_ = 0;
};

}  // namespace viewer
