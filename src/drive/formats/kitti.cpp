// SPDX-License-Identifier: Apache-2.0
// The layout of KITTI odometry (Geiger et al., CVPR 2012), and with labels that of SemanticKITTI (Behley et al., ICCV
// 2019): sequences/00/velodyne/000000.bin, labels/000000.label, times.txt, calib.txt, poses.txt, and poses/00.txt.
// There is no camera: camera 0 stands where the lidar is, with the axes of a camera, and its projections are the
// identity.
#include "base/decimal_point.hpp"
#include "drive/formats/format.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::drive {
namespace {

constexpr uint16_t kOutlier = 1;  ///< SemanticKITTI's class of points that belong to no surface

class Kitti : public Format {
 public:
  Kitti(const Drive& drive, const World& world, const Output& output)
      : Format(drive, world, output),
        labelled_(output.format == "semantickitti"),
        sequence_(numberText("%02llu", output.sequence.value_or(0))),
        folder_(path("sequences/" + sequence_ + "/")) {}

  std::vector<Field> fields() const override {
    return labelled_ ? std::vector{Field::intensity, Field::classId} : std::vector{Field::intensity};
  }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    eachScan(frame, [&](const RecordedScan& recorded) {
      std::string rows = kittiRows(recorded.scan, drive_.sensors[recorded.planned.sensor]);
      const std::string number = numberText("%06llu", recorded.planned.number);
      files.push_back({folder_ + "velodyne/" + number + ".bin", std::move(rows), ""});
      if (labelled_) files.push_back({folder_ + "labels/" + number + ".label", labelsOf(recorded), ""});
    });
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override {
    std::string times, poses;
    double firstTime = 0;
    Pose toFirst;
    bool any = false;
    eachScan(frames, [&](const ScanSummary& scan) {
      const Pose pose = drive_.sensorPose(scan.planned.sensor, scan.planned.time);
      if (!any) {
        firstTime = scan.planned.time;
        toFirst = inverse(pose);
        any = true;
      }
      const DecimalPoint point;
      char text[64];
      std::snprintf(text, sizeof(text), "%.9e\n", scan.planned.time - firstTime);
      times += text;
      poses += cameraLine(toFirst * pose);
    });
    files.write(folder_ + "times.txt", times);
    files.write(folder_ + "poses.txt", poses);
    files.write(path("poses/" + sequence_ + ".txt"), poses);
    std::string calibration;
    for (const char* camera : {"P0", "P1", "P2", "P3"})
      calibration.append(camera).append(": 1 0 0 0 0 1 0 0 0 0 1 0\n");
    files.write(folder_ + "calib.txt", calibration + "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
  }

 private:
  /// The low 16 bits are the class, the high ones World::labelOfActor().
  std::string labelsOf(const RecordedScan& recorded) const {
    const Scan& scan = recorded.scan;
    const auto classes = scan.column<uint16_t>(Field::classId);
    std::vector<uint32_t> actors(world_.scene().instances.size());  // by object: number of the actor, 0 for none
    for (size_t actor = 0; actor < drive_.actors.size(); ++actor)
      actors[world_.objectOfActor(actor)] = World::labelOfActor(actor);
    std::vector<std::optional<bool>> moving(drive_.actors.size() + 1);  // by number of those that the scan has hit
    moving[0] = false;
    const auto isMoving = [&](uint32_t actor) {
      const double time = recorded.planned.time;
      if (!moving[actor]) moving[actor] = world_.placementOf(actor - 1, time, recorded.endOfMotion(), time).isMoving();
      return *moving[actor];
    };
    std::string bytes;
    bytes.reserve(scan.ranges.size() * sizeof(uint32_t));
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
      if (!scan.returned(entry)) continue;
      const uint32_t object = scan.instances[entry], actor = object == kNoTriangle ? 0 : actors[object];
      const uint16_t own = object == kNoTriangle ? kOutlier : classes[entry];
      const uint32_t label = (isMoving(actor) ? movingIdOf(own, actor - 1) : own) | actor << 16;
      bytes.append(reinterpret_cast<const char*>(&label), sizeof(label));
    }
    return bytes;
  }

  /// The number that a class has while it moves. Where several classes share an id, that of the actor counts.
  uint16_t movingIdOf(uint16_t id, size_t actor) const {
    const Class& category = drive_.classes[drive_.actors[actor].category];
    if (category.id == id) return category.movingId;
    const auto found = std::ranges::find(drive_.classes, id, &Class::id);
    return found == drive_.classes.end() ? id : found->movingId;
  }

  /// The matrix of a pose between cameras: the axes of a camera are x right, y down, z ahead.
  static std::string cameraLine(const Pose& pose) {
    const auto toCamera = [](const Vec3& v) { return Vec3{-v.y, -v.z, v.x}; };
    const Vec3 x = toCamera(pose.orientation * Vec3{0, -1, 0}), y = toCamera(pose.orientation * Vec3{0, 0, -1}),
               z = toCamera(pose.orientation * Vec3{1, 0, 0}), t = toCamera(pose.position);
    const DecimalPoint point;
    char text[512];
    std::snprintf(text, sizeof(text), "%.12e %.12e %.12e %.12e %.12e %.12e %.12e %.12e %.12e %.12e %.12e %.12e\n", x.x,
                  y.x, z.x, t.x, x.y, y.y, z.y, t.y, x.z, y.z, z.z, t.z);
    return text;
  }

  bool labelled_;
  std::string sequence_, folder_;
};

}  // namespace

std::unique_ptr<Format> makeKitti(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<Kitti>(drive, world, output);
}

}  // namespace gnosphere::drive
