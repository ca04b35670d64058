// SPDX-License-Identifier: Apache-2.0
// Writes SENSOR/000000.pcd or .npy, one file per scan, and poses.txt.
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
      options.compact = output_.compact;
      for (Field field : output_.fields)
        if (field != Field::intensity || recorded.scan.has(field)) options.fields.push_back(field);
      files.push_back(
          {sensorFile(recorded.planned, output_.format), cloudBytes(recorded.scan, output_.format, options), ""});
    });
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override { writePoses(frames, files); }
};

}  // namespace

std::unique_ptr<Format> makeClouds(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<Clouds>(drive, world, output);
}

}  // namespace gnosphere::drive
