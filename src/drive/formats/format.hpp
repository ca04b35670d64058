// SPDX-License-Identifier: Apache-2.0
// The interface of the formats that a drive is written in: one source file per format.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drive/final_files.hpp"
#include "drive/record.hpp"

namespace gnosphere::drive {

struct OutputFile {
  std::string path;  ///< in the output folder
  std::string bytes;
  /// The file that finish() makes of this one, which is then removed; empty if the file stays.
  std::string into;
};

/// Turns frames of a drive into files. Whatever a file holds follows from its frame alone, so frames can be made
/// anywhere and in any order.
class Format {
 public:
  Format(const Drive& drive, const World& world, const Output& output)
      : drive_(drive), world_(world), output_(output) {}
  virtual ~Format() = default;

  /// The fields that scans of these sensors must hold.
  virtual std::vector<Field> fields() const = 0;
  virtual bool needsBoxes() const { return false; }
  /// Whether the format writes actors without points. Such a format needs boxes, too.
  virtual bool needsMissed() const { return false; }
  /// Appends the files of a frame.
  virtual void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const = 0;
  /// Writes the files that need every frame, once all frames are complete. `frames` has the summaries of all frames.
  virtual void finish(const std::vector<FrameSummary>& /*frames*/, FinalFiles& /*files*/) const {}

  bool writes(size_t sensor) const {
    return std::find(output_.sensors.begin(), output_.sensors.end(), sensor) != output_.sensors.end();
  }

 protected:
  std::string path(const std::string& name) const { return output_.folder + "/" + name; }
  /// SENSOR/000000.ENDING, the file of a scan.
  std::string sensorFile(const PlannedScan& scan, const std::string& ending) const;
  /// The part of a frame that goes into a sensor's file of the whole drive.
  std::string partPath(size_t sensor, uint64_t frame) const;
  /// Writes SENSOR/poses.txt of each sensor: a line t x y z qx qy qz qw per scan, the pose of the sensor when it
  /// starts, at the time of the trajectory's clock.
  void writePoses(const std::vector<FrameSummary>& frames, FinalFiles& files) const;
  /// Calls use(scan) for every scan of a FrameRecord or FrameSummary that this output has.
  template <class Frame, class Use>
  void eachScan(const Frame& frame, const Use& use) const {
    for (const auto& scan : frame.scans)
      if (writes(scan.planned.sensor)) use(scan);
  }
  template <class Use>
  void eachScan(const std::vector<FrameSummary>& frames, const Use& use) const {
    for (const FrameSummary& frame : frames) eachScan(frame, use);
  }

  const Drive& drive_;
  const World& world_;
  const Output& output_;
};

using MakeFormat = std::unique_ptr<Format>(const Drive&, const World&, const Output&);

/// A format that a drive is written in.
struct FormatInfo {
  const char* name;  ///< in drive files
  MakeFormat* make;
  bool shown;  ///< gnosphere view shows its clouds
  /// The fields of a row, unless the drive file chooses others; null if it may not.
  const char* fields = nullptr;
  bool compact = false;     ///< the drive file may ask for rows of beams without a return
  bool keyframes = false;   ///< nuScenes: the drive file may choose which frames are key frames, and the version
  bool sequence = false;    ///< KITTI: the drive file may state the number of the sequence or drive
  bool allActors = false;   ///< the drive file may ask for actors without a point
  bool oneSensor = false;   ///< it has one lidar
  bool pointTimes = false;  ///< its points have times, whatever fields the drive file chooses
  bool survey = false;      ///< the drive file may state a flight line and a coordinate reference system
};

std::span<const FormatInfo> formats();
/// Returns the format of this name, which the schema of drive files has.
const FormatInfo& formatNamed(const std::string& name);
/// Returns "a, b and c".
std::string listed(const std::vector<std::string>& names);
/// Returns "a, b and c": the names of the formats that `chosen` chooses.
std::string formatNames(bool (*chosen)(const FormatInfo& format));

// One function per format, each in a source file of its own.
MakeFormat makeClouds, makeBoxes, makeKitti, makeKittiRaw, makeNuScenes, makeOpenPcdet, makeLas, makeMcap, makeOsi;

/// Returns why LAS cannot have this field as an extra dimension, or an empty text.
std::string mistakeOfLasField(Field field);

// Functions that several formats need.

std::string numberText(const char* format, uint64_t number);
/// Nanoseconds since 1970 of a time of the trajectories' clock.
int64_t unixNanoseconds(const Drive& drive, double time);
/// Returns a time as text such as "2011-09-26 13:02:25.951199337", in UTC.
std::string dateText(int64_t nanoseconds);
/// The rows of the returns of a scan, by a layout that is compact.
std::string packedRows(const Scan& scan, const RecordLayout& layout);
/// Returns the factor on a sensor's intensities by which a diffuse white surface gets this greatest value.
float intensityFactor(const RigSensor& sensor, float greatest);
/// Returns the rows of kittiLayout(), in which a diffuse white surface has the intensity 1.
std::string kittiRows(const Scan& scan, const RigSensor& sensor);
/// Multiplies one float of every row.
void scaleFloat(std::span<std::byte> rows, size_t stride, size_t offset, float factor);

}  // namespace gnosphere::drive
