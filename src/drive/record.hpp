// SPDX-License-Identifier: Apache-2.0
// The record of a frame of a drive: its scans and the boxes of the actors in them. Output formats turn it into files.
#pragma once

#include <cmath>
#include <vector>

#include "drive/schedule.hpp"
#include "drive/world.hpp"
#include "effects/trajectory.hpp"

namespace gnosphere::drive {

/// The box of an actor in a scan.
struct Box {
  size_t actor = 0;
  /// Of the actor's pose: the median time of its returns, and without any that of the beams through its box; the start
  /// of the scan if actors stand still in it.
  double time = 0;
  Pose inSensor, inWorld;  ///< of the box's middle
  Vec3 size;               ///< length, width, height
  Vec3 velocity;           ///< m/s in the world
  bool moving = false;
  uint64_t points = 0;  ///< returns from the actor
  /// Of the beams through the box that meet a surface, the share that arrives at it; NaN if none meets one.
  double visibility = 0;
};

struct RecordedScan {
  PlannedScan planned;
  double duration = 0;      ///< seconds
  Pose pose;                ///< of the sensor in the world at the start
  bool sensorMoves = true;  ///< whether the sensor moves during the scan, as its plan says
  SensorMotion motion;      ///< its poses during the scan; none if it stands at `pose`
  bool actorsMove = true;   ///< whether actors do
  bool deskewed = false;    ///< whether points are in the frame of `pose`, rather than in that of their own time
  Scan scan;                ///< Scan::instances are numbers of objects, see World
  uint64_t points = 0;      ///< returns
  std::vector<Box> boxes;   ///< of the actors that it has hit, in their order
  std::vector<Box> missed;  ///< of the actors within the sensor's range that it has not hit, if an output has them

  /// When the scan stops to move actors: at its end, or at its start if they stand still in it.
  double endOfMotion() const { return actorsMove ? planned.time + duration : planned.time; }
};

struct FrameRecord {
  uint64_t frame = 0;
  std::vector<RecordedScan> scans;
};

/// The part of a RecordedScan that is kept when its frame has been written.
struct ScanSummary {
  PlannedScan planned;
  uint64_t points = 0;
  std::vector<Box> boxes;
};
struct FrameSummary {
  std::vector<ScanSummary> scans;
};

/// The poses of a sensor during a scan, which must outlive it, and bounds on them.
class SensorPath {
 public:
  SensorPath(const Sensor& sensor, const RecordedScan& recorded);
  /// Returns the pose at so many seconds after the start of the scan.
  Pose at(double seconds) const { return poseAt(recorded_.motion, recorded_.pose, seconds); }
  double middle() const { return 0.5 * (first_ + last_); }    ///< seconds after the start of the scan
  double halfSpan() const { return 0.5 * (last_ - first_); }  ///< seconds from there to the first and the last beam
  double shift() const { return shift_; }  ///< metres that the sensor is at most from its middle pose
  double turn() const { return turn_; }    ///< radians that it is at most turned from there at its stamps

 private:
  const RecordedScan& recorded_;
  double first_ = 0, last_ = 0;
  double shift_ = 0, turn_ = 0;
};

/// Finds the boxes of actors. The scan needs Field::time if it takes any.
class BoxFinder {
 public:
  explicit BoxFinder(const Drive& drive, const World& world) : drive_(drive), world_(world) {}
  /// Returns the boxes of the actors that a scan has hit, for RecordedScan::boxes.
  std::vector<Box> find(const RecordedScan& recorded);
  /// Returns the boxes for RecordedScan::missed, once RecordedScan::boxes are there.
  std::vector<Box> findMissed(const RecordedScan& recorded);

 private:
  /// The beams of one pattern of a sensor; directions by component, so that loops over them are vectorised.
  struct Beams {
    std::vector<float> x, y, z;
    std::vector<Vec3> origins;  // empty: all leave the sensor's origin
    std::vector<double> times;  // seconds after the start of the scan; empty: 0
    double spread = 0;          // metres from the sensor's origin within which all leave
  };
  const Beams& beamsOf(const PlannedScan& planned);
  /// The beams of a scan that go through a box.
  struct Sight {
    std::vector<float> times;  // of these beams, in seconds after the start of the scan
    double visibility = NAN;
  };
  /// Calls use(beam, seconds, range) for each beam that enters a box, with its time after the start of the scan and the
  /// range of its entry. Sensor and box are where they are when the beam fires.
  template <typename Use>
  void eachBeamThrough(const RecordedScan& recorded, const SensorPath& path, const Box& box, const Use& use);
  /// Returns the box of an actor at so many seconds after the start of a scan, without its points and visibility.
  Box boxAt(const RecordedScan& recorded, size_t actor, double seconds);
  /// Returns the poses of a box in the world at the start and the end of a scan; none if it stands.
  SensorMotion motionOf(const RecordedScan& recorded, const Box& box) const;
  Sight sightOf(const RecordedScan& recorded, const SensorPath& path, const Box& box);

  const Drive& drive_;
  const World& world_;
  std::map<std::pair<size_t, uint64_t>, Beams> beams_;  // by sensor and pattern
};

}  // namespace gnosphere::drive
