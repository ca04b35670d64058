// SPDX-License-Identifier: Apache-2.0
// The layout of nuScenes (Caesar et al., CVPR 2020): VERSION/*.json, samples and sweeps. Every lidar is a channel. A
// .pcd.bin file has x, y, z, intensity 0..255 and ring as floats. As in nuScenes, its points are where the sensor would
// have seen them from its pose at the time of the sweep, which is the start of the scan.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <unordered_map>

#include "base/hash.hpp"
#include "base/json_text.hpp"
#include "drive/formats/format.hpp"
#include "drive/pose_math.hpp"
#include "output/cloud_bytes.hpp"

namespace gnosphere::drive {
namespace {

using Json = nlohmann::ordered_json;

/// A white pixel as PNG: the development kit wants a picture of the map.
constexpr unsigned char kEmptyMap[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
    0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
    0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0xf8, 0x0f, 0x00, 0x01, 0x01, 0x01, 0x00,
    0x1c, 0xb0, 0x8c, 0x99, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

Json turnOf(const Quaternion& q) {
  return {q.w, q.x, q.y, q.z};
}

/// The four bins of nuScenes: up to 40, 60, 80 and 100 per cent; the last one for NaN, because nothing is known to hide
/// the actor.
int visibilityBin(double share) {
  return share < 0.4 ? 1 : share < 0.6 ? 2 : share < 0.8 ? 3 : 4;
}

/// The category of points without a class. In nuScenes-lidarseg it has the index 0, and the development kit wants the
/// others to have 1, 2 and so on.
constexpr const char* kNoise = "noise";

/// The attribute of an annotation, as nuScenes has it for the category, or of the same kind for other names: whether
/// the actor moves now, and else whether it moves at any time of the drive. None for nuScenes' categories without one,
/// and for its cycles, whose attribute tells whether there is a rider, which the drive does not know.
std::string attributeOf(std::string_view category, bool moves, bool everMoves) {
  if (category.starts_with("human.pedestrian.")) return moves ? "pedestrian.moving" : "pedestrian.standing";
  if (category == "vehicle.bicycle" || category == "vehicle.motorcycle") return "";
  if (category.starts_with("vehicle."))
    return moves ? "vehicle.moving" : everMoves ? "vehicle.stopped" : "vehicle.parked";
  if (category.starts_with("movable_object.") || category.starts_with("static_object.")) return "";
  return moves ? "moving" : "standing";
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

  std::vector<Field> fields() const override {
    if (output_.lidarseg) return {Field::intensity, Field::ring, Field::classId};
    return {Field::intensity, Field::ring};
  }
  bool needsBoxes() const override { return true; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    std::vector<bool> seen(drive_.sensors.size());
    eachScan(frame, [&](const RecordedScan& recorded) {
      const size_t sensor = recorded.planned.sensor;
      const bool key = isKey(frame.frame) && !seen[sensor];
      seen[sensor] = true;
      files.push_back({path(fileOf(recorded.planned, key)), pointsOf(recorded), ""});
      if (key && output_.lidarseg) files.push_back({path(labelFileOf(recorded.planned)), labelsOf(recorded.scan), ""});
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
  /// Rounds, because a double near today's Unix time is up to 0.12 us off the microseconds that it stands for.
  int64_t microseconds(double time) const { return (unixNanoseconds(drive_, time) + 500) / 1000; }

  std::string fileOf(const PlannedScan& scan, bool key) const {
    const std::string& channel = drive_.sensors[scan.sensor].name;
    return std::string(key ? "samples/" : "sweeps/") + channel + "/" + drive_.name + "__" + channel + "__" +
           std::to_string(microseconds(scan.time)) + ".pcd.bin";
  }

  std::string labelFileOf(const PlannedScan& scan) const {
    return "lidarseg/" + output_.version + "/" + dataToken(scan) + "_lidarseg.bin";
  }

  /// A byte per point: the `index` of its category, and 0 for points without a class of the drive file.
  std::string labelsOf(const Scan& scan) const {
    const auto classes = scan.column<uint16_t>(Field::classId);
    std::map<uint16_t, uint8_t> indices;  // by id; of classes with the same id the first one counts
    uint8_t last = 0;
    for (const Class& category : drive_.classes)
      indices.emplace(category.id, category.name == kNoise ? uint8_t{0} : ++last);
    std::string bytes;
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
      if (!scan.returned(entry)) continue;
      const auto found = scan.instances[entry] == kNoTriangle ? indices.end() : indices.find(classes[entry]);
      bytes += found == indices.end() ? '\0' : static_cast<char>(found->second);
    }
    return bytes;
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
    files.write(path(output_.version + "/" + table + ".json"), jsonText(rows, 1) + "\n");
  }
  void writeConstants(FinalFiles& files) const;
  void writeData(FinalFiles& files, const std::vector<Entry>& entries, const std::vector<uint64_t>& samples) const;
  void writeAnnotations(FinalFiles& files, const std::vector<Entry>& entries) const;
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

void NuScenes::writeConstants(FinalFiles& files) const {
  Json categories = Json::array(), sensors = Json::array(), mounted = Json::array();
  const auto addCategory = [&](const std::string& name) {
    categories.push_back({{"token", token("category/" + name)}, {"name", name}, {"description", ""}});
    if (output_.lidarseg) categories.back()["index"] = categories.size() - 1;
  };
  if (output_.lidarseg) addCategory(kNoise);
  for (const Class& category : drive_.classes)
    if (!output_.lidarseg || category.name != kNoise) addCategory(category.name);
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
  for (const char* name : {"moving", "standing", "vehicle.moving", "vehicle.stopped", "vehicle.parked",
                           "pedestrian.moving", "pedestrian.standing"})
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
  Json sampleRows = Json::array(), rows = Json::array(), poses = Json::array(), labels = Json::array();
  for (size_t i = 0; i < samples.size(); ++i) {
    const auto first = std::ranges::lower_bound(entries, samples[i], {}, &Entry::frame);  // its first scan
    sampleRows.push_back({{"token", token("sample", samples[i])},
                          {"timestamp", microseconds(first->scan.planned.time)},
                          {"prev", i == 0 ? "" : token("sample", samples[i - 1])},
                          {"next", i + 1 == samples.size() ? "" : token("sample", samples[i + 1])},
                          {"scene_token", token("scene")}});
  }
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
      if (entry.key)
        labels.push_back(
            {{"token", dataToken(scan)}, {"sample_data_token", dataToken(scan)}, {"filename", labelFileOf(scan)}});
    }
  }
  if (output_.lidarseg) write(files, "lidarseg", labels);
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
    double visibility = NAN;
    const Box* box = nullptr;
    bool isOfFirst = false;  // whether the box is that of the output's first sensor
  };
  std::map<size_t, std::map<uint64_t, Sight>> sights;  // by actor and sample
  std::set<size_t> moving;                             // actors that a scan shows moving, as a clip may move them
  for (const Entry& entry : entries) {
    for (const Box& box : entry.scan.boxes)
      if (box.moving) moving.insert(box.actor);
    if (!entry.key) continue;
    for (const Box& box : entry.scan.boxes) {
      Sight& sight = sights[box.actor][entry.frame];
      sight.points += box.points;
      // The first sensor's box counts, so that from sample to sample the actor is where the same sensor passed over it.
      const bool isOfFirst = entry.scan.planned.sensor == output_.sensors.front();
      if (!sight.box || isOfFirst || (!sight.isOfFirst && box.points > sight.box->points)) {
        sight.box = &box;
        sight.isOfFirst = isOfFirst;
      }
      sight.visibility = std::fmax(sight.visibility, box.visibility);  // the number, if one of them is NaN
    }
  }
  Json rows = Json::array(), instances = Json::array();
  for (const auto& [actor, bySample] : sights) {
    std::vector<uint64_t> seen;
    for (const auto& [sample, sight] : bySample) seen.push_back(sample);
    const std::string& category = drive_.classes[drive_.actors[actor].category].name;
    const bool everMoves = moving.contains(actor) ||
                           drive_.actors[actor].trajectory.movesWithin(drive_.start, drive_.start + drive_.duration);
    for (size_t i = 0; i < seen.size(); ++i) {
      const Sight& sight = bySample.at(seen[i]);
      const Box& box = *sight.box;
      const std::string attribute = attributeOf(category, box.moving, everMoves);
      rows.push_back({{"token", token("annotation", actor, seen[i])},
                      {"sample_token", token("sample", seen[i])},
                      {"instance_token", token("instance", actor)},
                      {"visibility_token", std::to_string(visibilityBin(sight.visibility))},
                      {"attribute_tokens", attribute.empty() ? Json::array() : Json::array({token(attribute)})},
                      {"translation", listOf(box.inWorld.position)},
                      {"size", {box.size.y, box.size.x, box.size.z}},
                      {"rotation", turnOf(box.inWorld.orientation)},
                      {"prev", i == 0 ? "" : token("annotation", actor, seen[i - 1])},
                      {"next", i + 1 == seen.size() ? "" : token("annotation", actor, seen[i + 1])},
                      {"num_lidar_pts", sight.points},
                      {"num_radar_pts", 0}});
    }
    instances.push_back({{"token", token("instance", actor)},
                         {"category_token", token("category/" + category)},
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
