// SPDX-License-Identifier: Apache-2.0
// An image to draw on, and the colours of the pictures.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace gnosphere {

struct Colour {
  float r = 0, g = 0, b = 0;  ///< 0..1, as displayed (sRGB)
};

inline Colour operator*(const Colour& c, float s) {
  return {c.r * s, c.g * s, c.b * s};
}
inline Colour operator+(const Colour& a, const Colour& b) {
  return {a.r + b.r, a.g + b.g, a.b + b.b};
}

inline constexpr Colour kBackground = {0.043f, 0.051f, 0.067f}, kText = {0.78f, 0.81f, 0.86f};

/// Colour map Turbo (Anton Mikhailov 2019) for 0..1, blue over green to red, in the polynomial form published with it.
Colour turbo(float t);

/// An RGB image whose row 0 is the top. Drawing outside the image is clipped.
class Canvas {
 public:
  Canvas(int width, int height, const Colour& background);
  int width() const { return width_; }
  int height() const { return height_; }
  void blend(int x, int y, const Colour& colour, float alpha = 1);
  void fill(int x, int y, int w, int h, const Colour& colour);
  void circle(float x, float y, float radius, const Colour& colour, float alpha);
  /// `y` is the top of the letters; they are 14 pixels high. The font has printable ASCII alone; a question mark stands
  /// for every other byte.
  void text(int x, int y, const std::string& text, const Colour& colour);
  static int textWidth(const std::string& text);
  /// Throws Error(invalidArgument) unless the name ends in .png, and Error(file) if the picture cannot be written.
  void writePng(const std::filesystem::path& file) const;

 private:
  int width_, height_;
  std::vector<uint8_t> pixels_;
};

}  // namespace gnosphere
