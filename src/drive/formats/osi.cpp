// SPDX-License-Identifier: Apache-2.0
// YYYYMMDDThhmmssZ_sd_370_300_COUNT_NAME.osi: a trace of ASAM OSI 3.7.0 per sensor, with the conventional name: the
// time of the first frame, the type, the versions of OSI and protobuf, the number of messages, a name. Each message is
// a SensorData with the detections of one scan, behind its length in bytes as a little-endian u32.
#include <cmath>
#include <protozero/pbf_builder.hpp>

#include "base/file.hpp"
#include "drive/bytes.hpp"
#include "drive/formats/format.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::drive {
namespace {

// The numbers of the fields that are written, by message.
using Tag = protozero::pbf_tag_type;
// osi_version.proto
enum class InterfaceVersion : Tag { versionMajor = 1, versionMinor = 2, versionPatch = 3 };
// osi_common.proto
enum class Timestamp : Tag { seconds = 1, nanos = 2 };
enum class Identifier : Tag { value = 1 };
enum class Vector3d : Tag { x = 1, y = 2, z = 3 };
enum class Orientation3d : Tag { roll = 1, pitch = 2, yaw = 3 };
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
enum class LidarDetection : Tag { objectId = 2, position = 3, intensity = 7, classification = 9 };
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
void addVersion(protozero::pbf_builder<Message>& parent, Message field) {
  protozero::pbf_builder<InterfaceVersion> version(parent, field);
  version.add_uint32(InterfaceVersion::versionMajor, 3);
  version.add_uint32(InterfaceVersion::versionMinor, 7);
  version.add_uint32(InterfaceVersion::versionPatch, 0);
}

template <typename Message>
void addTime(protozero::pbf_builder<Message>& parent, Message field, int64_t nanoseconds) {
  constexpr int64_t kSecond = 1'000'000'000;
  const int64_t nanos = (nanoseconds % kSecond + kSecond) % kSecond;
  protozero::pbf_builder<Timestamp> time(parent, field);
  time.add_int64(Timestamp::seconds, (nanoseconds - nanos) / kSecond);
  time.add_uint32(Timestamp::nanos, static_cast<uint32_t>(nanos));
}

template <typename Message>
void addIdentifier(protozero::pbf_builder<Message>& parent, Message field, uint64_t value) {
  protozero::pbf_builder<Identifier>(parent, field).add_uint64(Identifier::value, value);
}

template <typename Message>
void addMounting(protozero::pbf_builder<Message>& parent, Message field, const Pose& pose) {
  protozero::pbf_builder<MountingPosition> mounting(parent, field);
  {
    protozero::pbf_builder<Vector3d> position(mounting, MountingPosition::position);
    position.add_double(Vector3d::x, pose.position.x);
    position.add_double(Vector3d::y, pose.position.y);
    position.add_double(Vector3d::z, pose.position.z);
  }
  const auto [yaw, pitch, roll] = yawPitchRollOf(pose.orientation);
  protozero::pbf_builder<Orientation3d> orientation(mounting, MountingPosition::orientation);
  orientation.add_double(Orientation3d::roll, roll);
  orientation.add_double(Orientation3d::pitch, pitch);
  orientation.add_double(Orientation3d::yaw, yaw);
}

class Osi : public Format {
 public:
  Osi(const Drive& drive, const World& world, const Output& output)
      : Format(drive, world, output), scanCounts_(drive.sensors.size()) {
    for (uint64_t frame = 0; frame < drive.frameCount(); ++frame)
      for (const PlannedScan& planned : scansOf(drive, frame)) ++scanCounts_[planned.sensor];
  }

  std::vector<Field> fields() const override { return {Field::intensity}; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    for (size_t sensor : output_.sensors) {
      std::string bytes;
      for (const RecordedScan& recorded : frame.scans) {
        if (recorded.planned.sensor != sensor) continue;
        const std::string message = messageOf(recorded);
        append(bytes, static_cast<uint32_t>(message.size()));
        bytes += message;
      }
      if (!bytes.empty()) files.push_back({partPath(sensor, frame.frame), std::move(bytes), tracePath(sensor)});
    }
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override {
    for (size_t sensor : output_.sensors) files.addMade(tracePath(sensor), [&] { writeTrace(sensor, frames, files); });
  }

 private:
  /// Makes the trace of a sensor of the parts of all frames.
  void writeTrace(size_t sensor, const std::vector<FrameSummary>& frames, const FinalFiles& files) const {
    AtomicFile trace(files / tracePath(sensor), partOf(files / tracePath(sensor)));
    for (uint64_t frame = 0; frame < frames.size(); ++frame) {
      const std::vector<ScanSummary>& scans = frames[frame].scans;
      if (std::any_of(scans.begin(), scans.end(), [&](const ScanSummary& s) { return s.planned.sensor == sensor; }))
        trace.write(readWholeFile(files / partPath(sensor, frame)));
    }
    trace.commit();
  }

  std::string tracePath(size_t sensor) const {
    const std::string date = dateText(unixNanoseconds(drive_, drive_.start));
    const std::string day = date.substr(0, 4) + date.substr(5, 2) + date.substr(8, 2);
    const std::string time = date.substr(11, 2) + date.substr(14, 2) + date.substr(17, 2);
    return path(day + "T" + time + "Z_sd_370_300_" + std::to_string(scanCounts_[sensor]) + "_" +
                drive_.sensors[sensor].name + ".osi");
  }

  /// Objects have their own numbers, and sensors those after the last object.
  uint64_t identifierOf(size_t sensor) const { return world_.scene().instances.size() + sensor; }

  std::string messageOf(const RecordedScan& recorded) const {
    std::string bytes;
    protozero::pbf_builder<SensorData> message(bytes);
    addSensorData(message, recorded);
    return bytes;  // the outermost message has no length that its end would write
  }

  void addSensorData(protozero::pbf_builder<SensorData>& message, const RecordedScan& recorded) const {
    const auto& [sensor, number, time] = recorded.planned;
    const int64_t begin = unixNanoseconds(drive_, time), end = unixNanoseconds(drive_, time + recorded.duration);
    const Pose& mount = drive_.sensors[sensor].mount;
    addVersion(message, SensorData::version);
    addTime(message, SensorData::timestamp, end);
    addIdentifier(message, SensorData::sensorId, identifierOf(sensor));
    addMounting(message, SensorData::mountingPosition, mount);
    addTime(message, SensorData::lastMeasurementTime, end);
    protozero::pbf_builder<FeatureData> features(message, SensorData::featureData);
    addVersion(features, FeatureData::version);
    protozero::pbf_builder<LidarDetectionData> lidar(features, FeatureData::lidarSensor);
    {
      protozero::pbf_builder<SensorDetectionHeader> header(lidar, LidarDetectionData::header);
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
  void addDetections(protozero::pbf_builder<LidarDetectionData>& lidar, const RecordedScan& recorded) const {
    const Scan& scan = recorded.scan;
    const bool strong = scan.has(Field::intensity);
    const auto intensities = strong ? scan.column<float>(Field::intensity) : ColumnView<float>();
    const double percent = intensityFactor(drive_.sensors[recorded.planned.sensor], 100);
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
      if (!scan.returned(entry)) continue;
      const double x = scan.points[3 * entry], y = scan.points[3 * entry + 1], z = scan.points[3 * entry + 2];
      const uint32_t object = scan.instances[entry];
      protozero::pbf_builder<LidarDetection> detection(lidar, LidarDetectionData::detection);
      addIdentifier(detection, LidarDetection::objectId, object == kNoTriangle ? kNoObject : object);
      {
        protozero::pbf_builder<Spherical3d> position(detection, LidarDetection::position);
        position.add_double(Spherical3d::distance, lengthOf({x, y, z}));
        position.add_double(Spherical3d::azimuth, std::atan2(y, x));
        position.add_double(Spherical3d::elevation, std::atan2(z, lengthOf(x, y)));
      }
      if (strong) detection.add_double(LidarDetection::intensity, percent * intensities[entry]);
      if (object == kNoTriangle) detection.add_enum(LidarDetection::classification, kClutter);
    }
  }

  std::vector<uint64_t> scanCounts_;  // by sensor
};

}  // namespace

std::unique_ptr<Format> makeOsi(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<Osi>(drive, world, output);
}

}  // namespace gnosphere::drive
