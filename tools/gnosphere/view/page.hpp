// SPDX-License-Identifier: Apache-2.0
// One HTML page with clouds, three.js and a script that draws them; it needs no other file and no network.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "view/cloud.hpp"

namespace gnosphere::cli {

struct PageFrame {
  std::string name;
  ViewCloud cloud;
  nlohmann::ordered_json boxes = nlohmann::ordered_json::array();
};

/// A field of the page, and how its values are stored.
struct PageField {
  std::string name;
  bool isId = false;
  double min = 0, max = 0;  ///< of all frames
  ValueNames names;
  size_t bytes() const;  ///< of a value
};

/// The page's data are a JSON head and, for each frame, base64 of little-endian arrays one after the other:
/// - x, y, z as 16-bit numbers of steps from the frame's origin; the script takes them from the head's origin, which is
///   that of all clouds;
/// - for each field in turn, ids as numbers of 8, 16 or 32 bits, and others as 16-bit numbers from 0 for the field's
///   least value to 65534 for its greatest. All bits set: the point has no value.
class Page {
 public:
  /// All clouds of a page have one origin.
  void add(PageFrame frame);
  size_t frameCount() const { return frames_.size(); }
  uint64_t pointCount() const { return points_; }
  /// The fields that a page can colour by; it computes z, and range where no cloud has it.
  std::vector<std::string> fieldNames() const;
  /// Bytes of the clouds in the page.
  uint64_t dataBytes() const;
  /// `head` has the members `title`, `notes` (lines of text), `every` and `colour` (the field to begin with, or empty).
  /// `three` is three.js with its OrbitControls.
  std::string html(nlohmann::ordered_json head, const std::string& three) const;

 private:
  std::string encode(const PageFrame& frame, nlohmann::ordered_json& head) const;

  std::vector<PageFrame> frames_;
  std::vector<PageField> fields_;
  uint64_t points_ = 0;
};

}  // namespace gnosphere::cli
