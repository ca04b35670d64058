// SPDX-License-Identifier: Apache-2.0
// Writes SENSOR/000000.jsonl: a line of JSON per actor that the scan has hit, or within the sensor's range; and
// poses.txt with the start of each scan.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.hpp"
#include "drive/formats/format.hpp"

namespace gnosphere::drive {
namespace {

using Json = nlohmann::ordered_json;

Json poseOf(const Pose& pose) {
  const Quaternion& q = pose.orientation;
  return {{"position", listOf(pose.position)}, {"orientation", {q.x, q.y, q.z, q.w}}};
}

class Boxes : public Format {
 public:
  using Format::Format;

  std::vector<Field> fields() const override { return {}; }
  bool needsBoxes() const override { return true; }
  bool needsMissed() const override { return output_.allActors; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    eachScan(frame, [&](const RecordedScan& recorded) {
      std::string lines;
      std::vector<Box> boxes = recorded.boxes;
      if (output_.allActors) boxes.insert(boxes.end(), recorded.missed.begin(), recorded.missed.end());
      std::ranges::sort(boxes, {}, &Box::actor);
      for (const Box& box : boxes) lines += jsonText(lineOf(recorded, box)) + "\n";
      files.push_back({sensorFile(recorded.planned, "jsonl"), lines, ""});
    });
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override { writePoses(frames, files); }

 private:
  Json lineOf(const RecordedScan& recorded, const Box& box) const {
    const Actor& actor = drive_.actors[box.actor];
    const Class& category = drive_.classes[actor.category];
    Json line = {{"object", world_.objectOfActor(box.actor)},
                 {"name", actor.name},
                 {"class", category.name},
                 {"class_id", category.id},
                 {"time", box.time - recorded.planned.time},
                 {"sensor_frame", poseOf(box.inSensor)},
                 {"world_frame", poseOf(box.inWorld)},
                 {"size", listOf(box.size)},
                 {"velocity", listOf(box.velocity)},
                 {"moving", box.moving},
                 {"points", box.points}};
    if (!std::isnan(box.visibility)) line["visibility"] = box.visibility;
    return line;
  }
};

}  // namespace

std::unique_ptr<Format> makeBoxes(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<Boxes>(drive, world, output);
}

}  // namespace gnosphere::drive
