// SPDX-License-Identifier: Apache-2.0
// Checks and angles for the tests of the readers of sensor files.
#pragma once

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "gnosphere/error.hpp"
#include "gnosphere/sensor.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::test {

inline constexpr double kDegrees = 180 / std::numbers::pi;  ///< of a radian

/// The message with which a reader refuses a file; it names the file.
inline std::string problemOf(std::string_view bytes, const std::string& name, const SensorFileOptions& options = {}) {
  try {
    readSensorFile(bytes, name, options);
  } catch (const Error& error) {
    CHECK((error.code() == ErrorCode::format || error.code() == ErrorCode::invalidArgument));
    CHECK_THAT(error.what(), Catch::Matchers::ContainsSubstring(name.substr(0, 4)));
    return error.what();
  }
  return "nothing was wrong";
}

/// `text` with `to` in the place of the first `from`.
inline std::string replaced(std::string_view text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  REQUIRE(at != text.npos);
  std::string result(text.substr(0, at));
  result.append(to).append(text.substr(at + from.size()));
  return result;
}

inline double azimuthDeg(const Sensor& sensor, size_t beam, uint64_t frame = 0) {
  return kDegrees * azimuthOf(sensor, beam, frame);
}
inline double elevationDeg(const Sensor& sensor, size_t beam, uint64_t frame = 0) {
  return kDegrees * elevationOf(sensor, beam, frame);
}

inline void checkOrigin(const Vec3& found, const Vec3& expected) {
  using Catch::Matchers::WithinAbs;
  CHECK_THAT(found.x, WithinAbs(expected.x, 1e-12));
  CHECK_THAT(found.y, WithinAbs(expected.y, 1e-12));
  CHECK_THAT(found.z, WithinAbs(expected.z, 1e-12));
}

/// Whether one of the texts contains `part`.
inline bool lists(const std::vector<std::string>& texts, const std::string& part) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& t) { return t.find(part) != t.npos; });
}

}  // namespace gnosphere::test
