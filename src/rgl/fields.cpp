// SPDX-License-Identifier: Apache-2.0
#include "rgl/fields.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "base/text.hpp"
#include "rgl/call.hpp"

namespace gnosphere::rgl {
namespace {

struct Row {
  rgl_field_t field;
  const char* name;
  size_t bytes;
  int at17, at16;  ///< numbers at levels 0.17 and 0.16 (0.14 to 0.16); 0 if the field is not there
};

constexpr Row kRows[] = {
    {RGL_FIELD_XYZ_VEC3_F32, "XYZ_VEC3_F32", 12, 1, 1},
    {RGL_FIELD_INTENSITY_F32, "INTENSITY_F32", 4, 2, 2},
    {RGL_FIELD_INTENSITY_U8, "INTENSITY_U8", 1, 0, 0},
    {RGL_FIELD_IS_HIT_I32, "IS_HIT_I32", 4, 3, 3},
    {RGL_FIELD_IS_GROUND_I32, "IS_GROUND_I32", 4, 4, 0},
    {RGL_FIELD_RAY_IDX_U32, "RAY_IDX_U32", 4, 5, 4},
    {RGL_FIELD_ENTITY_ID_I32, "ENTITY_ID_I32", 4, 6, 6},
    {RGL_FIELD_DISTANCE_F32, "DISTANCE_F32", 4, 7, 7},
    {RGL_FIELD_AZIMUTH_F32, "AZIMUTH_F32", 4, 8, 8},
    {RGL_FIELD_ELEVATION_F32, "ELEVATION_F32", 4, 9, 0},
    {RGL_FIELD_RING_ID_U16, "RING_ID_U16", 2, 10, 9},
    {RGL_FIELD_RETURN_TYPE_U8, "RETURN_TYPE_U8", 1, 11, 10},
    {RGL_FIELD_TIME_STAMP_F64, "TIME_STAMP_F64", 8, 12, 11},
    {RGL_FIELD_TIME_STAMP_U32, "TIME_STAMP_U32", 4, 0, 0},
    {RGL_FIELD_ABSOLUTE_VELOCITY_VEC3_F32, "ABSOLUTE_VELOCITY_VEC3_F32", 12, 13, 12},
    {RGL_FIELD_RELATIVE_VELOCITY_VEC3_F32, "RELATIVE_VELOCITY_VEC3_F32", 12, 14, 0},
    {RGL_FIELD_RADIAL_SPEED_F32, "RADIAL_SPEED_F32", 4, 15, 0},
    {RGL_FIELD_POWER_F32, "POWER_F32", 4, 16, 0},
    {RGL_FIELD_RCS_F32, "RCS_F32", 4, 17, 0},
    {RGL_FIELD_NOISE_F32, "NOISE_F32", 4, 18, 0},
    {RGL_FIELD_SNR_F32, "SNR_F32", 4, 19, 0},
    {RGL_FIELD_NORMAL_VEC3_F32, "NORMAL_VEC3_F32", 12, 20, 0},
    {RGL_FIELD_INCIDENT_ANGLE_F32, "INCIDENT_ANGLE_F32", 4, 21, 0},
    {RGL_FIELD_RAY_POSE_MAT3x4_F32, "RAY_POSE_MAT3x4_F32", 48, 22, 0},
    {RGL_FIELD_LASER_RETRO_F32, "LASER_RETRO_F32", 4, 23, 0},
    {RGL_FIELD_REFLECTIVITY_F32, "REFLECTIVITY_F32", 4, 0, 0},
    {RGL_FIELD_PADDING_8, "PADDING_8", 1, 1024, 1024},
    {RGL_FIELD_PADDING_16, "PADDING_16", 2, 1025, 1025},
    {RGL_FIELD_PADDING_32, "PADDING_32", 4, 1026, 1026},
    {RGL_FIELD_DYNAMIC_FORMAT, "DYNAMIC_FORMAT", 0, 13842, 13842},
};

const Row* find(rgl_field_t field) {
  for (const Row& row : kRows)
    if (row.field == field) return &row;
  return nullptr;
}

int numberAt(const Row& row) {
  return level() == 16 ? row.at16 : level() == 17 ? row.at17 : row.field;
}

/// Returns the whole numbers of a text such as 0.20.0, perhaps with blanks around it; none if it is no such text.
std::vector<int> numbersOf(std::string_view text) {
  text = trimmed(text);
  std::vector<int> numbers;
  for (;;) {
    int& number = numbers.emplace_back();
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failed != std::errc() || number < 0) return {};
    text.remove_prefix(static_cast<size_t>(end - text.data()));
    if (text.empty()) return numbers;
    if (!text.starts_with('.')) return {};
    text.remove_prefix(1);
  }
}

}  // namespace

const char* nameOf(rgl_field_t field) {
  const Row* row = find(field);
  return row ? row->name : "an unknown field";
}

size_t sizeOf(rgl_field_t field) {
  const Row* row = find(field);
  if (!row || row->bytes == 0)
    throw Failure(RGL_INVALID_ARGUMENT, std::string("there is no size of the field ") + nameOf(field));
  return row->bytes;
}

bool isPadding(rgl_field_t field) {
  return field >= RGL_FIELD_PADDING_8 && field <= RGL_FIELD_PADDING_32;
}

int level() {
  static const int chosen = [] {
    const char* text = std::getenv("GNOSPHERE_RGL_ABI");
    if (!text) text = GNOSPHERE_RGL_LEVEL;
    const std::vector<int> numbers = numbersOf(text);
    const bool known = numbers.size() == 2 || numbers.size() == 3;
    if (known && numbers[0] == 0 && numbers[1] >= 14 && numbers[1] <= 21) return std::max(numbers[1], 16);
    log(RGL_LOG_LEVEL_WARN,
        std::string("GNOSPHERE_RGL_ABI is '") + text + "', which is none of 0.16 to 0.21; 0.20 is used");
    return 20;
  }();
  return chosen;
}

Version version() {
  if (const char* text = std::getenv("GNOSPHERE_RGL_VERSION")) {
    const std::vector<int> numbers = numbersOf(text);
    if (numbers.size() == 3) return {numbers[0], numbers[1], numbers[2]};
    log(RGL_LOG_LEVEL_WARN, std::string("GNOSPHERE_RGL_VERSION is '") + text + "', which is no version such as 0.20.0");
  }
  return {0, level(), level() == 16 ? 3 : 0};  // tapes are played from 0.16.3 on
}

rgl_field_t fieldOf(rgl_field_t number) {
  if (number != 0)
    for (const Row& row : kRows)
      if (numberAt(row) == number) return row.field;
  throw Failure(RGL_INVALID_ARGUMENT, "unknown RGL field " + std::to_string(static_cast<int>(number)) + " at level 0." +
                                          std::to_string(level()) + " (GNOSPHERE_RGL_ABI)");
}

Fields fieldsOf(const rgl_field_t* numbers, int32_t count) {
  Fields result;
  for (int32_t i = 0; i < count; ++i) result.push_back(fieldOf(numbers[i]));
  return result;
}

}  // namespace gnosphere::rgl
