// SPDX-License-Identifier: Apache-2.0
#include "drive/formats/format.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>

#include "base/decimal_point.hpp"
#include "base/json_text.hpp"
#include "base/nanoseconds.hpp"
#include "gnosphere/error.hpp"
#include "output/cloud_bytes.hpp"

namespace gnosphere::drive {

namespace {

constexpr const char* kCloudFields = "x,y,z,intensity,ring,time,class,instance,true_range";
constexpr const char* kBagFields = "x,y,z,intensity,time,ring,class,instance";

constexpr FormatInfo kFormats[] = {
    {.name = "kitti", .make = makeKitti, .shown = true, .sequence = true, .oneSensor = true},
    {.name = "semantickitti", .make = makeKitti, .shown = true, .sequence = true, .oneSensor = true},
    {.name = "kitti-raw", .make = makeKittiRaw, .shown = true, .sequence = true, .oneSensor = true},
    {.name = "nuscenes", .make = makeNuScenes, .shown = true, .keyframes = true},
    {.name = "openpcdet", .make = makeOpenPcdet, .shown = false, .oneSensor = true},
    {.name = "pcd", .make = makeClouds, .shown = true, .fields = kCloudFields, .compact = true},
    {.name = "npy", .make = makeClouds, .shown = true, .fields = kCloudFields, .compact = true},
    {.name = "las", .make = makeLas, .shown = false, .fields = "", .pointTimes = true, .survey = true},
    {.name = "mcap", .make = makeMcap, .shown = false, .fields = kBagFields},
    {.name = "osi", .make = makeOsi, .shown = false, .fields = ""},
    {.name = "boxes", .make = makeBoxes, .shown = false, .allActors = true},
};

}  // namespace

std::span<const FormatInfo> formats() {
  return kFormats;
}

const FormatInfo& formatNamed(const std::string& name) {
  const auto found = std::ranges::find_if(kFormats, [&](const FormatInfo& format) { return name == format.name; });
  if (found == std::end(kFormats))
    throw Error(ErrorCode::invalidArgument, "no format of drives is called '" + name + "'");
  return *found;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " and ") + names[i];
  return text;
}

std::string formatNames(bool (*chosen)(const FormatInfo& format)) {
  std::vector<std::string> names;
  for (const FormatInfo& format : kFormats)
    if (chosen(format)) names.push_back(format.name);
  return listed(names);
}

std::string Format::sensorFile(const PlannedScan& scan, const std::string& ending) const {
  return path(drive_.sensors[scan.sensor].name + numberText("/%06llu.", scan.number) + ending);
}

std::string Format::partPath(size_t sensor, uint64_t frame) const {
  return path("parts/" + drive_.sensors[sensor].name + numberText("-%06llu", frame));
}

void Format::writePoses(const std::vector<FrameSummary>& frames, FinalFiles& files) const {
  for (size_t sensor : output_.sensors) {
    std::string text = "# t x y z qx qy qz qw\n";
    if (drive_.epoch != 0) text += "# t is Unix time less " + jsonText(nlohmann::json(drive_.epoch)) + " s\n";
    eachScan(frames, [&](const ScanSummary& scan) {
      if (scan.planned.sensor != sensor) return;
      const auto [p, q] = drive_.sensorPose(sensor, scan.planned.time);
      const DecimalPoint point;
      char line[256];
      std::snprintf(line, sizeof(line), "%.9f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", scan.planned.time, p.x, p.y,
                    p.z, q.x, q.y, q.z, q.w);
      text += line;
    });
    files.write(path(drive_.sensors[sensor].name + "/poses.txt"), text);
  }
}

std::string numberText(const char* format, uint64_t number) {
  char text[64];
  std::snprintf(text, sizeof(text), format, static_cast<unsigned long long>(number));
  return text;
}

int64_t unixNanoseconds(const Drive& drive, double time) {
  // Doubles near today's Unix time are 2.4e-7 s apart, and products of them with 1e9 are 256 ns apart.
  const double seconds = std::floor(drive.epoch);
  return static_cast<int64_t>(seconds) * 1'000'000'000 + std::llround((drive.epoch - seconds) * 1e9) +
         std::llround(time * 1e9);
}

std::string dateText(int64_t nanoseconds) {
  const auto [seconds, rest] = splitNanoseconds(nanoseconds);
  const std::chrono::sys_seconds time{std::chrono::seconds(seconds)};
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  char text[64];
  std::snprintf(text, sizeof(text), "%04d-%02u-%02u %02d:%02d:%02d.%09u", int{date.year()}, unsigned{date.month()},
                unsigned{date.day()}, static_cast<int>(clock.hours().count()),
                static_cast<int>(clock.minutes().count()), static_cast<int>(clock.seconds().count()), unsigned{rest});
  return text;
}

std::string packedRows(const Scan& scan, const RecordLayout& layout) {
  const auto returns = static_cast<size_t>(std::ranges::count_if(scan.ranges, [](float r) { return r == r; }));
  std::string rows(returns * layout.stride, '\0');
  rows.resize(pack(scan, layout, std::as_writable_bytes(std::span(rows))) * layout.stride);
  return rows;
}

float intensityFactor(const RigSensor& sensor, float greatest) {
  using Scale = Effects::Intensity::Scale;
  const Scale scale = sensor.effects.intensity.scale;
  return scale == Scale::unit ? greatest : scale == Scale::byte ? greatest / 255 : 1;
}

void scaleFloat(std::span<std::byte> rows, size_t stride, size_t offset, float factor) {
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
  scaleFloat(std::as_writable_bytes(std::span(rows)), layout.stride, 12, intensityFactor(sensor, 1));
  return rows;
}

}  // namespace gnosphere::drive
