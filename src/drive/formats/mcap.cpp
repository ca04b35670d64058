// SPDX-License-Identifier: Apache-2.0
// drive.mcap: ROS 2 messages, sensor_msgs/PointCloud2 on /NAME/points, tf2_msgs/TFMessage on /tf and /tf_static, and
// sensor_msgs/Imu on /NAME/data, sensor_msgs/LaserScan of flat sensors on /NAME/scan.
// metadata.yaml beside it makes the folder a bag of rosbag2, version 5 of its format (ROS 2 Humble and later).
#include <array>
#include <functional>
#include <map>
#include <tuple>

#include "base/json_text.hpp"
#include "drive/formats/cdr.hpp"
#include "drive/formats/format.hpp"
#include "drive/formats/mcap_file.hpp"
#include "drive/ros.hpp"

namespace gnosphere::drive {
namespace {

constexpr const char* kLine = "================================================================================\n";
constexpr const char* kHeaderText =
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    "================================================================================\n"
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
constexpr uint16_t kTf = 1, kTfStatic = 2, kFirstCloud = 3;  // channels

enum Schema : uint16_t { kTransforms = 1, kCloud, kImu, kLaser };

/// In the order of Schema.
std::vector<McapSchema> schemas() {
  const std::string vector = kLine + std::string("MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n");
  const std::string quaternion =
      kLine + std::string("MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
  const std::string header = std::string(kLine) + kHeaderText;
  return {{"tf2_msgs/msg/TFMessage",
           std::string("geometry_msgs/TransformStamped[] transforms\n") + kLine +
               "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
               "geometry_msgs/Transform transform\n" +
               kLine +
               "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
               "geometry_msgs/Quaternion rotation\n" +
               vector + quaternion + header},
          {"sensor_msgs/msg/PointCloud2",
           std::string("std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
                       "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n") +
               kLine +
               "MSG: sensor_msgs/PointField\nuint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\n"
               "uint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\n"
               "uint8 datatype\nuint32 count\n" +
               header},
          {"sensor_msgs/msg/Imu",
           "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
           "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
           "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n" +
               vector + quaternion + header},
          {"sensor_msgs/msg/LaserScan",
           "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
           "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\n"
           "float32[] intensities\n" +
               header}};
}

constexpr size_t kHeadBytes = 512, kTransformBytes = 160, kImuBytes = 340;  // about

void appendTf(std::string& bytes, const ros2::Transforms& transforms) {
  CdrWriter cdr(bytes);
  cdr.number(static_cast<uint32_t>(transforms.size()));
  for (const ros2::StampedTransform& transform : transforms) {
    const auto& [p, q] = transform.pose;
    cdr.header(transform.stamp, transform.parent).text(transform.child);
    for (double value : {p.x, p.y, p.z, q.x, q.y, q.z, q.w}) cdr.number(value);
  }
}

void appendCloud(std::string& bytes, const ros2::PointCloud2& cloud) {
  CdrWriter cdr(bytes);
  cdr.header(cloud.stamp, cloud.frame);
  cdr.number(cloud.height).number(cloud.width).number(static_cast<uint32_t>(cloud.fields.size()));
  for (const ros2::PointField& field : cloud.fields)
    cdr.text(field.name).number(field.offset).number(static_cast<uint8_t>(field.type)).number(field.count);
  cdr.number(uint8_t{0}).number(cloud.pointStep).number(cloud.width * cloud.pointStep);
  cdr.blob([&](std::string& to) { to.append(reinterpret_cast<const char*>(cloud.data.data()), cloud.data.size()); });
  cdr.number(uint8_t{cloud.dense});
}

void appendImu(std::string& bytes, const ros2::Imu& imu) {
  const auto& [q, w, a] = std::tie(imu.orientation, imu.angularVelocity, imu.linearAcceleration);
  CdrWriter cdr(bytes);
  cdr.header(imu.stamp, imu.frame);
  const auto numbers = [&](const auto& values) {
    for (const double value : values) cdr.number(value);
  };
  numbers(std::array{q.x, q.y, q.z, q.w});
  numbers(imu.orientationCovariance);
  numbers(std::array{w.x, w.y, w.z});
  numbers(imu.angularVelocityCovariance);
  numbers(std::array{a.x, a.y, a.z});
  numbers(imu.linearAccelerationCovariance);
}

void appendLaser(std::string& bytes, const ros2::LaserScan& laser) {
  CdrWriter cdr(bytes);
  cdr.header(laser.stamp, laser.frame);
  for (const float value : {laser.angleMin, laser.angleMax, laser.angleIncrement, laser.timeIncrement, laser.scanTime,
                            laser.rangeMin, laser.rangeMax})
    cdr.number(value);
  for (const std::vector<float>& list : {std::cref(laser.ranges), std::cref(laser.intensities)}) {
    cdr.number(static_cast<uint32_t>(list.size()));
    for (const float value : list) cdr.number(value);
  }
}

class Mcap : public Format {
 public:
  Mcap(const Drive& drive, const World& world, const Output& output) : Format(drive, world, output) {
    for (const size_t sensor : output.sensors)
      if (isFlat(drive.sensors[sensor].sensor)) flat_.push_back(sensor);
  }

  std::vector<Field> fields() const override { return {Field::intensity, Field::time, Field::ring, Field::classId}; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    std::vector<McapMessage> messages;
    const auto addTf = [&](uint16_t channel, uint64_t number, int64_t time, ros2::Transforms transforms) {
      messages.push_back({channel, static_cast<uint32_t>(number), time, transforms.size() * kTransformBytes,
                          [transforms = std::move(transforms)](std::string& bytes) { appendTf(bytes, transforms); }});
    };
    if (frame.frame == 0) addTf(kTfStatic, 0, timeOf(drive_.start), mountsOf(drive_, output_.sensors));
    uint64_t number = frame.frame * posesPerFrame(drive_);
    for (const double time : poseTimes(drive_, frame.frame, frame.frame + 1 == drive_.frameCount()))
      addTf(kTf, number++, timeOf(time), vehicleMessage(drive_, time));
    if (drive_.imu) {
      uint64_t measured = firstMeasurement(drive_, frame.frame);
      for (const double time : imuTimes(drive_, frame.frame, frame.frame + 1 == drive_.frameCount()))
        messages.push_back({imuChannel(), static_cast<uint32_t>(measured++), timeOf(time), kImuBytes,
                            [=, this](std::string& bytes) { appendImu(bytes, imuMessage(drive_, time)); }});
    }
    for (const RecordedScan& recorded : frame.scans) {
      if (!writes(recorded.planned.sensor)) continue;
      // A driver sends a cloud when the scan is over; the stamp in its header is that of its first beam.
      const auto scan = static_cast<uint32_t>(recorded.planned.number);
      const int64_t end = timeOf(recorded.planned.time + recorded.duration);
      ros2::PointCloud2 cloud = cloudMessage(drive_, recorded);
      messages.push_back({cloudChannel(recorded.planned.sensor), scan, end, kHeadBytes + cloud.data.size(),
                          [cloud = std::move(cloud)](std::string& bytes) { appendCloud(bytes, cloud); }});
      if (!isFlat(drive_.sensors[recorded.planned.sensor].sensor)) continue;
      ros2::LaserScan laser = laserMessage(drive_, recorded);
      messages.push_back({laserChannel(recorded.planned.sensor), scan, end, kHeadBytes + 8 * laser.ranges.size(),
                          [laser = std::move(laser)](std::string& bytes) { appendLaser(bytes, laser); }});
    }
    files.push_back({chunkPath(frame.frame), mcapChunk(std::move(messages)), path("drive.mcap")});
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override {
    const std::string bag = path("drive.mcap");
    files.addMade(bag, [&] { writeBag(frames.size(), files); });
    files.write(path("metadata.yaml"), metadata(frames));
  }

 private:
  /// Makes the bag of the chunks of all frames.
  void writeBag(uint64_t frameCount, const FinalFiles& files) const {
    std::vector<std::filesystem::path> chunks;
    for (uint64_t frame = 0; frame < frameCount; ++frame) chunks.push_back(files / chunkPath(frame));
    writeMcap(files / path("drive.mcap"), schemas(), channels(), chunks);
  }

  std::vector<McapChannel> channels() const {
    std::vector<McapChannel> channels = {{kTransforms, "/tf", false}, {kTransforms, "/tf_static", true}};
    const auto add = [&](Schema schema, size_t sensor, const char* what) {
      channels.push_back({schema, topicOf(drive_.sensors[sensor].name, what), false});
    };
    for (const size_t sensor : output_.sensors) add(kCloud, sensor, "/points");
    for (const size_t sensor : flat_) add(kLaser, sensor, "/scan");
    if (drive_.imu) channels.push_back({kImu, topicOf(drive_.imu->name, "/data"), false});
    return channels;
  }

  /// Returns what rosbag2 wants to know of a bag before it opens its file.
  std::string metadata(const std::vector<FrameSummary>& frames) const {
    // The first message is a pose of the vehicle, and the last one such a pose or a measurement.
    const uint64_t lastFrame = frames.size() - 1;
    const std::vector<double> last = poseTimes(drive_, lastFrame, true);
    const std::vector<double> measured = drive_.imu ? imuTimes(drive_, lastFrame, true) : last;
    const int64_t begin = timeOf(drive_.start), duration = timeOf(std::max(last.back(), measured.back())) - begin;
    std::map<uint16_t, uint64_t> counts = {{kTf, lastFrame * posesPerFrame(drive_) + last.size()}, {kTfStatic, 1}};
    eachScan(frames, [&](const ScanSummary& scan) {
      ++counts[cloudChannel(scan.planned.sensor)];
      if (isFlat(drive_.sensors[scan.planned.sensor].sensor)) ++counts[laserChannel(scan.planned.sensor)];
    });
    if (drive_.imu) counts[imuChannel()] = firstMeasurement(drive_, lastFrame) + measured.size();
    uint64_t messages = 0;
    std::string topics;
    const std::vector<McapChannel> all = channels();
    const std::vector<McapSchema> types = schemas();
    for (size_t i = 0; i < all.size(); ++i) {
      const uint64_t count = counts[static_cast<uint16_t>(i + 1)];
      messages += count;
      topics += "    - topic_metadata:\n        name: " + all[i].topic +
                "\n        type: " + types[all[i].schema - 1].name +
                "\n        serialization_format: cdr\n        offered_qos_profiles: " +
                jsonText(nlohmann::json(qosOf(all[i]))) + "\n      message_count: " + std::to_string(count) + "\n";
    }
    const auto span = [&](const std::string& indent) {
      return indent + "duration:\n" + indent + "  nanoseconds: " + std::to_string(duration) + "\n" + indent +
             "starting_time:\n" + indent + "  nanoseconds_since_epoch: " + std::to_string(begin) + "\n" + indent +
             "message_count: " + std::to_string(messages) + "\n";
    };
    return "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n" + span("  ") +
           "  topics_with_message_count:\n" + topics +
           "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - drive.mcap\n  "
           "files:\n" +
           "    - path: drive.mcap\n" + span("      ");
  }

  int64_t timeOf(double time) const { return unixNanoseconds(drive_, time); }
  std::string chunkPath(uint64_t frame) const { return path(numberText("chunks/%06llu", frame)); }
  static uint16_t placeOf(size_t sensor, const std::vector<size_t>& sensors) {
    return static_cast<uint16_t>(std::find(sensors.begin(), sensors.end(), sensor) - sensors.begin());
  }
  uint16_t cloudChannel(size_t sensor) const { return kFirstCloud + placeOf(sensor, output_.sensors); }
  uint16_t laserChannel(size_t sensor) const {
    return static_cast<uint16_t>(kFirstCloud + output_.sensors.size() + placeOf(sensor, flat_));
  }
  uint16_t imuChannel() const { return static_cast<uint16_t>(kFirstCloud + output_.sensors.size() + flat_.size()); }

  std::vector<size_t> flat_;  // of the output's sensors, those whose scans are laser scans, too
};

}  // namespace

std::unique_ptr<Format> makeMcap(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<Mcap>(drive, world, output);
}

}  // namespace gnosphere::drive
