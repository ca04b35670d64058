// SPDX-License-Identifier: Apache-2.0
// drive.mcap: the messages of ROS 2 that a drive has live, too, but for the clock: clouds on /NAME/points, laser scans
// of flat sensors on /NAME/scan, measurements of an inertial unit on /NAME/data, transforms on /tf and /tf_static,
// the way of the vehicle on /odom.
// metadata.yaml beside it makes the folder a bag of rosbag2, version 5 of its format (ROS 2 Humble and later).
#include <map>

#include "base/json_text.hpp"
#include "drive/formats/format.hpp"
#include "drive/formats/mcap_file.hpp"
#include "drive/formats/ros2_messages.hpp"
#include "drive/ros.hpp"

namespace gnosphere::drive {
namespace {

using ros2::MessageType;

constexpr uint16_t kTf = 1, kTfStatic = 2, kFirstCloud = 3;                                             // channels
constexpr size_t kHeadBytes = 512, kTransformBytes = 160, kMostDriverBytes = 48, kOdometryBytes = 512;  // about

class Mcap : public Format {
 public:
  Mcap(const Drive& drive, const World& world, const Output& output) : Format(drive, world, output) {
    for (const size_t sensor : output.sensors)
      if (isFlat(drive.sensors[sensor].sensor)) flat_.push_back(sensor);
  }

  std::vector<Field> fields() const override { return output_.fields; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    std::vector<McapMessage> messages;
    const auto add = [&](uint16_t channel, uint64_t number, int64_t time, size_t bytes, auto make) {
      messages.push_back({channel, static_cast<uint32_t>(number), time, kHeadBytes + bytes,
                          [make](std::string& to) { appendMessage(to, make()); }});
    };
    const bool last = frame.frame + 1 == drive_.frameCount();
    if (frame.frame == 0)
      add(kTfStatic, 0, timeOf(drive_.start), kTransformBytes * output_.sensors.size(),
          [this] { return mountsOf(drive_, output_.sensors); });
    uint64_t number = frame.frame * posesPerFrame(drive_);
    for (const double time : poseTimes(drive_, frame.frame, last)) {
      add(kTf, number, timeOf(time), 0, [this, time] { return vehicleMessage(drive_, time); });
      add(odometryChannel(), number++, timeOf(time), kOdometryBytes,
          [this, time] { return odometryMessage(drive_, time); });
    }
    if (drive_.imu) {
      uint64_t measured = firstMeasurement(drive_, frame.frame);
      for (const double time : imuTimes(drive_, frame.frame, last))
        add(imuChannel(), measured++, timeOf(time), 0, [this, time] { return imuMessage(drive_, time); });
    }
    const size_t pointBytes = std::max(kMostDriverBytes, layoutOf(output_.fields).stride);
    for (const RecordedScan& recorded : frame.scans) {
      const size_t sensor = recorded.planned.sensor;
      if (!writes(sensor)) continue;
      // A driver sends a cloud when the scan is over; the stamp in its header is that of its first beam.
      const int64_t end = timeOf(recorded.planned.time + recorded.duration);
      add(cloudChannel(sensor), recorded.planned.number, end, pointBytes * recorded.points,
          [&] { return cloudMessage(drive_, recorded, output_.fields); });
      if (hasLaserScans(sensor))
        add(laserChannel(sensor), recorded.planned.number, end, 2 * sizeof(float) * recorded.scan.beamCount(),
            [&] { return laserMessage(drive_, recorded); });
    }
    files.push_back({chunkPath(frame.frame), mcapChunk(std::move(messages)), path("drive.mcap")});
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override {
    const std::string bag = path("drive.mcap");
    files.addMade(bag, [&] {
      std::vector<std::filesystem::path> chunks;
      for (uint64_t frame = 0; frame < frames.size(); ++frame) chunks.push_back(files / chunkPath(frame));
      writeMcap(files / bag, messageSchemas(), channels(), chunks);
    });
    files.write(path("metadata.yaml"), metadata(frames));
  }

 private:
  std::vector<McapChannel> channels() const {
    std::vector<McapChannel> channels;
    const auto add = [&](MessageType type, const std::string& topic, bool latched = false) {
      channels.push_back({schemaOf(type), topic, latched});
    };
    add(MessageType::transforms, "/tf");
    add(MessageType::transforms, "/tf_static", true);
    for (const size_t index : output_.sensors)
      add(cloudTypeOf(drive_.sensors[index]), topicOf(drive_.sensors[index].name, "/points"));
    for (const size_t index : flat_) add(MessageType::laserScan, topicOf(drive_.sensors[index].name, "/scan"));
    if (drive_.imu) add(MessageType::imu, topicOf(drive_.imu->name, "/data"));
    add(MessageType::odometry, "/odom");
    return channels;
  }

  /// Returns metadata.yaml, which rosbag2 reads before it opens the file of a bag.
  std::string metadata(const std::vector<FrameSummary>& frames) const {
    // The first message is a pose of the vehicle, and the last one such a pose or a measurement.
    const uint64_t lastFrame = frames.size() - 1;
    const std::vector<double> last = poseTimes(drive_, lastFrame, true);
    const std::vector<double> measured = drive_.imu ? imuTimes(drive_, lastFrame, true) : last;
    const int64_t begin = timeOf(drive_.start), duration = timeOf(std::max(last.back(), measured.back())) - begin;
    std::map<uint16_t, uint64_t> counts = {{kTf, lastFrame * posesPerFrame(drive_) + last.size()}, {kTfStatic, 1}};
    eachScan(frames, [&](const ScanSummary& scan) {
      ++counts[cloudChannel(scan.planned.sensor)];
      if (hasLaserScans(scan.planned.sensor)) ++counts[laserChannel(scan.planned.sensor)];
    });
    counts[odometryChannel()] = counts[kTf];
    if (drive_.imu) counts[imuChannel()] = firstMeasurement(drive_, lastFrame) + measured.size();
    uint64_t messages = 0;
    std::string topics;
    const std::vector<McapChannel> all = channels();
    const std::vector<McapSchema> types = messageSchemas();
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
  bool hasLaserScans(size_t sensor) const { return std::ranges::count(flat_, sensor) > 0; }
  static uint16_t placeOf(size_t sensor, const std::vector<size_t>& sensors) {
    return static_cast<uint16_t>(std::find(sensors.begin(), sensors.end(), sensor) - sensors.begin());
  }
  uint16_t cloudChannel(size_t sensor) const { return kFirstCloud + placeOf(sensor, output_.sensors); }
  uint16_t laserChannel(size_t sensor) const {
    return static_cast<uint16_t>(kFirstCloud + output_.sensors.size() + placeOf(sensor, flat_));
  }
  uint16_t imuChannel() const { return static_cast<uint16_t>(kFirstCloud + output_.sensors.size() + flat_.size()); }
  uint16_t odometryChannel() const { return static_cast<uint16_t>(imuChannel() + (drive_.imu ? 1 : 0)); }

  std::vector<size_t> flat_;  // of the output's sensors, those whose scans are laser scans, too
};

}  // namespace

std::unique_ptr<Format> makeMcap(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<Mcap>(drive, world, output);
}

}  // namespace gnosphere::drive
