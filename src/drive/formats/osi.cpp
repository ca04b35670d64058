// SPDX-License-Identifier: Apache-2.0
// YYYYMMDDThhmmssZ_sd_370_300_COUNT_NAME.osi: a trace of ASAM OSI 3.7.0 per sensor, with the conventional name: the
// time of the first frame, the type, the versions of OSI and protobuf, the number of messages, a name. Each message is
// a SensorData with the detections of one scan, behind its length in bytes as a little-endian u32. The trace
// YYYYMMDDThhmmssZ_gt_370_300_COUNT_world.osi has a GroundTruth per frame.
#include <algorithm>
#include <cmath>

#include "base/file.hpp"
#include "drive/bytes.hpp"
#include "drive/formats/format.hpp"
#include "drive/formats/osi_ground_truth.hpp"
#include "drive/formats/osi_messages.hpp"

namespace gnosphere::drive {
namespace osi {
namespace {

// The numbers of the fields that are written, by message.
// osi_common.proto
enum class MountingPosition : Tag { position = 1, orientation = 2 };
enum class Spherical3d : Tag { distance = 1, azimuth = 2, elevation = 3 };
// osi_featuredata.proto
enum class FeatureData : Tag { version = 1, lidarSensor = 3 };
enum class LidarDetectionData : Tag { header = 1, detection = 2 };
enum class SensorDetectionHeader : Tag {
  measurementTime = 1,
  cycleCounter = 2,
  mountingPosition = 3,
  dataQualifier = 5,
  numberOfValidDetections = 6,
  sensorId = 7
};
enum class LidarDetection : Tag { objectId = 2, position = 3, intensity = 7, classification = 9, radialVelocity = 12 };
// osi_sensordata.proto
enum class SensorData : Tag {
  version = 1,
  timestamp = 2,
  sensorId = 5,
  mountingPosition = 6,
  lastMeasurementTime = 9,
  featureData = 26
};

// Values of SensorDetectionHeader.DataQualifier and DetectionClassification.
constexpr int32_t kAvailable = 2, kClutter = 3;
constexpr uint64_t kNoObject = UINT64_MAX;

template <typename Message>
void addMounting(Builder<Message>& parent, Message field, const Pose& pose) {
  Builder<MountingPosition> mounting(parent, field);
  addVector(mounting, MountingPosition::position, pose.position);
  addOrientation(mounting, MountingPosition::orientation, pose.orientation);
}

class Osi : public Format {
 public:
  Osi(const Drive& drive, const World& world, const Output& output)
      : Format(drive, world, output), truth_(drive, world), scanCounts_(drive.sensors.size()) {
    for (uint64_t frame = 0; frame < drive.frameCount(); ++frame)
      for (const PlannedScan& planned : scansOf(drive, frame)) ++scanCounts_[planned.sensor];
  }

  std::vector<Field> fields() const override {
    std::vector<Field> fields = output_.fields;
    fields.push_back(Field::intensity);
    return fields;
  }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    for (size_t sensor : output_.sensors) {
      std::string bytes;
      for (const RecordedScan& recorded : frame.scans)
        if (recorded.planned.sensor == sensor) appendMessage(bytes, messageOf(recorded));
      if (!bytes.empty()) files.push_back({partPath(sensor, frame.frame), std::move(bytes), tracePath(sensor)});
    }
    std::string bytes;
    appendMessage(bytes, truth_.messageAt(drive_.start + static_cast<double>(frame.frame) / drive_.rate));
    files.push_back({truthPartPath(frame.frame), std::move(bytes), truthPath()});
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override {
    for (size_t sensor : output_.sensors) {
      std::vector<std::string> parts;
      for (uint64_t frame = 0; frame < frames.size(); ++frame) {
        const std::vector<ScanSummary>& scans = frames[frame].scans;
        if (std::any_of(scans.begin(), scans.end(), [&](const ScanSummary& s) { return s.planned.sensor == sensor; }))
          parts.push_back(partPath(sensor, frame));
      }
      addTrace(tracePath(sensor), parts, files);
    }
    std::vector<std::string> parts;
    for (uint64_t frame = 0; frame < frames.size(); ++frame) parts.push_back(truthPartPath(frame));
    addTrace(truthPath(), parts, files);
  }

 private:
  static void appendMessage(std::string& bytes, const std::string& message) {
    append(bytes, static_cast<uint32_t>(message.size()));
    bytes += message;
  }

  /// Makes a trace of its parts, unless it is there.
  static void addTrace(const std::string& path, const std::vector<std::string>& parts, FinalFiles& files) {
    files.addMade(path, [&] {
      AtomicFile trace(files / path, partOf(files / path));
      for (const std::string& part : parts) trace.write(readWholeFile(files / part));
      trace.commit();
    });
  }

  std::string tracePath(size_t sensor) const {
    return tracePath("sd", scanCounts_[sensor], drive_.sensors[sensor].name);
  }
  std::string truthPath() const { return tracePath("gt", drive_.frameCount(), "world"); }
  /// No sensor has a part of this name, because names of sensors have no point.
  std::string truthPartPath(uint64_t frame) const { return path(numberText("parts/world.%06llu", frame)); }

  std::string tracePath(const std::string& type, uint64_t count, const std::string& name) const {
    const std::string date = dateText(unixNanoseconds(drive_, drive_.start));
    const std::string day = date.substr(0, 4) + date.substr(5, 2) + date.substr(8, 2);
    const std::string time = date.substr(11, 2) + date.substr(14, 2) + date.substr(17, 2);
    return path(day + "T" + time + "Z_" + type + "_370_300_" + std::to_string(count) + "_" + name + ".osi");
  }

  /// Objects have their own numbers, and sensors those after the last object.
  uint64_t identifierOf(size_t sensor) const { return world_.scene().instances.size() + sensor; }

  std::string messageOf(const RecordedScan& recorded) const {
    std::string bytes;
    Builder<SensorData> message(bytes);
    addSensorData(message, recorded);
    return bytes;  // the outermost message has no length that its end would write
  }

  void addSensorData(Builder<SensorData>& message, const RecordedScan& recorded) const {
    const auto& [sensor, number, time] = recorded.planned;
    const int64_t begin = unixNanoseconds(drive_, time), end = unixNanoseconds(drive_, time + recorded.duration);
    const Pose& mount = drive_.sensors[sensor].mount;
    addVersion(message, SensorData::version);
    addTime(message, SensorData::timestamp, end);
    addIdentifier(message, SensorData::sensorId, identifierOf(sensor));
    addMounting(message, SensorData::mountingPosition, mount);
    // Without motion a scan is of its start, although its beams are fired later.
    addTime(message, SensorData::lastMeasurementTime, recorded.sensorMoves || recorded.actorsMove ? end : begin);
    Builder<FeatureData> features(message, SensorData::featureData);
    addVersion(features, FeatureData::version);
    Builder<LidarDetectionData> lidar(features, FeatureData::lidarSensor);
    {
      Builder<SensorDetectionHeader> header(lidar, LidarDetectionData::header);
      addTime(header, SensorDetectionHeader::measurementTime, begin);
      header.add_uint64(SensorDetectionHeader::cycleCounter, number);
      addMounting(header, SensorDetectionHeader::mountingPosition, mount);
      header.add_enum(SensorDetectionHeader::dataQualifier, kAvailable);
      header.add_uint32(SensorDetectionHeader::numberOfValidDetections, static_cast<uint32_t>(recorded.points));
      addIdentifier(header, SensorDetectionHeader::sensorId, identifierOf(sensor));
    }
    addDetections(lidar, recorded);
  }

  /// Azimuths are towards the left. Elevations are upwards, as models for OSI have them; the sense of rotation in
  /// Spherical3d's comment would have them downwards.
  void addDetections(Builder<LidarDetectionData>& lidar, const RecordedScan& recorded) const {
    const Scan& scan = recorded.scan;
    const bool strong = scan.has(Field::intensity);
    const auto intensities = strong ? scan.column<float>(Field::intensity) : ColumnView<float>();
    const bool doppler = std::ranges::find(output_.fields, Field::radialSpeed) != output_.fields.end();
    const auto speeds = doppler ? scan.column<float>(Field::radialSpeed) : ColumnView<float>();
    const double percent = intensityFactor(drive_.sensors[recorded.planned.sensor], 100);
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
      if (!scan.returned(entry)) continue;
      const double x = scan.points[3 * entry], y = scan.points[3 * entry + 1], z = scan.points[3 * entry + 2];
      const uint32_t object = scan.instances[entry];
      Builder<LidarDetection> detection(lidar, LidarDetectionData::detection);
      addIdentifier(detection, LidarDetection::objectId, object == kNoTriangle ? kNoObject : object);
      {
        Builder<Spherical3d> position(detection, LidarDetection::position);
        position.add_double(Spherical3d::distance, lengthOf({x, y, z}));
        position.add_double(Spherical3d::azimuth, std::atan2(y, x));
        position.add_double(Spherical3d::elevation, std::atan2(z, lengthOf(x, y)));
      }
      if (strong) detection.add_double(LidarDetection::intensity, percent * intensities[entry]);
      if (object == kNoTriangle) detection.add_enum(LidarDetection::classification, kClutter);
      // OSI's speed is positive towards the sensor.
      if (doppler && std::isfinite(speeds[entry]))
        detection.add_double(LidarDetection::radialVelocity, -double{speeds[entry]});
    }
  }

  GroundTruthMessages truth_;
  std::vector<uint64_t> scanCounts_;  // by sensor
};

}  // namespace
}  // namespace osi

std::unique_ptr<Format> makeOsi(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<osi::Osi>(drive, world, output);
}

}  // namespace gnosphere::drive
