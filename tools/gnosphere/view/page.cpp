// SPDX-License-Identifier: Apache-2.0
#include "view/page.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/json_text.hpp"
#include "view_page.h"

namespace gnosphere::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

void put(std::string& out, uint32_t value, size_t bytes) {
  for (size_t k = 0; k < bytes; ++k) out += static_cast<char>(value >> (8 * k));
}

/// JSON inside a script element must not contain what ends the element.
std::string scriptText(const Json& json) {
  std::string text;
  for (char c : jsonText(json)) c == '<' ? text += "\\u003c" : text += c;
  return text;
}

constexpr uint32_t kSteps = 65535;

}  // namespace

size_t PageField::bytes() const {
  if (!isId) return 2;
  return max < 0xff ? 1 : max < 0xffff ? 2 : 4;
}

void Page::add(PageFrame frame) {
  points_ += frame.cloud.size();
  for (const ViewColumn& column : frame.cloud.columns) {
    auto field = std::find_if(fields_.begin(), fields_.end(), [&](const auto& f) { return f.name == column.name; });
    if (field == fields_.end()) {
      fields_.push_back({column.name, column.isId, INFINITY, -INFINITY, {}});
      field = fields_.end() - 1;
    }
    field->isId = field->isId && column.isId;
    field->names.insert(column.names.begin(), column.names.end());
    for (double value : column.values) {
      if (std::isnan(value)) continue;
      field->min = std::min(field->min, value);
      field->max = std::max(field->max, value);
    }
  }
  frames_.push_back(std::move(frame));
}

std::vector<std::string> Page::fieldNames() const {
  std::vector<std::string> names;
  for (const PageField& field : fields_) names.push_back(field.name);
  for (const char* computed : {"range", "z"})
    if (std::find(names.begin(), names.end(), computed) == names.end()) names.push_back(computed);
  return names;
}

uint64_t Page::dataBytes() const {
  size_t bytes = 3 * sizeof(uint16_t);
  for (const PageField& field : fields_) bytes += field.bytes();
  return points_ * bytes * 4 / 3;
}

std::string Page::encode(const PageFrame& frame, Json& head) const {
  const ViewCloud& cloud = frame.cloud;
  std::string bytes;
  Origin origin = {};
  double extent = 0;
  for (size_t axis = 0; axis < 3 && cloud.size() > 0; ++axis) {
    double least = INFINITY, greatest = -INFINITY;
    for (size_t i = axis; i < cloud.points.size(); i += 3) {
      least = std::min<double>(least, cloud.points[i]);
      greatest = std::max<double>(greatest, cloud.points[i]);
    }
    origin[axis] = least;
    extent = std::max(extent, greatest - least);
  }
  const double step = extent > 0 ? extent / kSteps : 1e-6;
  for (size_t axis = 0; axis < 3; ++axis)
    for (size_t i = axis; i < cloud.points.size(); i += 3)
      put(bytes, static_cast<uint32_t>(std::lround((cloud.points[i] - origin[axis]) / step)), 2);
  for (size_t axis = 0; axis < 3; ++axis) origin[axis] += cloud.origin[axis];
  for (const PageField& field : fields_) {
    const ViewColumn* column = cloud.find(field.name);
    const double scale = field.max > field.min ? (kSteps - 1) / (field.max - field.min) : 0;
    for (size_t i = 0; i < cloud.size(); ++i) {
      const double value = column ? column->values[i] : NAN;
      const uint32_t code = std::isnan(value) ? UINT32_MAX
                            : field.isId      ? static_cast<uint32_t>(value)
                                              : static_cast<uint32_t>(std::lround((value - field.min) * scale));
      put(bytes, code, field.bytes());
    }
  }
  head = {{"name", frame.name}, {"points", cloud.size()}, {"misses", cloud.misses},
          {"origin", origin},   {"step", step},           {"boxes", frame.boxes}};
  return base64(bytes);
}

std::string Page::html(Json head, const std::string& three) const {
  Json fields = Json::array(), frames = Json::array();
  for (const PageField& field : fields_) {
    Json names = Json::object();
    for (const auto& [id, name] : field.names) names[std::to_string(id)] = name;
    const bool any = field.min <= field.max;
    fields.push_back({{"name", field.name},
                      {"id", field.isId},
                      {"bytes", field.bytes()},
                      {"min", any ? field.min : 0},
                      {"max", any ? field.max : 0},
                      {"names", names}});
  }
  std::string data;
  for (size_t i = 0; i < frames_.size(); ++i) {
    Json entry;
    data += "<script type=\"text/plain\" id=\"frame" + std::to_string(i) + "\">" + encode(frames_[i], entry) +
            "</script>\n";
    frames.push_back(std::move(entry));
  }
  head["fields"] = std::move(fields);
  head["frames"] = std::move(frames);
  head["origin"] = frames_.empty() ? Origin{} : frames_[0].cloud.origin;
  data = "<script type=\"application/json\" id=\"head\">" + scriptText(head) + "</script>\n" + data;
  const std::string page = kPageHtml, mark = "<!-- content -->";
  const size_t at = page.find(mark);
  return page.substr(0, at) + data + "<script>\n" + three + "</script>\n<script>\n" + kPageScript + "</script>\n" +
         page.substr(at + mark.size());
}

}  // namespace gnosphere::cli
