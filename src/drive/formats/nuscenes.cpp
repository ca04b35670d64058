// SPDX-License-Identifier: Apache-2.0
// The layout of nuScenes (Caesar et al., CVPR 2020): v1.0-drive/*.json, samples and sweeps. Every lidar is a channel. A
// .pcd.bin file has x, y, z, intensity 0..255 and ring as floats. As in nuScenes, its points are where the sensor would
// have seen them from its pose at the time of the sweep, which is the start of the scan.
#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "base/hash.hpp"
#include "base/json_text.hpp"
#include "drive/formats/format.hpp"
#include "drive/pose_math.hpp"
#include "output/cloud_bytes.hpp"

namespace gnosphere::drive {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kVersion = "v1.0-drive";

/// A white pixel as PNG: the development kit wants a picture of the map.
constexpr unsigned char kEmptyMap[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
    0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
    0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0xf8, 0x0f, 0x00, 0x01, 0x01, 0x01, 0x00,
    0x1c, 0xb0, 0x8c, 0x99, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

Json turnOf(const Quaternion& q) {
  return {q.w, q.x, q.y, q.z};
}

/// The four bins of nuScenes: up to 40, 60, 80 and 100 per cent.
int visibilityBin(double share) {
  return share < 0.4 ? 1 : share < 0.6 ? 2 : share < 0.8 ? 3 : 4;
}

/// A scan and the frame that it belongs to.
struct Entry {
  uint64_t frame;
  bool key;
  ScanSummary scan;
};

class NuScenes : public Format {
 public:
  using Format::Format;

  std::vector<Field> fields() const override { return {Field::intensity, Field::ring}; }
  bool needsBoxes() const override { return true; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    std::vector<bool> seen(drive_.sensors.size());
    eachScan(frame, [&](const RecordedScan& recorded) {
      const size_t sensor = recorded.planned.sensor;
      const bool key = isKey(frame.frame) && !seen[sensor];
      seen[sensor] = true;
      files.push_back({path(fileOf(recorded.planned, key)), pointsOf(recorded), ""});
    });
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override;

 private:
  bool isKey(uint64_t frame) const { return frame % output_.keyframes == 0; }
  std::string token(const std::string& what, uint64_t a = 0, uint64_t b = 0) const {
    return hashOf(drive_.fingerprint + "/" + drive_.name + "/" + what + "/" + std::to_string(a) + "/" +
                  std::to_string(b));
  }
  std::string dataToken(const PlannedScan& scan) const { return token("sample_data", scan.sensor, scan.number); }
  int64_t microseconds(double time) const { return unixNanoseconds(drive_, time) / 1000; }

  std::string fileOf(const PlannedScan& scan, bool key) const {
    const std::string& channel = drive_.sensors[scan.sensor].name;
    return std::string(key ? "samples/" : "sweeps/") + channel + "/" + drive_.name + "__" + channel + "__" +
           std::to_string(microseconds(scan.time)) + ".pcd.bin";
  }

  std::string pointsOf(const RecordedScan& recorded) const {
    RecordLayout layout = kittiLayout(recorded.scan);
    layout.values.push_back({Field::ring, 0, 16, ValueType::f32});
    layout.stride = 20;
    std::string rows = packedRows(recorded.scan, layout);
    scaleFloat(std::as_writable_bytes(std::span(rows)), layout.stride, 12,
               intensityFactor(drive_.sensors[recorded.planned.sensor], 255));
    if (recorded.scan.skewed) compensate(recorded, rows, layout.stride);
    return rows;
  }

  /// Moves the points of a scan to the sensor's frame at the scan's start. Before, each point is in the frame that the
  /// sensor has at the time of the point.
  void compensate(const RecordedScan& recorded, std::string& rows, size_t stride) const {
    const Scan& scan = recorded.scan;
    const auto seconds = scan.column<float>(Field::time);
    const Pose toStart = inverse(recorded.pose);
    std::unordered_map<float, Pose> moves;  // by time: the beams of a column fire at the same time
    char* row = rows.data();
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
      if (!scan.returned(entry)) continue;
      const float after = seconds[entry];
      const auto [move, isNew] = moves.try_emplace(after);
      if (isNew)
        move->second = toStart * drive_.sensorPose(recorded.planned.sensor, recorded.planned.time + double{after});
      float point[3];
      std::memcpy(point, row, sizeof(point));
      const Vec3 moved = move->second * Vec3{point[0], point[1], point[2]};
      const float result[3] = {static_cast<float>(moved.x), static_cast<float>(moved.y), static_cast<float>(moved.z)};
      std::memcpy(row, result, sizeof(result));
      row += stride;
    }
  }

  std::vector<Entry> entriesOf(const std::vector<FrameSummary>& frames) const;
  void write(FinalFiles& files, const char* table, const Json& rows) const {
    files.write(path(std::string(kVersion) + "/" + table + ".json"), jsonText(rows, 1) + "\n");
  }
  void writeConstants(FinalFiles& files) const;
  void writeData(FinalFiles& files, const std::vector<Entry>& entries, const std::vector<uint64_t>& samples) const;
  void writeAnnotations(FinalFiles& files, const std::vector<Entry>& entries) const;
  double sampleTime(uint64_t sample, const std::vector<Entry>& entries) const;
};

std::vector<Entry> NuScenes::entriesOf(const std::vector<FrameSummary>& frames) const {
  std::vector<Entry> entries;
  for (uint64_t f = 0; f < frames.size(); ++f) {
    std::vector<bool> seen(drive_.sensors.size());
    eachScan(frames[f], [&](const ScanSummary& scan) {
      entries.push_back({f, isKey(f) && !seen[scan.planned.sensor], scan});
      seen[scan.planned.sensor] = true;
    });
  }
  return entries;
}

/// A sample has the time of its first scan.
double NuScenes::sampleTime(uint64_t sample, const std::vector<Entry>& entries) const {
  for (const Entry& entry : entries)
    if (entry.frame == sample) return entry.scan.planned.time;
  return drive_.start + static_cast<double>(sample) / drive_.rate;
}

void NuScenes::writeConstants(FinalFiles& files) const {
  Json categories = Json::array(), sensors = Json::array(), mounted = Json::array();
  for (const Class& category : drive_.classes)
    categories.push_back({{"token", token("category/" + category.name)}, {"name", category.name}, {"description", ""}});
  for (size_t s : output_.sensors) {
    const RigSensor& sensor = drive_.sensors[s];
    sensors.push_back({{"token", token("sensor", s)}, {"channel", sensor.name}, {"modality", "lidar"}});
    mounted.push_back({{"token", token("calibrated_sensor", s)},
                       {"sensor_token", token("sensor", s)},
                       {"translation", listOf(sensor.mount.position)},
                       {"rotation", turnOf(sensor.mount.orientation)},
                       {"camera_intrinsic", Json::array()}});
  }
  write(files, "category", categories);
  write(files, "sensor", sensors);
  write(files, "calibrated_sensor", mounted);
  Json attributes = Json::array(), visibilities = Json::array();
  for (const char* name : {"moving", "standing"})
    attributes.push_back({{"token", token(name)}, {"name", name}, {"description", ""}});
  const char* levels[] = {"v0-40", "v40-60", "v60-80", "v80-100"};
  for (int i = 0; i < 4; ++i)
    visibilities.push_back(
        {{"token", std::to_string(i + 1)},
         {"level", levels[i]},
         {"description",
          std::string("of the beams through the box that meet a surface, the share that arrives at it: ") +
              (levels[i] + 1) + " %"}});
  write(files, "attribute", attributes);
  write(files, "visibility", visibilities);
  const std::string day = dateText(unixNanoseconds(drive_, drive_.start)).substr(0, 10);
  write(files, "log",
        Json::array({{{"token", token("log")},
                      {"logfile", drive_.name},
                      {"vehicle", "simulated"},
                      {"date_captured", day},
                      {"location", drive_.name}}}));
  write(files, "map",
        Json::array({{{"token", token("map")},
                      {"category", "semantic_prior"},
                      {"filename", "maps/empty.png"},
                      {"log_tokens", {token("log")}}}}));
  files.write(path("maps/empty.png"), std::string(reinterpret_cast<const char*>(kEmptyMap), sizeof(kEmptyMap)));
}

void NuScenes::writeData(FinalFiles& files, const std::vector<Entry>& entries,
                         const std::vector<uint64_t>& samples) const {
  Json sampleRows = Json::array(), rows = Json::array(), poses = Json::array();
  for (size_t i = 0; i < samples.size(); ++i)
    sampleRows.push_back({{"token", token("sample", samples[i])},
                          {"timestamp", microseconds(sampleTime(samples[i], entries))},
                          {"prev", i == 0 ? "" : token("sample", samples[i - 1])},
                          {"next", i + 1 == samples.size() ? "" : token("sample", samples[i + 1])},
                          {"scene_token", token("scene")}});
  std::map<size_t, std::vector<const Entry*>> bySensor;
  for (const Entry& entry : entries) bySensor[entry.scan.planned.sensor].push_back(&entry);
  for (const auto& [sensor, list] : bySensor) {
    for (size_t i = 0; i < list.size(); ++i) {
      const Entry& entry = *list[i];
      const PlannedScan& scan = entry.scan.planned;
      // A sweep belongs to the sample after it, or to the last one.
      const auto next = std::lower_bound(samples.begin(), samples.end(), entry.frame);
      const uint64_t sample = next == samples.end() ? samples.back() : *next;
      const Pose ego = drive_.ego.at(scan.time);
      rows.push_back({{"token", dataToken(scan)},
                      {"sample_token", token("sample", sample)},
                      {"ego_pose_token", dataToken(scan)},
                      {"calibrated_sensor_token", token("calibrated_sensor", sensor)},
                      {"timestamp", microseconds(scan.time)},
                      {"fileformat", "pcd"},
                      {"is_key_frame", entry.key},
                      {"height", 0},
                      {"width", 0},
                      {"filename", fileOf(scan, entry.key)},
                      {"prev", i == 0 ? "" : dataToken(list[i - 1]->scan.planned)},
                      {"next", i + 1 == list.size() ? "" : dataToken(list[i + 1]->scan.planned)}});
      poses.push_back({{"token", dataToken(scan)},
                       {"timestamp", microseconds(scan.time)},
                       {"rotation", turnOf(ego.orientation)},
                       {"translation", listOf(ego.position)}});
    }
  }
  write(files, "sample", sampleRows);
  write(files, "sample_data", rows);
  write(files, "ego_pose", poses);
  write(files, "scene",
        Json::array({{{"token", token("scene")},
                      {"log_token", token("log")},
                      {"nbr_samples", samples.size()},
                      {"first_sample_token", token("sample", samples.front())},
                      {"last_sample_token", token("sample", samples.back())},
                      {"name", drive_.name},
                      {"description", ""}}}));
}

void NuScenes::writeAnnotations(FinalFiles& files, const std::vector<Entry>& entries) const {
  struct Sight {
    uint64_t points = 0;
    double visibility = 0;
    const Box* box = nullptr;  // of the sensor that has the most points of the actor
  };
  std::map<size_t, std::map<uint64_t, Sight>> sights;  // by actor and sample
  for (const Entry& entry : entries) {
    if (!entry.key) continue;
    for (const Box& box : entry.scan.boxes) {
      Sight& sight = sights[box.actor][entry.frame];
      sight.points += box.points;
      if (!sight.box || box.points > sight.box->points) sight.box = &box;
      sight.visibility = std::max(sight.visibility, box.visibility);
    }
  }
  Json rows = Json::array(), instances = Json::array();
  for (const auto& [actor, bySample] : sights) {
    std::vector<uint64_t> seen;
    for (const auto& [sample, sight] : bySample) seen.push_back(sample);
    for (size_t i = 0; i < seen.size(); ++i) {
      const Sight& sight = bySample.at(seen[i]);
      const Box& box = *sight.box;
      rows.push_back({{"token", token("annotation", actor, seen[i])},
                      {"sample_token", token("sample", seen[i])},
                      {"instance_token", token("instance", actor)},
                      {"visibility_token", std::to_string(visibilityBin(sight.visibility))},
                      {"attribute_tokens", {token(box.moving ? "moving" : "standing")}},
                      {"translation", listOf(box.inWorld.position)},
                      {"size", {box.size.y, box.size.x, box.size.z}},
                      {"rotation", turnOf(box.inWorld.orientation)},
                      {"prev", i == 0 ? "" : token("annotation", actor, seen[i - 1])},
                      {"next", i + 1 == seen.size() ? "" : token("annotation", actor, seen[i + 1])},
                      {"num_lidar_pts", sight.points},
                      {"num_radar_pts", 0}});
    }
    instances.push_back({{"token", token("instance", actor)},
                         {"category_token", token("category/" + drive_.classes[drive_.actors[actor].category].name)},
                         {"nbr_annotations", seen.size()},
                         {"first_annotation_token", token("annotation", actor, seen.front())},
                         {"last_annotation_token", token("annotation", actor, seen.back())}});
  }
  write(files, "sample_annotation", rows);
  write(files, "instance", instances);
}

void NuScenes::finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const {
  const std::vector<Entry> entries = entriesOf(frames);
  std::vector<uint64_t> samples;
  for (const Entry& entry : entries)
    if (entry.key && (samples.empty() || samples.back() != entry.frame)) samples.push_back(entry.frame);
  if (samples.empty()) return;
  writeConstants(files);
  writeData(files, entries, samples);
  writeAnnotations(files, entries);
}

}  // namespace

std::unique_ptr<Format> makeNuScenes(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<NuScenes>(drive, world, output);
}

}  // namespace gnosphere::drive
