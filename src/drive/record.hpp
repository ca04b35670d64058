// SPDX-License-Identifier: Apache-2.0
// The record of a frame of a drive: its scans and the boxes of the actors in them. Output formats turn it into files.
#pragma once

#include <vector>

#include "drive/schedule.hpp"
#include "drive/world.hpp"

namespace gnosphere::drive {

/// The box of an actor in a scan.
struct Box {
  size_t actor = 0;
  /// Of the actor's pose: the median time of its returns, and without any that of the beams through its box; the start
  /// of the scan if actors stand still in it.
  double time = 0;
  Pose inSensor, inWorld;  ///< of the box's middle
  Pose seen;               ///< of the box's middle, in the frame of the sensor at the time of the returns
  Vec3 size;               ///< length, width, height
  Vec3 velocity;           ///< m/s in the world
  bool moving = false;
  uint64_t points = 0;  ///< returns from the actor
  /// Of the beams through the box that meet a surface, the share that arrives at it. NaN: none meets one, nor is there
  /// any point.
  double visibility = 0;
};

struct RecordedScan {
  PlannedScan planned;
  double duration = 0;      ///< seconds
  Pose pose;                ///< of the sensor in the world at the start
  bool sensorMoves = true;  ///< whether the sensor moves during the scan, as its plan says
  bool actorsMove = true;   ///< whether actors do
  bool deskewed = false;    ///< whether points are in the frame of `pose`, rather than in that of their own time
  Scan scan;                ///< Scan::instances are numbers of objects, see World
  uint64_t points = 0;      ///< returns
  std::vector<Box> boxes;   ///< of the actors that it has hit, in their order
  std::vector<Box> missed;  ///< of those within the sensor's range that it has not hit, if an output has them

  /// When the scan stops to move actors: at its end, or at its start if they stand still in it.
  double endOfMotion() const { return actorsMove ? planned.time + duration : planned.time; }
};

struct FrameRecord {
  uint64_t frame = 0;
  std::vector<RecordedScan> scans;
};

/// Summary of a scan that stays of a frame when its scans have been written.
struct ScanSummary {
  PlannedScan planned;
  uint64_t points = 0;
  std::vector<Box> boxes;
};
struct FrameSummary {
  std::vector<ScanSummary> scans;
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
  };
  const Beams& beamsOf(const PlannedScan& planned);
  /// Calls use(beam, range) for each beam that enters a box, with the range of its entry. `seen` is the box in the
  /// frame of the sensor at the box's time.
  template <typename Use>
  void eachBeamThrough(const PlannedScan& planned, const Pose& seen, const Vec3& size, const Use& use);
  /// Returns the box of an actor at so many seconds after the start of a scan, without its points and visibility.
  Box boxAt(const RecordedScan& recorded, size_t actor, double seconds);
  double visibility(const RecordedScan& recorded, const Box& box);

  const Drive& drive_;
  const World& world_;
  std::map<std::pair<size_t, uint64_t>, Beams> beams_;  // by sensor and pattern
};

}  // namespace gnosphere::drive
