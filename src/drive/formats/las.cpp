// SPDX-License-Identifier: Apache-2.0
// SENSOR/000000.las: ASPRS LAS 1.4 (R15), point data record format 6 with the object as an extra u32, in the world. The
// scan angle is that of the beam about the direction in which the vehicle heads: 0 downwards, positive to the right.
#include <cmath>
#include <unordered_map>

#include "base/units.hpp"
#include "drive/bytes.hpp"
#include "drive/formats/format.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::drive {
namespace {

constexpr double kScale = 0.001;  ///< metres per unit of a coordinate
constexpr uint16_t kHeaderBytes = 375, kExtraRecordBytes = 192;
constexpr double kScanAngleUnit = 0.006;  ///< degrees
constexpr uint16_t kLasPointBytes = 30 + sizeof(uint32_t);
/// Adjusted standard GPS time: seconds since 1980-01-06 less 10^9, 18 leap seconds ahead of UTC (since 2017).
constexpr double kGpsOfUnix = -315964800.0 + 18 - 1e9;

struct Point {
  int32_t x, y, z;
};

/// A return, in the units of LAS.
struct Row {
  Point point;
  uint16_t strength;
  size_t number, count;  ///< of the beam's returns
  uint16_t classId;
  uint32_t object;
  int16_t angle;
  double gpsTime;
};

struct Points {
  std::string records;
  Vec3 min = {INFINITY, INFINITY, INFINITY}, max = {-INFINITY, -INFINITY, -INFINITY};
  uint64_t count = 0;
  uint64_t byReturn[15] = {};
};

class Las : public Format {
 public:
  using Format::Format;

  std::vector<Field> fields() const override { return {Field::intensity, Field::time, Field::classId}; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    eachScan(frame, [&](const RecordedScan& recorded) {
      const Vec3& p = recorded.pose.position;
      const Vec3 offset = {std::round(p.x), std::round(p.y), std::round(p.z)};
      const Points points = pointsOf(recorded, offset);
      files.push_back(
          {sensorFile(recorded.planned, "las"), headerOf(points, offset) + extraBytes() + crs() + points.records, ""});
    });
  }

 private:
  /// Where a sensor is at a time, and the direction to the right of the vehicle.
  struct Moment {
    Pose pose;
    double rightX = 0, rightY = 0;

    /// The angle of the direction to a point of the world about the heading of the vehicle, in units of 0.006 degrees.
    int16_t scanAngle(const Vec3& point) const {
      const Vec3 d = point - pose.position;
      return static_cast<int16_t>(
          std::lround(std::atan2(d.x * rightX + d.y * rightY, -d.z) / (kDegree * kScanAngleUnit)));
    }
  };

  Moment momentOf(const RecordedScan& recorded, float time) const {
    const double at = recorded.planned.time + time, yaw = yawPitchRollOf(drive_.ego.at(at).orientation)[0];
    return {drive_.sensorPose(recorded.planned.sensor, at), std::sin(yaw), -std::cos(yaw)};
  }

  Points pointsOf(const RecordedScan& recorded, const Vec3& offset) const {
    const Scan& scan = recorded.scan;
    const bool strong = scan.has(Field::intensity), timed = scan.has(Field::time);
    const auto intensities = strong ? scan.column<float>(Field::intensity) : ColumnView<float>();
    const auto times = timed ? scan.column<float>(Field::time) : ColumnView<float>();
    const auto classes = scan.column<uint16_t>(Field::classId);
    const float factor = intensityFactor(drive_.sensors[recorded.planned.sensor], 65535);
    std::unordered_map<float, Moment> moments;  // by time; all beams of a column share one
    // Times that the trajectory states from its own start keep their digits if the large numbers are added first.
    const double gpsOfDrive = drive_.epoch + kGpsOfUnix;
    Points points;
    points.records.reserve(scan.ranges.size() * kLasPointBytes);
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
      if (!scan.returned(entry)) continue;
      const float time = timed ? times[entry] : 0;
      const auto [moment, isNew] = moments.try_emplace(recorded.sensorMoves ? time : 0);
      if (isNew) moment->second = momentOf(recorded, moment->first);
      const float* own = &scan.points[3 * entry];
      const Pose& pose = recorded.deskewed ? recorded.pose : moment->second.pose;
      const Vec3 at = pose * Vec3{own[0], own[1], own[2]}, world = at - offset;
      const Point point = {static_cast<int32_t>(std::lround(world.x / kScale)),
                           static_cast<int32_t>(std::lround(world.y / kScale)),
                           static_cast<int32_t>(std::lround(world.z / kScale))};
      size_t number = entry % scan.returns, count = 0;
      for (size_t k = 0; k < scan.returns; ++k) count += scan.returned(entry - number + k);
      const float strength = strong ? std::min(65535.0f, std::max(0.0f, factor * intensities[entry])) : 0;
      const Row row = {point,
                       static_cast<uint16_t>(std::lround(strength)),
                       number + 1,
                       count,
                       classes[entry],
                       scan.instances[entry],
                       moment->second.scanAngle(at),
                       gpsOfDrive + (recorded.planned.time + time)};
      add(points, row, offset, recorded.planned.sensor);
    }
    return points;
  }

  static void add(Points& points, const Row& row, const Vec3& offset, size_t sensor) {
    std::string& out = points.records;
    const Point& point = row.point;
    append(out, point.x);
    append(out, point.y);
    append(out, point.z);
    append(out, row.strength);
    append(out, static_cast<uint8_t>(row.number | row.count << 4));
    append(out, uint8_t{0});  // flags, scanner channel, direction, edge
    append(out, static_cast<uint8_t>(row.classId));
    append(out, uint8_t{0});  // user data
    append(out, row.angle);
    append(out, static_cast<uint16_t>(sensor + 1));  // point source
    append(out, row.gpsTime);
    append(out, row.object);
    const Vec3 at = kScale * Vec3{double(point.x), double(point.y), double(point.z)} + offset;
    points.min = lowest(points.min, at);
    points.max = highest(points.max, at);
    ++points.count;
    ++points.byReturn[row.number - 1];
  }

  std::string headerOf(const Points& points, const Vec3& offset) const {
    constexpr uint16_t kAdjustedGpsTime = 1, kWkt = 1 << 4;
    const Vec3 min = points.count ? points.min : Vec3{}, max = points.count ? points.max : Vec3{};
    std::string out = "LASF";
    append(out, uint16_t{0});  // file source
    append(out, uint16_t{kAdjustedGpsTime | kWkt});
    out.append(16, '\0');  // project
    append(out, uint8_t{1});
    append(out, uint8_t{4});
    appendFixed(out, "SIMULATION", 32);
    appendFixed(out, "GnoSphere", 32);
    append(out, uint16_t{0});  // day and year of creation: unknown, so that the bytes are the same every day
    append(out, uint16_t{0});
    append(out, kHeaderBytes);
    append(out, static_cast<uint32_t>(kHeaderBytes + extraBytes().size() + crs().size()));
    append(out, output_.crs.empty() ? 1u : 2u);  // variable length records
    append(out, uint8_t{6});
    append(out, kLasPointBytes);
    out.append(6 * sizeof(uint32_t), '\0');  // counts of old versions
    for (int axis = 0; axis < 3; ++axis) append(out, kScale);
    for (double value : {offset.x, offset.y, offset.z, max.x, min.x, max.y, min.y, max.z, min.z}) append(out, value);
    append(out, uint64_t{0});  // waveforms
    append(out, uint64_t{0});  // extended records
    append(out, uint32_t{0});
    append(out, points.count);
    for (uint64_t count : points.byReturn) append(out, count);
    return out;
  }

  /// Returns the header of a variable length record.
  static std::string recordHeader(const char* user, uint16_t id, size_t bytes, const char* description) {
    std::string out(2, '\0');
    appendFixed(out, user, 16);
    append(out, id);
    append(out, static_cast<uint16_t>(bytes));
    appendFixed(out, description, 32);
    return out;
  }

  /// Returns the record of the coordinate reference system, which is empty if the drive states none.
  std::string crs() const {
    if (output_.crs.empty()) return "";
    return recordHeader("LASF_Projection", 2112, output_.crs.size() + 1, "OGC WKT") + output_.crs + '\0';
  }

  static std::string extraBytes() {
    constexpr uint8_t kUnsignedLong = 5;  // a u32
    std::string out = recordHeader("LASF_Spec", 4, kExtraRecordBytes, "Extra bytes");
    out.append(2, '\0');
    append(out, kUnsignedLong);
    append(out, uint8_t{0});
    appendFixed(out, "object", 32);
    out.append(4 + 5 * 24, '\0');
    appendFixed(out, "instance of the scene or actor", 32);
    return out;
  }
};

}  // namespace

std::unique_ptr<Format> makeLas(const Drive& drive, const World& world, const Output& output) {
  const auto check = [](const std::string& who, uint16_t id) {
    if (id > 255) throw Error(ErrorCode::format, "LAS has classes 0 to 255; " + who + " the id " + std::to_string(id));
  };
  for (const Class& category : drive.classes) check("'" + category.name + "' has", category.id);
  for (const Instance& instance : world.scene().instances)
    check("the file of instance '" + instance.name + "' states", instance.classId);
  for (const Material& material : world.scene().materials)
    check("the file of material '" + material.name + "' states", material.classId);
  return std::make_unique<Las>(drive, world, output);
}

}  // namespace gnosphere::drive
