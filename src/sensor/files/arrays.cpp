// SPDX-License-Identifier: Apache-2.0
// Arrays of numbers: NumPy's .npy with directions (N x 3), angles (N x 2: azimuth and elevation in radians, as patterns
// of Livox) or poses of rays (N x 3 x 4, N x 4 x 4, N x 12, N x 16), and raw poses (.mat3x4f of RGL). A ray starts at
// the translation of its pose and points along the pose's own z axis. The axes of all are ours.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/npy.hpp"
#include "base/units.hpp"
#include "sensor/files/source.hpp"

namespace gnosphere {
namespace {

/// The array of an .npy file, before its data.
struct Header {
  char order = '<', kind = 'f';
  size_t itemBytes = 0;
  bool fortran = false;
  std::vector<uint64_t> shape;
  size_t dataAt = 0;
};

Header readHeader(const SensorSource& source) {
  const std::string_view all = source.bytes;
  if (!all.starts_with("\x93NUMPY")) source.refuse("does not start with \\x93NUMPY, as NPY files do");
  if (all.size() < 12) source.refuse("is too short for an NPY file");
  const NpyHeader npy = readNpyHeader(all, source.name);
  const std::string& type = npy.type;
  const auto is = [&](size_t place, std::string_view letters) { return letters.find(type[place]) != letters.npos; };
  const bool known =
      type.size() == 3 && is(0, "<>|=") && ((is(1, "f") && is(2, "248")) || (is(1, "iu") && is(2, "1248")));
  if (!known)
    source.refuse("the NPY type is " + (type.empty() ? "a structure" : "'" + type + "'") +
                  ", expected are floats of 2, 4 or 8 bytes, or integers");
  Header header = {type[0], type[1], static_cast<size_t>(type[2] - '0'), npy.fortran, npy.shape, npy.dataAt};
  for (uint64_t& extent : header.shape)
    extent = std::min(extent, uint64_t{1} << 40);  // their product must not overflow
  return header;
}

/// Returns the value of a half-precision number (binary16 of IEEE 754).
double halfOf(uint16_t bits) {
  const int exponent = bits >> 10 & 31;
  const double part = bits & 1023;
  const double size = exponent == 31 ? (part == 0 ? INFINITY : NAN)
                                     : std::ldexp(exponent == 0 ? part : 1024 + part, std::max(exponent, 1) - 25);
  return bits >> 15 ? -size : size;
}

/// One item of an array, whose bytes are in the machine's order.
double itemOf(const Header& header, const char* item) {
  const auto as = [&](auto value) {
    std::memcpy(&value, item, sizeof(value));
    return static_cast<double>(value);
  };
  uint16_t half = 0;
  if (header.itemBytes == 2) std::memcpy(&half, item, 2);
  const bool isSigned = header.kind == 'i';
  if (header.kind == 'f') return header.itemBytes == 2 ? halfOf(half) : header.itemBytes == 4 ? as(0.0f) : as(0.0);
  switch (header.itemBytes) {
    case 1: return isSigned ? as(int8_t{}) : as(uint8_t{});
    case 2: return isSigned ? as(int16_t{}) : as(uint16_t{});
    case 4: return isSigned ? as(int32_t{}) : as(uint32_t{});
    default: return isSigned ? as(int64_t{}) : as(uint64_t{});
  }
}

/// The numbers of an array, last index fastest.
std::vector<double> readNumbers(const SensorSource& source, const Header& header) {
  uint64_t count = 1;
  for (const uint64_t extent : header.shape) {
    count *= extent;
    if (count > source.bytes.size())
      source.refuse("has " + std::to_string(source.bytes.size() - header.dataAt) +
                    " bytes of data, its shape needs more");
  }
  if (count * header.itemBytes != source.bytes.size() - header.dataAt)
    source.refuse("has " + std::to_string(source.bytes.size() - header.dataAt) + " bytes of data, its shape needs " +
                  std::to_string(count * header.itemBytes));
  std::vector<double> numbers(count);
  for (size_t i = 0; i < count; ++i) {
    char item[8];
    std::memcpy(item, source.bytes.data() + header.dataAt + i * header.itemBytes, header.itemBytes);
    if (header.order == '>') std::reverse(item, item + header.itemBytes);
    numbers[i] = itemOf(header, item);
  }
  if (!header.fortran || header.shape.size() < 2) return numbers;
  std::vector<double> ordered(count);
  for (uint64_t i = 0; i < count; ++i) {
    uint64_t rest = i, place = 0, stride = count;
    for (size_t k = header.shape.size(); k-- > 0;) {
      stride /= header.shape[k];
      place += rest % header.shape[k] * stride;
      rest /= header.shape[k];
    }
    ordered[i] = numbers[place];
  }
  return ordered;
}

/// Appends the ray of a pose of 3 x 4 numbers, row by row.
void addPose(const SensorSource& source, BeamList& list, const double* m) {
  addDirection(source, list, {m[2], m[6], m[10]});
  if (!std::isfinite(m[3]) || !std::isfinite(m[7]) || !std::isfinite(m[11]))
    source.refuse("the origin of beam " + std::to_string(list.size() - 1) + " is not finite");
  list.origins.push_back({m[3], m[7], m[11]});
}

void finish(SensorSource& source, BeamList list) {
  setBeams(source, std::move(list));
  assumeRange(source, 200);
}

}  // namespace

void readNpy(SensorSource& source) {
  const Header header = readHeader(source);
  std::vector<uint64_t> shape = header.shape;
  std::string text;
  for (const uint64_t extent : shape) text += (text.empty() ? "" : " x ") + std::to_string(extent);
  // The last extents tell the numbers of a beam.
  size_t each = 0;
  if (shape.size() >= 3 && shape.back() == 4 && (shape[shape.size() - 2] == 3 || shape[shape.size() - 2] == 4)) {
    each = static_cast<size_t>(4 * shape[shape.size() - 2]);
    shape.resize(shape.size() - 2);
  } else if (shape.size() >= 2 &&
             (shape.back() == 2 || shape.back() == 3 || shape.back() == 12 || shape.back() == 16)) {
    each = static_cast<size_t>(shape.back());
    shape.pop_back();
  }
  if (each == 0 || shape.empty() || shape.size() > 2)
    source.refuse("the NPY array has the shape " + (text.empty() ? "of one number" : text) +
                  ", expected is N x 2, N x 3, N x 12, N x 3 x 4 or N x 4 x 4");
  const std::vector<double> numbers = readNumbers(source, header);
  BeamList list;
  for (size_t i = 0; i + each <= numbers.size(); i += each) {
    const double* n = numbers.data() + i;
    if (each == 2)
      list.directions.push_back(directionOfAngles(source, kRadian * n[0], kRadian * n[1], list.size()));
    else if (each == 3)
      addDirection(source, list, {n[0], n[1], n[2]});
    else
      addPose(source, list, n);
  }
  if (shape.size() == 2 && list.size() > 0 && source.options.beamsPerScan == 0 && shape[0] < UINT32_MAX &&
      shape[1] < UINT32_MAX) {
    list.height = static_cast<uint32_t>(shape[0]);
    list.width = static_cast<uint32_t>(shape[1]);
  }
  finish(source, std::move(list));
}

void readRayMatrices(SensorSource& source) {
  constexpr size_t kPoseBytes = 48;
  if (source.bytes.size() % kPoseBytes != 0)
    source.refuse("has " + std::to_string(source.bytes.size()) +
                  " bytes, expected is a multiple of 48: poses of 3 x 4 floats");
  BeamList list;
  for (size_t at = 0; at < source.bytes.size(); at += kPoseBytes) {
    float pose[12];
    std::memcpy(pose, source.bytes.data() + at, kPoseBytes);
    double m[12];
    for (size_t i = 0; i < 12; ++i) m[i] = pose[i];
    addPose(source, list, m);
  }
  finish(source, std::move(list));
}

}  // namespace gnosphere
