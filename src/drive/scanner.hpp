// SPDX-License-Identifier: Apache-2.0
// Scans the frames of a drive.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "drive/record.hpp"

namespace gnosphere::drive {

/// Scans each frame independently of all others.
class Scanner {
 public:
  /// `fields` has, by sensor, the fields that its scans hold beside positions, ranges and times.
  Scanner(const Drive& drive, const World& world, const std::vector<std::set<Field>>& fields, SimulatorOptions options);

  /// Makes the scans of the frame that the record names.
  void scan(FrameRecord& record);
  const DeviceInfo& device() const { return simulator_->device(); }
  Plan plan(size_t sensor) const { return simulator_->plan(sensor); }

 private:
  /// Whether the plan of a sensor simulates its motion, and that of actors, within a scan, and measures radial speeds.
  struct Motions {
    bool ofSensor = false, ofActors = false, speeds = false;
  };
  SensorRequest requestOf(size_t sensor, std::set<Field> fields) const;
  /// Returns the drive's weather without the kinds that the effects of a sensor turn off. Kinds that the drive does not
  /// state, and boxes of dust, are as the effects state them. Returns none if the drive states no kind that is left.
  std::optional<Weather> weatherFor(size_t sensor, double time) const;
  void scan(RecordedScan& recorded);
  /// The sensor's poses during a scan, and at the times of beams that fire before and after it; none if it stands.
  /// There is a pose at the start, at the end, and at each of Trajectory::timesWithin(), and others between them where
  /// a sensor beside the middle of a vehicle that turns goes along an arc: often enough that chords are 0.1 mm off.
  /// A sensor that fires all beams at once has two poses, shortly before and after the scan, for its speed.
  SensorMotion motionOf(const RecordedScan& recorded) const;
  /// Warns once per sensor of an actor or a scene that turns, or moves its parts, so far within a scan that its points,
  /// which go straight, leave their ways.
  void warnOfDetours(const RecordedScan& recorded);
  /// Sets the world of the scan's start, and its motion until the scan's end.
  void placeWorld(const RecordedScan& recorded, Shot& shot);

  const Drive& drive_;
  const World& world_;
  std::vector<Transform> placed_;  // by instance, as the simulator has them
  std::optional<Simulator> simulator_;
  std::vector<Motions> motions_;  // by sensor
  std::vector<bool> warned_;      // by sensor, of points that leave their ways
  std::function<void(const std::string&)> warn_;
};

}  // namespace gnosphere::drive
