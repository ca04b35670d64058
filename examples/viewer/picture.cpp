// SPDX-License-Identifier: Apache-2.0
#include "picture.hpp"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb_image_write.h>

#include <fstream>
#include <stdexcept>
#include <utility>

namespace viewer {

Picture::Picture(const Device& on, const Frames& frames, const Frames::Frame& frame)
    : size_(frames.size()),
      blueFirst_(frames.blueFirst()),
      bytes_(on, VkDeviceSize{4} * size_.width * size_.height, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Buffer::Memory::host) {
  frames.copyImage(frame, bytes_);
}

void Picture::write(const std::string& file) const {
  const auto* from = static_cast<const uint8_t*>(bytes_.mapped);
  std::vector<uint8_t> pixels;
  for (size_t i = 0; i < size_t{size_.width} * size_.height; ++i, from += 4) {
    pixels.insert(pixels.end(), {from[0], from[1], from[2]});
    if (blueFirst_) std::swap(pixels[3 * i], pixels[3 * i + 2]);
  }
  const int width = static_cast<int>(size_.width), height = static_cast<int>(size_.height);
  bool written;
  if (file.ends_with(".png")) {
    written = stbi_write_png(file.c_str(), width, height, 3, pixels.data(), 3 * width) != 0;
  } else {
    std::ofstream out(file, std::ios::binary);
    out << "P6\n" << width << ' ' << height << "\n255\n";
    out.write(reinterpret_cast<const char*>(pixels.data()), static_cast<std::streamsize>(pixels.size()));
    written = static_cast<bool>(out.flush());
  }
  if (!written) throw std::runtime_error("cannot write the picture " + file);
}

}  // namespace viewer
