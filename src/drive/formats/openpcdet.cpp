// SPDX-License-Identifier: Apache-2.0
// The custom data set of OpenPCDet, which other trainers of detectors read, too: points/000000.npy of x, y, z,
// intensity, labels/000000.txt of boxes in the frame of the points, and the frames to train with and to validate with.
// A box has a yaw alone, so points and boxes of a tilted sensor are in a frame at the sensor's origin whose z axis is
// that of the vehicle.
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstring>

#include "base/decimal_point.hpp"
#include "base/npy.hpp"
#include "base/vector.hpp"
#include "drive/formats/format.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::drive {
namespace {

/// Returns the rotation from a sensor's frame to the frame that has its yaw and the vehicle's z axis.
Quaternion levelled(const Quaternion& mounting) {
  const Quaternion yaw = yawPitchRoll(yawPitchRollOf(mounting)[0], 0, 0);
  return inverse(Pose{{}, yaw}).orientation * mounting;
}

/// Whether a rotation is less than the rounding of its numbers.
bool isIdentity(const Quaternion& q) {
  return lengthOf({q.x, q.y, q.z}) < 1e-9;
}

void turnRows(std::string& rows, const Quaternion& rotation) {
  float row[4];
  for (size_t at = 0; at < rows.size(); at += sizeof row) {
    std::memcpy(row, &rows[at], sizeof row);
    const Vec3 turned = Pose{{}, rotation} * Vec3{row[0], row[1], row[2]};
    const float written[3] = {float(turned.x), float(turned.y), float(turned.z)};
    std::memcpy(&rows[at], written, sizeof written);
  }
}

class OpenPcdet : public Format {
 public:
  using Format::Format;

  std::vector<Field> fields() const override { return {Field::intensity}; }
  bool needsBoxes() const override { return true; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    eachScan(frame, [&](const RecordedScan& recorded) {
      const std::string number = numberText("%06llu", recorded.planned.number);
      const RigSensor& sensor = drive_.sensors[recorded.planned.sensor];
      const Quaternion toLevel = levelled(sensor.mount.orientation);
      std::string rows = kittiRows(recorded.scan, sensor);
      if (!isIdentity(toLevel)) turnRows(rows, toLevel);
      const std::string shape = "(" + std::to_string(rows.size() / (4 * sizeof(float))) + ", 4)";
      files.push_back({path("points/" + number + ".npy"), npyHeaderOf("'<f4'", shape) + rows, ""});
      std::string labels;
      for (const Box& box : recorded.boxes) labels += lineOf(box, Pose{{}, toLevel} * box.inSensor);
      files.push_back({path("labels/" + number + ".txt"), labels, ""});
    });
  }

  /// The last fifth of the drive validates: neighbouring frames are too alike to be in both lists. The reader of labels
  /// needs a box in every frame that is listed.
  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override {
    std::vector<std::string> labelled;
    eachScan(frames, [&](const ScanSummary& scan) {
      if (!scan.boxes.empty()) labelled.push_back(numberText("%06llu\n", scan.planned.number));
    });
    const size_t training = labelled.size() - labelled.size() / 5;
    std::string train, validate;
    for (size_t i = 0; i < labelled.size(); ++i) (i < training ? train : validate) += labelled[i];
    files.write(path("ImageSets/train.txt"), train);
    files.write(path("ImageSets/val.txt"), validate);
  }

 private:
  /// Words end at spaces, so names of classes have _ for them.
  std::string lineOf(const Box& box, const Pose& pose) const {
    const auto& [p, q] = pose;
    std::string name = drive_.classes[drive_.actors[box.actor].category].name;
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return std::isspace(c); }, '_');
    const DecimalPoint point;
    char line[256];
    std::snprintf(line, sizeof(line), "%.4f %.4f %.4f %.4f %.4f %.4f %.6f ", p.x, p.y, p.z, box.size.x, box.size.y,
                  box.size.z, yawPitchRollOf(q)[0]);
    return line + name + "\n";
  }
};

}  // namespace

std::unique_ptr<Format> makeOpenPcdet(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<OpenPcdet>(drive, world, output);
}

}  // namespace gnosphere::drive
