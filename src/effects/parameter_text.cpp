// SPDX-License-Identifier: Apache-2.0
#include "effects/parameter_text.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <system_error>

#include "base/decimal_point.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

using nlohmann::json;

void refuseArgument(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, why);
}

std::string rangeText(double min, double max, bool endsOnly, const char* unit) {
  const DecimalPoint point;
  char buffer[80];
  const int length = std::snprintf(buffer, sizeof(buffer), "%.10g%s%.10g", min, endsOnly ? " or " : "..", max);
  return std::string(buffer, static_cast<size_t>(length)) + (*unit ? " " : "") + unit;
}

std::string listed(const std::vector<ChoiceWord>& words) {
  std::string list = words.front().name;
  for (size_t i = 1; i < words.size(); ++i) list.append(i + 1 < words.size() ? ", " : " or ").append(words[i].name);
  return list;
}

std::string quoted(const char* word) {
  return std::string("\"").append(word).append("\"");
}

void checkSize(double value, const std::string& what) {
  if (value != 0 && std::abs(value) < kLeastSize)
    refuseArgument(what + " must be 0 or at least " + numberText(kLeastSize) + " in size, is " + numberText(value));
}

double numberOf(const json& value, const std::string& what, const std::string& allowed) {
  if (!value.is_number()) refuseArgument(what + " must be " + allowed + ", is " + shown(value));
  return value.get<double>();
}

uint64_t wholeNumberOf(const json& value, uint64_t max, const std::string& what, const std::string& allowed) {
  if (!value.is_number_unsigned() || value.get<uint64_t>() > max)
    refuseArgument(what + " must be " + allowed + ", is " + shown(value));
  return value.get<uint64_t>();
}

namespace {

Vec3 cornerOf(const json& box, const char* key, const std::string& what) {
  const auto found = box.find(key);
  if (found == box.end() || !found->is_array() || found->size() != 3)
    refuseArgument(what + ": '" + key + "' must be [x, y, z], three numbers of metres");
  const std::string name = what + "." + key;
  return {numberOf((*found)[0], name, "three numbers"), numberOf((*found)[1], name, "three numbers"),
          numberOf((*found)[2], name, "three numbers")};
}

Effects::Volume volumeOf(const json& box, const std::string& what) {
  if (!box.is_object()) refuseArgument(what + " must be {\"min\": [x, y, z], \"max\": [x, y, z], \"extinction\": 1/m}");
  for (const auto& [key, value] : box.items())
    if (key != "min" && key != "max" && key != "extinction")
      refuseArgument(what + ": unknown key '" + key + "'; known are min, max, extinction");
  Effects::Volume volume = {cornerOf(box, "min", what), cornerOf(box, "max", what)};
  if (!box.contains("extinction")) refuseArgument(what + ": 'extinction' is missing");
  volume.extinction = numberOf(box["extinction"], what + ".extinction", "a number of 1/m");
  return volume;
}

std::string vectorText(const Vec3& v) {
  return std::string("[").append(numberText(v.x) + ", " + numberText(v.y) + ", " + numberText(v.z)).append("]");
}

}  // namespace

std::vector<Effects::Volume> boxesOf(const json& list, const std::string& what) {
  std::vector<Effects::Volume> boxes;
  for (size_t i = 0; i < list.size(); ++i) boxes.push_back(volumeOf(list[i], what + "[" + std::to_string(i) + "]"));
  return boxes;
}

void checkBoxes(const std::vector<Effects::Volume>& boxes, const std::string& what) {
  for (size_t i = 0; i < boxes.size(); ++i) {
    const auto& [min, max, extinction] = boxes[i];
    const std::string box = what + "[" + std::to_string(i) + "]";
    for (double value : {min.x, min.y, min.z, max.x, max.y, max.z})
      if (!std::isfinite(value)) refuseArgument(box + ": its corners must be finite");
    if (!(min.x <= max.x && min.y <= max.y && min.z <= max.z)) refuseArgument(box + ": its min is beyond its max");
    if (!(extinction >= 0 && extinction <= kMaxExtinction))
      refuseArgument(box + ".extinction must be 0.." + numberText(kMaxExtinction) + " 1/m, is " +
                     numberText(extinction));
    checkSize(extinction, box + ".extinction");
  }
}

std::string boxesText(const std::vector<Effects::Volume>& boxes) {
  std::string list;
  for (const auto& [min, max, extinction] : boxes)
    list += std::string(list.empty() ? "" : ",") + "\n    {\"min\": " + vectorText(min) +
            ", \"max\": " + vectorText(max) + ", \"extinction\": " + numberText(extinction) + "}";
  return std::string("[").append(list).append("]");
}

namespace {

/// Returns a word of a command line that is not JSON: a number as people write it (.5, 1., +2), or a text without
/// quotes.
json wordOf(const std::string& word) {
  const std::string_view digits = std::string_view(word).substr(word.starts_with('+') ? 1 : 0);
  double number = 0;
  const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const bool isNumber = problem == std::errc() && end == digits.data() + digits.size() && std::isfinite(number);
  return isNumber && word.find_first_of(".+") != word.npos ? json(number) : json(word);
}

}  // namespace

std::pair<std::string, json> splitAssignment(const std::string& assignment, const char* example) {
  const size_t equals = assignment.find('=');
  if (equals == assignment.npos) refuseArgument("'" + assignment + "' is not NAME=VALUE, as " + example);
  const std::string word = assignment.substr(equals + 1);
  json value = parseJson(word, false);
  if (value.is_discarded()) value = wordOf(word);
  return {assignment.substr(0, equals), std::move(value)};
}

}  // namespace gnosphere
