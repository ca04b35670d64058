// SPDX-License-Identifier: Apache-2.0
// drive.mcap: ROS 2 messages, sensor_msgs/PointCloud2 on /NAME/points and tf2_msgs/TFMessage on /tf and /tf_static.
// metadata.yaml beside it makes the folder a bag of rosbag2, version 5 of its format (ROS 2 Humble and later).
#include <map>

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
constexpr uint16_t kTf = 1, kTfStatic = 2, kFirstCloud = 3;

std::vector<McapSchema> schemas() {
  return {{"tf2_msgs/msg/TFMessage",
           std::string("geometry_msgs/TransformStamped[] transforms\n") + kLine +
               "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
               "geometry_msgs/Transform transform\n" +
               kLine +
               "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
               "geometry_msgs/Quaternion rotation\n" +
               kLine + "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n" + kLine +
               "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n" + kLine + kHeaderText},
          {"sensor_msgs/msg/PointCloud2",
           std::string("std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
                       "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n") +
               kLine +
               "MSG: sensor_msgs/PointField\nuint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\n"
               "uint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\n"
               "uint8 datatype\nuint32 count\n" +
               kLine + kHeaderText}};
}

/// A field of the cloud. The names are those that drivers use.
struct CloudField {
  const char* name;
  Field field;
  uint32_t offset;
};
constexpr uint32_t kIntensityOffset = 12;
constexpr CloudField kFields[] = {{"x", Field::x, 0},
                                  {"y", Field::y, 4},
                                  {"z", Field::z, 8},
                                  {"intensity", Field::intensity, kIntensityOffset},
                                  {"time", Field::time, 16},
                                  {"ring", Field::ring, 20},
                                  {"class", Field::classId, 22},
                                  {"instance", Field::instance, 24}};
constexpr uint32_t kCloudPointBytes = 28;
constexpr size_t kCloudHeadBytes = 512, kTransformBytes = 160;  // about

uint8_t datatypeOf(ValueType type) {
  switch (type) {
    case ValueType::u8: return 2;
    case ValueType::u16: return 4;
    case ValueType::u32: return 6;
    case ValueType::f64: return 8;
    case ValueType::f32: break;
  }
  return 7;
}

struct StampedTransform {
  int64_t time;
  std::string parent, child;
  Pose pose;
};

void appendTf(std::string& bytes, const std::vector<StampedTransform>& transforms) {
  CdrWriter cdr(bytes);
  cdr.number(static_cast<uint32_t>(transforms.size()));
  for (const StampedTransform& transform : transforms) {
    const auto& [p, q] = transform.pose;
    cdr.header(transform.time, transform.parent).text(transform.child);
    for (double value : {p.x, p.y, p.z, q.x, q.y, q.z, q.w}) cdr.number(value);
  }
}

class Mcap : public Format {
 public:
  using Format::Format;

  std::vector<Field> fields() const override { return {Field::intensity, Field::time, Field::ring, Field::classId}; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    std::vector<McapMessage> messages;
    const auto addTf = [&](uint16_t channel, uint64_t number, int64_t time, std::vector<StampedTransform> transforms) {
      messages.push_back({channel, static_cast<uint32_t>(number), time, transforms.size() * kTransformBytes,
                          [transforms = std::move(transforms)](std::string& bytes) { appendTf(bytes, transforms); }});
    };
    if (frame.frame == 0) addTf(kTfStatic, 0, timeOf(drive_.start), mounts());
    uint64_t number = frame.frame * posesPerFrame(drive_);
    for (const double time : poseTimes(drive_, frame.frame, frame.frame + 1 == drive_.frameCount()))
      addTf(kTf, number++, timeOf(time), {{timeOf(time), "map", "base_link", drive_.ego.at(time)}});
    for (const RecordedScan& recorded : frame.scans) {
      if (!writes(recorded.planned.sensor)) continue;
      // A driver sends a cloud when the scan is over; the stamp in its header is that of its first beam.
      messages.push_back({channelOf(recorded.planned.sensor), static_cast<uint32_t>(recorded.planned.number),
                          timeOf(recorded.planned.time + recorded.duration),
                          kCloudHeadBytes + recorded.points * kCloudPointBytes,
                          [&](std::string& bytes) { appendCloud(bytes, recorded); }});
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
    std::vector<McapChannel> channels = {{1, "/tf", false}, {1, "/tf_static", true}};
    for (size_t sensor : output_.sensors) channels.push_back({2, topicOf(drive_.sensors[sensor], "/points"), false});
    return channels;
  }

  /// Returns what rosbag2 wants to know of a bag before it opens its file.
  std::string metadata(const std::vector<FrameSummary>& frames) const {
    // The first and the last message are poses of the vehicle.
    const std::vector<double> last = poseTimes(drive_, frames.size() - 1, true);
    const int64_t begin = timeOf(drive_.start), duration = timeOf(last.back()) - begin;
    std::map<uint16_t, uint64_t> counts = {{kTf, (frames.size() - 1) * posesPerFrame(drive_) + last.size()},
                                           {kTfStatic, 1}};
    eachScan(frames, [&](const ScanSummary& scan) { ++counts[channelOf(scan.planned.sensor)]; });
    uint64_t messages = 0;
    std::string topics;
    const std::vector<McapChannel> all = channels();
    for (size_t i = 0; i < all.size(); ++i) {
      const uint64_t count = counts[static_cast<uint16_t>(i + 1)];
      messages += count;
      topics += "    - topic_metadata:\n        name: " + all[i].topic +
                "\n        type: " + schemas()[all[i].schema - 1].name +
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
  uint16_t channelOf(size_t sensor) const {
    const auto at = std::find(output_.sensors.begin(), output_.sensors.end(), sensor) - output_.sensors.begin();
    return static_cast<uint16_t>(kFirstCloud + at);
  }

  std::vector<StampedTransform> mounts() const {
    std::vector<StampedTransform> transforms;
    for (size_t sensor : output_.sensors)
      transforms.push_back(
          {timeOf(drive_.start), "base_link", drive_.sensors[sensor].name, drive_.sensors[sensor].mount});
    return transforms;
  }

  void appendCloud(std::string& bytes, const RecordedScan& recorded) const {
    RecordLayout layout;
    layout.compact = true;
    layout.stride = kCloudPointBytes;
    std::vector<CloudField> fields;
    for (const CloudField& field : kFields)
      if (recorded.scan.has(field.field) || field.field == Field::ring) fields.push_back(field);
    for (const CloudField& field : fields)
      layout.values.push_back({field.field, 0, field.offset, fieldInfo(field.field).type});
    const RigSensor& sensor = drive_.sensors[recorded.planned.sensor];
    const auto count = static_cast<uint32_t>(recorded.points);
    CdrWriter cdr(bytes);
    cdr.header(timeOf(recorded.planned.time), sensor.name);
    cdr.number(uint32_t{1}).number(count).number(static_cast<uint32_t>(fields.size()));
    for (const CloudField& field : fields)
      cdr.text(field.name).number(field.offset).number(datatypeOf(fieldInfo(field.field).type)).number(uint32_t{1});
    cdr.number(uint8_t{0}).number(kCloudPointBytes).number(count * kCloudPointBytes);
    cdr.blob([&](std::string& rows) {
      const size_t first = rows.size();
      appendRows(rows, recorded.scan, layout);
      const auto own = std::as_writable_bytes(std::span(rows)).subspan(first);
      if (recorded.scan.has(Field::intensity))
        scaleFloat(own, kCloudPointBytes, kIntensityOffset, intensityFactor(sensor, 1));
    });
    cdr.number(uint8_t{1});
  }
};

}  // namespace

std::unique_ptr<Format> makeMcap(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<Mcap>(drive, world, output);
}

}  // namespace gnosphere::drive
