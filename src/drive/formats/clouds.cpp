// SPDX-License-Identifier: Apache-2.0
// SENSOR/000000.pcd or .npy, one file per scan.
#include "base/decimal_point.hpp"
#include "drive/formats/format.hpp"
#include "output/cloud_bytes.hpp"

namespace gnosphere::drive {
namespace {

class Clouds : public Format {
 public:
  using Format::Format;

  std::vector<Field> fields() const override { return output_.fields; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    eachScan(frame, [&](const RecordedScan& recorded) {
      CloudOptions options;
      options.compact = true;
      for (Field field : output_.fields)
        if (field != Field::intensity || recorded.scan.has(field)) options.fields.push_back(field);
      files.push_back(
          {sensorFile(recorded.planned, output_.format), cloudBytes(recorded.scan, output_.format, options), ""});
    });
  }

  /// poses.txt: a line t x y z qx qy qz qw per scan, the pose of the sensor when it starts.
  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override {
    for (size_t sensor : output_.sensors) {
      std::string text = "# t x y z qx qy qz qw\n";
      for (const FrameSummary& frame : frames)
        for (const ScanSummary& scan : frame.scans) {
          if (scan.planned.sensor != sensor) continue;
          const auto [p, q] = drive_.sensorPose(sensor, scan.planned.time);
          const DecimalPoint point;
          char line[256];
          std::snprintf(line, sizeof(line), "%.9f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", scan.planned.time, p.x,
                        p.y, p.z, q.x, q.y, q.z, q.w);
          text += line;
        }
      files.write(path(drive_.sensors[sensor].name + "/poses.txt"), text);
    }
  }
};

}  // namespace

std::unique_ptr<Format> makeClouds(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<Clouds>(drive, world, output);
}

}  // namespace gnosphere::drive
