// SPDX-License-Identifier: Apache-2.0
// Poses over time, and the files that they come from.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gnosphere/simulator.hpp"

namespace gnosphere::drive {

inline constexpr double kGravity = 9.80665;  ///< m/s^2, standard gravity

/// Where a vehicle looks that does not roll, in radians.
struct Direction {
  double yaw = 0, pitch = 0;  ///< the pitch is positive downhill
};

/// A straight way from one stamp of a trajectory to the next.
struct Segment {
  double duration = 0;  ///< seconds
  Direction along;      ///< of the way; where it does not move on, of the last way that does, or else of the first
  bool moves = false;   ///< on the ground plan
};

/// A list of poses at ascending times. Between stamps positions are linear and orientations turn by slerp; before the
/// first and after the last stamp the pose is constant.
class Trajectory {
 public:
  using Stamp = SensorMotion::Stamp;

  /// A trajectory that stands at the origin.
  Trajectory() : Trajectory(std::vector<Stamp>{{}}) {}
  /// Throws Error(format) unless there are stamps, and their times ascend.
  explicit Trajectory(std::vector<Stamp> stamps);
  /// Returns the trajectory of a vehicle that looks along its way, level unless it is `pitched`: then it pitches along
  /// its way, too. The stamps that are `turned` keep their orientation. Between two stamps it looks along the straight
  /// line. Around a stamp at which the way bends it turns at constant speed, from half a second before the stamp to
  /// half a second after it, or from the middle of a shorter way. While it stands it keeps its direction. Next to a
  /// turned stamp it turns by slerp all the way between the two stamps. `before` is the direction in which it comes to
  /// the first stamp, if it stands there.
  static Trajectory alongWay(std::vector<Stamp> stamps, std::vector<bool> turned = {}, bool pitched = false,
                             std::optional<Direction> before = {});

  Pose at(double time) const;
  double begin() const { return motion_.stamps.front().time; }
  double end() const { return motion_.stamps.back().time; }
  /// How an inertial unit moves at a time, as it measures it, but for gravity.
  struct Rates {
    Vec3 velocity;      ///< m/s in the world frame
    Vec3 acceleration;  ///< m/s^2 in the world frame
    Vec3 turnRate;      ///< rad/s about the axes of the unit
  };
  /// Returns the rates of the parabola through three stamps about `time`: positions between stamps lie on straight
  /// lines, whose second derivative tells nothing. The stamps are as far apart as most of the trajectory, at least
  /// about `period` seconds, so that a unit that measures as often does not see vibrations that are too fast for it,
  /// and, for velocities and accelerations, as far as their rounding demands; but no more than 0.05 s where they are
  /// denser. If the first and the last of these stamps are more than a second apart, poses half a second before and
  /// after `time` are taken in their place, and the vehicle turns as at() turns it; so does a vehicle that looks along
  /// its way. The unit is mounted on the vehicle at the pose `mount`, about whose axes the turn rate is.
  Rates ratesAt(double time, const Pose& mount = {}, double period = 0.001) const;
  /// The median time between stamps in seconds; 0 if there is one stamp.
  double spacing() const { return spacing_; }
  static constexpr double kAround = 0.05;  ///< seconds before and after a time within which a speed is taken
  /// The times before and after a time between which a speed is taken. The pose is constant before and after the
  /// trajectory, so they lie on one side of its ends.
  struct Span {
    double from = 0, to = 0;
  };
  Span around(double time, double reach = kAround) const;
  /// The velocity in m/s of the mean of this span.
  Vec3 velocityAt(double time) const;
  bool covers(double time) const { return time >= begin() && time <= end(); }
  /// Whether the pose changes between two times.
  bool movesWithin(double from, double to) const;
  /// Returns the times between two times, both excluded, at which there is a stamp, or a turn begins or ends.
  std::vector<double> timesWithin(double from, double to) const;
  const std::vector<Stamp>& stamps() const { return motion_.stamps; }

 private:
  /// Whether the vehicle looks along its way between stamp i and the next one.
  bool looksAlong(size_t i) const;
  /// Stamps about a time, and their indices.
  struct Neighbours {
    size_t low = 0, middle = 0, high = 0;
  };
  /// Returns the stamp nearest to a time, or the first or last that has such neighbours, and those before and after it
  /// that are at least `apart` seconds away; the ends of a trajectory that is shorter.
  Neighbours neighboursOf(double time, double apart) const;

  double spacing_ = 0;
  double blur_ = 0;  // seconds between positions below which their rounding outweighs accelerations
  SensorMotion motion_;
  std::vector<Segment> segments_;  // none unless the vehicle looks along its way
  std::vector<bool> turned_;       // by stamp
};

/// Returns the direction of the last way between stamps that moves; none if none does.
std::optional<Direction> directionOfLastWay(std::span<const Trajectory::Stamp> stamps, bool pitched);
/// Returns the steepest climb or descent over 2 m of the way, or over all of a shorter way, as a share of the way.
double steepestOf(std::span<const Trajectory::Stamp> stamps);
/// Returns the yaw in radians at every stamp of a vehicle that looks along its way, see Trajectory::alongWay().
std::vector<double> yawsAlong(const std::vector<Trajectory::Stamp>& stamps);

/// Choices that a trajectory file leaves open.
struct TrajectoryFileOptions {
  std::filesystem::path times;  ///< KITTI: the file with the time of each pose
  std::string route;            ///< CARLA routes: the id of the route; if empty, the first
  double speed = 0;             ///< CARLA routes: metres a second
};

/// Reads lines `t x y z qx qy qz qw` (TUM); # begins a comment, further numbers on a line are ignored. The times need
/// not ascend. Throws Error(format) that names the first invalid line, or Error(file) if the file cannot be read.
std::vector<Trajectory::Stamp> readTum(const std::filesystem::path& file);

/// Returns the warning of a pose file whose poses are too many seconds apart for something that moves, such as "has a
/// pose every 100 s; times are in seconds, and these look like milliseconds".
std::string doubtOfSeconds(double spacing);

/// Reads a trajectory file, format "tum", "kitti", "euroc", "nuscenes", "carla" or "carla-route", as docs/drives.md
/// describes them; the poses of CARLA have no turn. Throws Error(file) or Error(format) if the file cannot be read or
/// is invalid.
std::vector<Trajectory::Stamp> readTrajectory(const std::filesystem::path& file, const std::string& format,
                                              const TrajectoryFileOptions& options);

}  // namespace gnosphere::drive
