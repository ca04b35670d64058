// SPDX-License-Identifier: Apache-2.0
// Poses over time, and the files that they come from.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gnosphere/simulator.hpp"

namespace gnosphere::drive {

inline constexpr double kGravity = 9.80665;  ///< m/s^2, standard gravity

/// A list of poses at ascending times. Between stamps positions are linear and orientations turn by slerp; before the
/// first and after the last stamp the pose is constant.
class Trajectory {
 public:
  using Stamp = SensorMotion::Stamp;

  /// A trajectory that stands at the origin.
  Trajectory() : Trajectory(std::vector<Stamp>{{}}) {}
  /// Throws Error(format) unless there are stamps, and their times ascend.
  explicit Trajectory(std::vector<Stamp> stamps);

  Pose at(double time) const;
  double begin() const { return motion_.stamps.front().time; }
  double end() const { return motion_.stamps.back().time; }
  /// How an inertial unit moves at a time, as it measures it, but for gravity.
  struct Rates {
    Vec3 velocity;      ///< m/s in the world frame
    Vec3 acceleration;  ///< m/s^2 in the world frame
    Vec3 turnRate;      ///< rad/s about the axes of the unit
  };
  /// Returns the rates of the parabola through three stamps about `time`, at least 0.05 s apart where the trajectory is
  /// that long: positions between stamps lie on straight lines, whose second derivative tells nothing.
  /// The unit is mounted on the vehicle at the pose `mount`, about whose axes the turn rate is.
  Rates ratesAt(double time, const Pose& mount = {}) const;
  static constexpr double kAround = 0.05;  ///< seconds before and after a time within which a speed is taken
  /// The times before and after a time between which a speed is taken. The pose is constant before and after the
  /// trajectory, so they lie on one side of its ends.
  struct Span {
    double from = 0, to = 0;
  };
  Span around(double time) const;
  /// The velocity in m/s of the mean of this span.
  Vec3 velocityAt(double time) const;
  bool covers(double time) const { return time >= begin() && time <= end(); }
  /// Whether the pose changes between two times.
  bool movesWithin(double from, double to) const;
  /// Times of the stamps between two times, both excluded.
  std::vector<double> timesWithin(double from, double to) const;
  const std::vector<Stamp>& stamps() const { return motion_.stamps; }

 private:
  SensorMotion motion_;
};

/// Returns the yaw in radians at every stamp of a vehicle that looks along its way, as headAlong() turns it.
std::vector<double> yawsAlong(const std::vector<Trajectory::Stamp>& stamps);

/// Turns every pose so that x points along the way, level, except for the poses that are `turned` already. Between two
/// stamps a vehicle looks along its way, and around a stamp where the way bends it turns within half a second before
/// and after it, or half of a shorter way: poses are inserted where such a turn begins and ends. A vehicle that stands
/// keeps its direction. Next to a pose that was turned already, the vehicle turns all the way between the two stamps.
void headAlong(std::vector<Trajectory::Stamp>& stamps, const std::vector<bool>& turned = {});

/// Choices that a trajectory file leaves open.
struct TrajectoryFileOptions {
  std::filesystem::path times;  ///< KITTI: the file with the time of each pose
  std::string route;            ///< CARLA routes: the id of the route; if empty, the first
  double speed = 0;             ///< CARLA routes: metres a second
};

/// Reads lines `t x y z qx qy qz qw` (TUM); # begins a comment, further numbers on a line are ignored. The times need
/// not ascend. Throws Error(format) that names the first invalid line, or Error(file) if the file cannot be read.
std::vector<Trajectory::Stamp> readTum(const std::filesystem::path& file);

/// Reads a trajectory file, format "tum", "kitti", "euroc", "nuscenes", "carla" or "carla-route", as docs/drives.md
/// describes them. Throws Error(file) or Error(format) if the file cannot be read or is invalid.
std::vector<Trajectory::Stamp> readTrajectory(const std::filesystem::path& file, const std::string& format,
                                              const TrajectoryFileOptions& options);

}  // namespace gnosphere::drive
