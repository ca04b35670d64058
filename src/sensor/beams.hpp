// SPDX-License-Identifier: Apache-2.0
// The properties of each beam of a sensor, in double precision, for files, plots, comparisons and tables. Beams are
// numbered as in a scan. `frame` is the number of the scan, which selects the pattern of a list.
#pragma once

#include <span>
#include <string>

#include "gnosphere/sensor.hpp"

namespace gnosphere {

/// The beams of a list sensor in scan number `frame`.
const BeamList& patternOf(const Sensor& sensor, uint64_t frame);

/// Unit vector of an azimuth, counter-clockwise from x, and an elevation above the horizon, in degrees. Multiples of 90
/// are exact.
Vec3 unitVectorAt(double azimuthDeg, double elevationDeg);
/// Unit vector in the sensor's frame.
Vec3 directionOf(const Sensor& sensor, size_t beam, uint64_t frame = 0);
/// Point in the sensor's frame from which the beam leaves, in metres.
Vec3 originOf(const Sensor& sensor, size_t beam, uint64_t frame = 0);
/// Seconds between the start of the scan and the moment when the beam fires.
double timeOf(const Sensor& sensor, size_t beam, uint64_t frame = 0);
/// Azimuth in radians from -pi to less than pi, counter-clockwise from x; a grid may round to pi.
double azimuthOf(const Sensor& sensor, size_t beam, uint64_t frame = 0);
/// Elevation in radians above the horizon.
double elevationOf(const Sensor& sensor, size_t beam, uint64_t frame = 0);

/// Least and largest range of a beam in metres, both included.
struct RangeWindow {
  double least = 0, most = 0;
};
RangeWindow rangeWindowOf(const Sensor& sensor, size_t beam, uint64_t frame = 0);
/// The least and the largest range of any beam in any scan; those of the sensor if it has no beams.
RangeWindow widestWindow(const Sensor& sensor);
/// The value of Field::ring of a beam.
uint32_t ringOf(const Sensor& sensor, size_t beam, uint64_t frame = 0);

/// The moments at which the poses of a scan with motion are known: `count` of them, from `first` on every `step`
/// seconds; `step` is less than 0 if a head that turns clockwise fires in the order of falling azimuth.
struct ScanTimes {
  double first = 0, step = 0, middle = 0, last = 0;  // seconds after the start of the scan
  uint32_t count = 0;
  double earliest = 0;  ///< when the first beam fires
  uint32_t used = 0;    ///< no beam fires at a moment from here on
  double halfway = 0;   ///< entry of the middle

  double at(uint32_t i) const { return first + i * step; }
};
/// A scan of a list has this many intervals between poses. Straight lines between the poses miss a smooth path by
/// nanometres in a scan of a tenth of a second; readDrive() warns of longer scans whose path is not smooth.
inline constexpr uint32_t kListIntervals = 2048;
/// Returns the times of the columns for a grid; a list has kListIntervals.
ScanTimes scanTimesOf(const Sensor& sensor, bool listed, uint64_t frame = 0);
/// Whether beams of one scan fire at different times.
bool firesInTurn(const Sensor& sensor);
/// Whether the sensor is a list that states rings.
bool hasRings(const Sensor& sensor);
/// Whether channels of a grid have time offsets.
bool hasTimeOffsets(const Sensor& sensor);
/// Whether channels of a grid have azimuth offsets.
bool hasAzimuthOffsets(const Sensor& sensor);
/// The channels of a grid in the order of rising elevation; those of equal elevation stay in their order.
std::vector<uint32_t> channelsByElevation(const Sensor& sensor);
/// Whether any beam leaves another point than the sensor's origin.
bool hasOrigins(const Sensor& sensor);
/// How far lasers are from `centre`, a point in the sensor's frame, in metres: in all; along the azimuth of the beam,
/// across it, upwards.
struct OriginBounds {
  Vec3 centre;
  double distance = 0, forward = 0, left = 0, up = 0;
};
/// Returns the bounds of the lasers of some beams of a scan around `centre`; for a grid, of all beams around a point of
/// its axis.
OriginBounds originBoundsOf(const Sensor& sensor, uint64_t frame, const Vec3& centre, std::span<const uint32_t> beams);
/// Returns the point of a grid's axis that is halfway between the lowest and the highest laser.
Vec3 middleOfLasers(const Sensor& sensor);
/// Seconds that the motion of an instance during a scan takes: the rotation period, or without one those from the start
/// of the scan to its last beam; 0 if no beam fires after the start.
double durationOf(const Sensor& sensor, uint64_t frame);

/// A part of the time of a scan, in seconds after its start.
struct TimeSpan {
  double from = 0, to = 0;
};
/// Returns the times between which a scan needs the poses of its sensor: from its start to its end, and those of beams
/// that fire before or after it.
TimeSpan poseTimesOf(const Sensor& sensor, uint64_t frame);
/// Seconds from the start of a scan to the firing of the last beam of a list; 0 for a grid.
double lastTimeOf(const Sensor& sensor);
/// Seconds from the start of a scan to that of the next; 0 if the sensor states none.
double scanPeriodOf(const Sensor& sensor);

/// Whether each beam never fires, because Sensor::maskedBeams names it.
std::vector<bool> silentBeams(const Sensor& sensor);

/// Whether the device must treat the sensor as a list of beams: if it is one, or if it is a grid with a sector, its own
/// direction of rotation, range windows of channels, masked beams, or hidden near hits.
bool needsBeamList(const Sensor& sensor);
/// Returns why the accuracy `paper` cannot scan with a sensor, as a predicate such as "has masked beams"; empty if it
/// can. Section 3 of the paper knows grids of a full turn, with the same step between all neighbouring elevations.
std::string causeAgainstPaper(const Sensor& sensor);

}  // namespace gnosphere
