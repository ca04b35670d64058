// SPDX-License-Identifier: Apache-2.0
#include "pose_text.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <vector>

#include "base/nearest_text.hpp"
#include "base/quaternion.hpp"
#include "base/text.hpp"
#include "base/units.hpp"
#include "console.hpp"
#include "drive/number_list.hpp"
#include "drive/pose_math.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::cli {
namespace {

constexpr const char* kAngles[] = {"yaw", "pitch", "roll"};

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, "--pose: " + why);
}

/// Reads words such as yaw=90,pitch=5 into the rotation that drive files make of the three angles.
Quaternion turnOf(std::string_view words) {
  double angles[3] = {};
  bool given[3] = {};
  for (size_t begin = 0; begin <= words.size();) {
    const size_t end = std::min(words.find(',', begin), words.size());
    const std::string_view word = trimmed(words.substr(begin, end - begin));
    const size_t equals = std::min(word.find('='), word.size());
    const std::string name = lower(trimmed(word.substr(0, equals)));
    const auto known = static_cast<size_t>(std::find(std::begin(kAngles), std::end(kAngles), name) - kAngles);
    if (known == std::size(kAngles))
      refuse("'" + std::string(word) + "' is no angle; " + nearestText(name, {std::begin(kAngles), std::end(kAngles)}) +
             ", in degrees, as yaw=90");
    if (given[known]) refuse(name + " is given twice; keep one");
    const std::vector<double> value = parseNumbers(word.substr(std::min(equals + 1, word.size())), ',');
    if (value.size() != 1) refuse("'" + std::string(word) + "' is no finite number of degrees, as yaw=90 is");
    angles[known] = kDegree * value[0];
    given[known] = true;
    begin = end + 1;
  }
  return drive::yawPitchRoll(angles[0], angles[1], angles[2]);
}

}  // namespace

Pose parsePose(const std::string& text) {
  const size_t equals = text.find('=');
  const size_t words = equals == text.npos ? text.npos : text.rfind(',', equals);
  const std::vector<double> numbers = parseNumbers(std::string_view(text).substr(0, words), ',');
  if (numbers.size() != 3 && numbers.size() != 7)
    refuse(
        "'" + text +
        "' is not X,Y,Z, then nothing or QX,QY,QZ,QW or yaw=DEGREES,pitch=DEGREES,roll=DEGREES, with finite numbers");
  Pose pose;
  pose.position = {numbers[0], numbers[1], numbers[2]};
  if (numbers.size() == 7) {
    if (words != text.npos) refuse("'" + text + "' has a quaternion and angles; keep one of them");
    const Quaternion q = {numbers[3], numbers[4], numbers[5], numbers[6]};
    if (!isUnit(q))
      refuse("'" + text + "' has a quaternion whose length is " + formatted("%.3g", normOf(q)) +
             " and not 1; 0,0,0,1 is no turn, and yaw=90 in place of the four numbers is one of 90 degrees");
    pose.orientation = normalized(q);
  } else if (words != text.npos) {
    pose.orientation = turnOf(std::string_view(text).substr(words + 1));
  }
  return pose;
}

std::string turnText(const Quaternion& orientation) {
  const auto [yaw, pitch, roll] = drive::yawPitchRollOf(normalized(orientation));
  // In thousandths of a degree; adding 0 turns -0 to 0.
  const auto rounded = [](double angle) { return std::round(1000 * kRadian * angle) / 1000 + 0.0; };
  const double degrees[3] = {rounded(roll), rounded(pitch), rounded(yaw)};
  if (degrees[0] == 0 && degrees[1] == 0 && degrees[2] == 0) return "";
  return formatted("turned by roll %g, pitch %g, yaw %g degrees", degrees[0], degrees[1], degrees[2]);
}

}  // namespace gnosphere::cli
