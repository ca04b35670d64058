// SPDX-License-Identifier: Apache-2.0
#include "output/canvas.hpp"

#include <stb_easy_font.h>
#include <stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/file.hpp"
#include "base/text.hpp"
#include "gnosphere/error.hpp"
#include "output/picture_file.hpp"

namespace gnosphere {
namespace {

uint8_t toByte(float value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255));
}

constexpr int kScale = 2;  // pixels of a dot of a letter

}  // namespace

Colour turbo(float t) {
  const float x = std::clamp(t, 0.0f, 1.0f);
  const auto polynomial = [&](const std::array<float, 6>& c) {
    return std::clamp(c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5])))), 0.0f, 1.0f);
  };
  return {polynomial({0.13572138f, 4.61539260f, -42.66032258f, 132.13108234f, -152.94239396f, 59.28637943f}),
          polynomial({0.09140261f, 2.19418839f, 4.84296658f, -14.18503333f, 4.27729857f, 2.82956604f}),
          polynomial({0.10667330f, 12.64194608f, -60.58204836f, 110.36276771f, -89.90310912f, 27.34824973f})};
}

Canvas::Canvas(int width, int height, const Colour& background) : width_(width), height_(height) {
  pixels_.resize(static_cast<size_t>(width) * static_cast<size_t>(height) * 3);
  fill(0, 0, width, height, background);
}

void Canvas::blend(int x, int y, const Colour& colour, float alpha) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  uint8_t* p = &pixels_[(static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)) * 3];
  const auto mix = [&](uint8_t below, float above) {
    return toByte(static_cast<float>(below) / 255 * (1 - alpha) + above * alpha);
  };
  p[0] = mix(p[0], colour.r);
  p[1] = mix(p[1], colour.g);
  p[2] = mix(p[2], colour.b);
}

void Canvas::fill(int x, int y, int w, int h, const Colour& colour) {
  for (int j = y; j < y + h; ++j) {
    for (int i = x; i < x + w; ++i) blend(i, j, colour);
  }
}

void Canvas::circle(float x, float y, float radius, const Colour& colour, float alpha) {
  // The line has one soft pixel on either side. Only the ring itself is visited, row by row.
  const int last = static_cast<int>(y + radius + 2);
  for (int j = static_cast<int>(y - radius - 2); j <= last; ++j) {
    const float dy = static_cast<float>(j) - y;
    const float outer = (radius + 1) * (radius + 1) - dy * dy;
    if (outer < 0) continue;
    const float inner = (radius - 1) * (radius - 1) - dy * dy;
    const float far = std::sqrt(outer), near = inner > 0 && radius > 1 ? std::sqrt(inner) : 0;
    const auto span = [&](int from, int to) {
      for (int i = from; i <= to; ++i) {
        const float off = std::abs(std::hypot(static_cast<float>(i) - x, dy) - radius);
        if (off < 1) blend(i, j, colour, alpha * (1 - off));
      }
    };
    const int middle = static_cast<int>(x - near);
    span(static_cast<int>(x - far), middle);
    span(std::max(middle + 1, static_cast<int>(x + near)), static_cast<int>(x + far) + 1);
  }
}

void Canvas::text(int x, int y, const std::string& text, const Colour& colour) {
  struct Vertex {
    float x, y, z;
    uint8_t colour[4];
  };
  std::string copy = plainAscii(text);
  std::vector<Vertex> corners(copy.size() * 68 + 4);
  const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, corners.data(),
                                        static_cast<int>(corners.size() * sizeof(Vertex)));
  for (int q = 0; q < quads; ++q) {
    const Vertex& a = corners[static_cast<size_t>(q) * 4];
    const Vertex& c = corners[static_cast<size_t>(q) * 4 + 2];
    const auto at = [&](float v) { return static_cast<int>(std::lround(v)) * kScale; };
    fill(x + at(a.x), y + at(a.y), at(c.x) - at(a.x), at(c.y) - at(a.y), colour);
  }
}

int Canvas::textWidth(const std::string& text) {
  std::string copy = plainAscii(text);
  return stb_easy_font_width(copy.data()) * kScale;
}

void Canvas::writePng(const std::filesystem::path& file) const {
  checkPictureFile(file);
  AtomicFile out(file);
  std::string bytes;
  const auto append = [](void* to, void* data, int size) {
    static_cast<std::string*>(to)->append(static_cast<const char*>(data), static_cast<size_t>(size));
  };
  if (!stbi_write_png_to_func(append, &bytes, width_, height_, 3, pixels_.data(), width_ * 3)) {
    throw Error(ErrorCode::outOfMemory, file.string() + ": no memory to compress the picture");
  }
  out.write(bytes);
  out.commit();
}

}  // namespace gnosphere
