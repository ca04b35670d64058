// SPDX-License-Identifier: Apache-2.0
#include "drive/formats/format.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <span>

#include "base/file.hpp"

namespace gnosphere::drive {

std::unique_ptr<Format> makeFormat(const Drive& drive, const World& world, const Output& output) {
  const std::string& format = output.format;
  const auto make = format == "pcd" || format == "npy"               ? makeClouds
                    : format == "boxes"                              ? makeBoxes
                    : format == "kitti" || format == "semantickitti" ? makeKitti
                    : format == "kitti-raw"                          ? makeKittiRaw
                    : format == "nuscenes"                           ? makeNuScenes
                    : format == "las"                                ? makeLas
                    : format == "osi"                                ? makeOsi
                                                                     : makeMcap;
  return make(drive, world, output);
}

void writeWhole(const std::filesystem::path& file, const std::string& bytes) {
  std::error_code failed;
  std::filesystem::create_directories(file.parent_path(), failed);
  AtomicFile out(file);
  out.write(bytes);
  out.commit();
}

std::string numberText(const char* format, uint64_t number) {
  char text[64];
  std::snprintf(text, sizeof(text), format, static_cast<unsigned long long>(number));
  return text;
}

int64_t unixNanoseconds(const Drive& drive, double time) {
  return std::llround(drive.epoch * 1e9) + std::llround(time * 1e9);
}

std::string dateText(int64_t nanoseconds) {
  constexpr int64_t kSecond = 1'000'000'000;
  const int64_t rest = ((nanoseconds % kSecond) + kSecond) % kSecond;
  const std::time_t seconds = (nanoseconds - rest) / kSecond;
  std::tm parts = {};
  gmtime_r(&seconds, &parts);
  char date[32], text[64];
  std::strftime(date, sizeof(date), "%Y-%m-%d %H:%M:%S", &parts);
  std::snprintf(text, sizeof(text), "%s.%09lld", date, static_cast<long long>(rest));
  return text;
}

void appendRows(std::string& bytes, const Scan& scan, const RecordLayout& layout) {
  size_t most = scan.ranges.size();
  if (layout.compact) most -= static_cast<size_t>(std::ranges::count_if(scan.ranges, [](float r) { return r != r; }));
  const size_t start = bytes.size();
  bytes.resize(start + most * layout.stride);
  const size_t count = pack(scan, layout, std::as_writable_bytes(std::span(bytes).subspan(start)));
  bytes.resize(start + count * layout.stride);
}

std::string packedRows(const Scan& scan, const RecordLayout& layout) {
  std::string rows;
  appendRows(rows, scan, layout);
  return rows;
}

RecordLayout kittiLayout(const Scan& scan) {
  RecordLayout layout = layoutOf({Field::x, Field::y, Field::z});
  if (scan.has(Field::intensity)) layout = layoutOf({Field::x, Field::y, Field::z, Field::intensity});
  layout.stride = 4 * sizeof(float);
  layout.compact = true;
  return layout;
}

float intensityFactor(const RigSensor& sensor, float greatest) {
  using Scale = Effects::Intensity::Scale;
  const Scale scale = sensor.effects.intensity.scale;
  return scale == Scale::unit ? greatest : scale == Scale::byte ? greatest / 255 : 1;
}

void scaleFloat(std::string& rows, size_t stride, size_t offset, float factor) {
  if (factor == 1) return;
  for (size_t at = offset; at < rows.size(); at += stride) {
    float value;
    std::memcpy(&value, &rows[at], sizeof(value));
    value *= factor;
    std::memcpy(&rows[at], &value, sizeof(value));
  }
}

std::string kittiRows(const Scan& scan, const RigSensor& sensor) {
  const RecordLayout layout = kittiLayout(scan);
  std::string rows = packedRows(scan, layout);
  scaleFloat(rows, layout.stride, 12, intensityFactor(sensor, 1));
  return rows;
}

}  // namespace gnosphere::drive
