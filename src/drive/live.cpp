// SPDX-License-Identifier: Apache-2.0
// One thread scans ahead, and another one publishes each message when its time has come.
#include "drive/live.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <numeric>
#include <set>
#include <thread>

#include "drive/formats/format.hpp"
#include "drive/frame_queue.hpp"
#include "drive/ros.hpp"
#include "drive/scanner.hpp"

namespace gnosphere::drive {
namespace {

using ros2::MessageType;
using ros2::Publisher;
using WallClock = std::chrono::steady_clock;

/// Publishes messages when the time of the drive has come. The first one starts the clock.
class Schedule {
 public:
  Schedule(double speed, double frameSeconds, LiveReport& report)
      : speed_(speed), patience_(frameSeconds / speed / 2), report_(report) {}

  void add(double time, Publisher& publisher, ros2::Message message) {
    due_.emplace(time, Due{&publisher, std::move(message)});
  }
  /// Seconds since the first message.
  double seconds() const { return std::chrono::duration<double>(WallClock::now() - first_).count(); }
  /// Publishes everything that is due before a time of the drive.
  void runUntil(double time) {
    while (!due_.empty() && due_.begin()->first < time) {
      wait(due_.begin()->first);
      due_.begin()->second.publisher->publish(std::move(due_.begin()->second.message));
      ++report_.messages;
      due_.erase(due_.begin());
    }
  }

 private:
  struct Due {
    Publisher* publisher;
    ros2::Message message;
  };

  // Late messages are published at once. If one is too late, all later ones are delayed, rather than sent in a burst.
  void wait(double time) {
    using Seconds = std::chrono::duration<double>;
    const auto now = WallClock::now();
    if (!started_) {
      begin_ = first_ = now;
      firstTime_ = time;
    }
    started_ = true;
    // The time since the first message, because a drive may count its time from 1970, which at a low speed does not
    // fit.
    const auto at = begin_ + std::chrono::duration_cast<WallClock::duration>(Seconds((time - firstTime_) / speed_));
    if (const double late = Seconds(now - at).count(); late > patience_) {
      begin_ += now - at;
      report_.late += late;
    }
    std::this_thread::sleep_until(at);
  }

  double speed_, patience_;
  LiveReport& report_;
  std::multimap<double, Due> due_;       // by the time of the drive; in the order of adding if it is the same
  WallClock::time_point begin_, first_;  // begin_: when the first message was due, later if others were late
  double firstTime_ = 0;                 // of the first message, in the drive's time
  bool started_ = false;
};

class Live {
 public:
  /// Makes the topics of a drive. The frames before `end` are published one after another.
  Live(const Drive& drive, const LiveOptions& options, uint64_t end, LiveReport& report)
      : drive_(drive),
        end_(end),
        report_(report),
        tf_(MessageType::transforms, "/tf", optionsOf({.depth = 100})),
        mounts_(MessageType::transforms, "/tf_static",
                optionsOf({.durability = ros2::Qos::Durability::transientLocal, .depth = 1})),
        clock_(MessageType::clock, "/clock", optionsOf({.depth = 100})),
        odometry_(MessageType::odometry, "/odom", optionsOf({.depth = 100})),
        schedule_(options.speed, 1 / drive.rate, report) {
    for (const RigSensor& sensor : drive.sensors) {
      clouds_.emplace_back(cloudTypeOf(sensor), topicOf(sensor.name, "/points"), optionsOf(options.qos));
      if (isFlat(sensor.sensor))
        lasers_.emplace(clouds_.size() - 1,
                        Publisher(MessageType::laserScan, topicOf(sensor.name, "/scan"), optionsOf(options.qos)));
    }
    if (drive.imu) imu_.emplace(MessageType::imu, topicOf(drive.imu->name, "/data"), optionsOf({.depth = 1000}));
    std::vector<size_t> all(drive.sensors.size());
    std::iota(all.begin(), all.end(), size_t{0});
    mounts_.publish(mountsOf(drive, all));
    ++report_.messages;
  }

  void publish(const FrameRecord& frame) {
    for (const double time : poseTimes(drive_, frame.frame, frame.frame + 1 == end_)) {
      schedule_.add(time, clock_, ros2::Clock{stampOf(time)});
      schedule_.add(time, tf_, vehicleMessage(drive_, time));
      schedule_.add(time, odometry_, odometryMessage(drive_, time));
    }
    if (drive_.imu)
      for (const double time : imuTimes(drive_, frame.frame, frame.frame + 1 == end_))
        schedule_.add(time, *imu_, imuMessage(drive_, time));
    for (const RecordedScan& recorded : frame.scans) add(recorded);
    ++report_.frames;
    schedule_.runUntil(drive_.start + static_cast<double>(frame.frame + 1) / drive_.rate);
  }

  void finish() {
    schedule_.runUntil(1e300);
    report_.seconds = schedule_.seconds();
    for (Publisher* publisher : all()) {
      publisher->flush(2);
      report_.dropped += publisher->counts().dropped;
    }
  }

 private:
  static ros2::PublisherOptions optionsOf(const ros2::Qos& qos) {
    ros2::PublisherOptions options;
    options.qos = qos;
    return options;
  }
  int64_t stampOf(double time) const { return unixNanoseconds(drive_, time); }

  void add(const RecordedScan& recorded) {
    const size_t index = recorded.planned.sensor;
    const double end = recorded.planned.time + recorded.duration;
    schedule_.add(end, clouds_[index], cloudMessage(drive_, recorded, liveFieldsOf(drive_, index)));
    if (const auto laser = lasers_.find(index); laser != lasers_.end())
      schedule_.add(end, laser->second, laserMessage(drive_, recorded));
    ++report_.scans;
    report_.points += recorded.points;
  }

  std::vector<Publisher*> all() {
    std::vector<Publisher*> list = {&tf_, &mounts_, &clock_, &odometry_};
    if (imu_) list.push_back(&*imu_);
    for (Publisher& cloud : clouds_) list.push_back(&cloud);
    for (auto& [index, laser] : lasers_) list.push_back(&laser);
    return list;
  }

  const Drive& drive_;
  uint64_t end_;
  LiveReport& report_;
  Publisher tf_, mounts_, clock_, odometry_;
  std::optional<Publisher> imu_;
  std::vector<Publisher> clouds_;       // by sensor
  std::map<size_t, Publisher> lasers_;  // by sensor
  Schedule schedule_;
};

}  // namespace

LiveReport publishLive(const Drive& drive, const LiveOptions& options) {
  const uint64_t end = std::min(options.endFrame, drive.frameCount());
  const auto refuse = [](const std::string& text) { throw Error(ErrorCode::invalidArgument, "LiveOptions: " + text); };
  if (options.firstFrame >= end) refuse("there are no frames to publish");
  if (!(options.speed > 0)) refuse("the speed must be greater than 0");
  std::vector<size_t> sensors(drive.sensors.size());
  std::iota(sensors.begin(), sensors.end(), size_t{0});
  for (const std::string& mistake : {mistakeOfNames(drive, sensors), mistakeOfTimes(drive)})
    if (!mistake.empty()) throw Error(ErrorCode::invalidArgument, "the drive '" + drive.name + "': " + mistake);
  LiveReport report;
  const World world(drive);
  Live live(drive, options, end, report);
  std::vector<std::set<Field>> fields;
  for (const size_t sensor : sensors) {
    const std::vector<Field> published = liveFieldsOf(drive, sensor);
    fields.emplace_back(published.begin(), published.end());
  }
  Scanner scanner(drive, world, fields, options.simulator);
  report.device = scanner.device().name;
  if (options.started) options.started(scanner.device());
  FrameQueue queue([&](FrameRecord& record) {
    live.publish(record);
    if (options.progress) options.progress(report.frames, end - options.firstFrame);
  });
  std::vector<uint64_t> frames(end - options.firstFrame);
  std::iota(frames.begin(), frames.end(), options.firstFrame);
  queue.run(frames, [&](FrameRecord& record) { scanner.scan(record); });
  live.finish();
  return report;
}

}  // namespace gnosphere::drive
