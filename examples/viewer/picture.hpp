// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "frames.hpp"

namespace viewer {

/// A copy of a frame's image in host memory.
class Picture {
 public:
  /// Records the copy, after the pass and before the end of the frame.
  Picture(const Device& on, const Frames& frames, const Frames::Frame& frame);

  /// Writes a .png or .ppm file, once the commands of the frame have ended. Throws if the file cannot be written.
  void write(const std::string& file) const;

 private:
  VkExtent2D size_;
  bool blueFirst_;
  Buffer bytes_;
};

}  // namespace viewer
