// SPDX-License-Identifier: Apache-2.0
// Elements of SVG that the plots share.
#pragma once

#include <string>
#include <vector>

#include "console.hpp"

namespace gnosphere::cli {

inline constexpr double kNoteLine = 14;  ///< pixels from one note under the title to the next

/// Escapes text for XML; control characters, which XML does not allow, are left out.
inline std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (static_cast<unsigned char>(c) < 0x20) continue;
    out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  }
  return out;
}

inline std::string textAt(double x, double y, const char* anchor, const std::string& markup, const char* more = "") {
  return formatted("<text x='%.1f' y='%.1f' text-anchor='%s'%s>", x, y, anchor, more) + markup + "</text>\n";
}

inline std::string lineFrom(double x1, double y1, double x2, double y2, const char* style) {
  return formatted("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' %s/>\n", x1, y1, x2, y2, style);
}

/// Returns the beginning of a picture: its size, its background, its title and the notes under it.
inline std::string svgHead(double width, double height, const std::string& title,
                           const std::vector<std::string>& notes) {
  std::string out = formatted(
      "<svg xmlns='http://www.w3.org/2000/svg' width='%.0f' height='%.0f' viewBox='0 0 %.0f %.0f' "
      "font-family='sans-serif' font-size='11' fill='#222222'>\n<rect width='%.0f' height='%.0f' fill='white'/>\n",
      width, height, width, height, width, height);
  out += textAt(18, 24, "start", escaped(title), " font-size='15' font-weight='bold'");
  for (size_t i = 0; i < notes.size(); ++i)
    out += textAt(18, 42 + kNoteLine * static_cast<double>(i), "start", escaped(notes[i]), " fill='#555555'");
  return out;
}

}  // namespace gnosphere::cli
