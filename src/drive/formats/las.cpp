// SPDX-License-Identifier: Apache-2.0
// SENSOR/000000.las, or SENSOR.las of a whole drive: ASPRS LAS 1.4 (R15), point data record format 6 with the object as
// an extra u32, and fields as further ones, in the world. The scan angle is that of the beam about the direction in
// which the vehicle heads: 0 downwards, positive to the right.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "base/file.hpp"
#include "base/quaternion.hpp"
#include "base/units.hpp"
#include "drive/bytes.hpp"
#include "drive/formats/format.hpp"
#include "drive/median.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::drive {
namespace {

constexpr uint16_t kHeaderBytes = 375;
/// A sensor may be as many units from the offset of all coordinates, so that its points fit into 32 bits, too.
constexpr double kReach = 1e9;
constexpr double kScanAngleUnit = 0.006;               ///< degrees
constexpr uint16_t kOwnBytes = 30 + sizeof(uint32_t);  ///< of a point without fields
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
  uint8_t line;  ///< bits of kToTheRight and kEndOfLine
  double gpsTime;
};

constexpr uint8_t kToTheRight = 1 << 6;  ///< the scan direction
constexpr uint8_t kEndOfLine = 1 << 7;   ///< the edge of a flight line

/// Returns for each beam of a pattern how its mirror moves: to the right of the vehicle or not, and whether the line
/// ends, because the mirror turns back after the beam or its next facet follows. Both are 0 for sensors with several
/// rings.
std::vector<uint8_t> linesOf(const RigSensor& rigged, uint64_t pattern) {
  const BeamList beams = beamsOf(rigged.sensor, pattern);
  const size_t count = beams.size();
  std::vector<uint8_t> lines(count);
  if (count < 3 || std::ranges::any_of(beams.rings, [&](uint32_t ring) { return ring != beams.rings[0]; }))
    return lines;
  const auto angleOf = [&](size_t beam) {
    const Vec3 d = rigged.mount.orientation * beams.directions[beam];
    return std::atan2(-d.y, -d.z);
  };
  std::vector<double> steps;  // from each beam to the next one: radians to the right
  for (size_t i = 0; i < count; ++i)
    steps.push_back(std::remainder(angleOf((i + 1) % count) - angleOf(i), 2 * std::numbers::pi));
  std::vector<double> lengths(count);
  std::ranges::transform(steps, lengths.begin(), [](double step) { return std::abs(step); });
  constexpr double kMostUsual = 3;  // times the usual step; longer ones lead from one facet to the next
  const double longest = kMostUsual * medianOf(lengths);
  for (size_t i = 0; i < count; ++i) {
    const double before = steps[(i + count - 1) % count], after = steps[i];
    const bool begins = std::abs(before) > longest, ends = std::abs(after) > longest;
    const bool toTheRight = (begins ? after : before) > 0, turns = !begins && before * after < 0;
    lines[i] = (toTheRight ? kToTheRight : 0) | (ends || turns ? kEndOfLine : 0);
  }
  return lines;
}

/// Counts and bounds of points, as a header has them.
struct Summary {
  Vec3 min = {INFINITY, INFINITY, INFINITY}, max = {-INFINITY, -INFINITY, -INFINITY};
  uint64_t count = 0;
  uint64_t byReturn[15] = {};
};

/// The unit and the meaning of a field, for readers of a file.
struct Meaning {
  Field field;
  const char* text;
};
constexpr Meaning kMeanings[] = {
    {Field::range, "m along the beam"},
    {Field::ring, "channel of the beam"},
    {Field::beam, "index of the beam in its scan"},
    {Field::triangle, "index within the mesh"},
    {Field::tolerance, "m of single precision"},
    {Field::trueRange, "m without noise"},
    {Field::width, "m, echo: FWHM times c / 2"},
    {Field::incidence, "rad from the normal"},
    {Field::material, "index of the material"},
    {Field::radialSpeed, "m/s away from the sensor"},
    {Field::azimuth, "rad, counter-clockwise from x"},
    {Field::elevation, "rad above the horizon"},
};

class Las : public Format {
 public:
  Las(const Drive& drive, const World& world, const Output& output)
      : Format(drive, world, output), layout_(layoutOf(output.fields)) {
    layout_.compact = true;
    const Vec3 start = drive.ego.at(drive.start).position;
    offset_ = {std::round(start.x), std::round(start.y), std::round(start.z)};
    for (const RigSensor& rigged : drive.sensors) {
      std::vector<std::vector<uint8_t>>& patterns = lines_.emplace_back();
      for (size_t i = 0; i < std::max<size_t>(1, rigged.sensor.patterns.size()); ++i)
        patterns.push_back(linesOf(rigged, i));
    }
  }

  std::vector<Field> fields() const override {
    std::vector<Field> all = {Field::intensity, Field::time, Field::classId};
    all.insert(all.end(), output_.fields.begin(), output_.fields.end());
    return all;
  }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    std::vector<std::string> parts(drive_.sensors.size());
    eachScan(frame, [&](const RecordedScan& recorded) {
      const size_t sensor = recorded.planned.sensor;
      if (output_.oneFile) {
        parts[sensor] += pointsOf(recorded, offset_);
        return;
      }
      // All files have one offset, unless the coordinates of a vehicle that is too far from it would not fit.
      const Vec3& p = recorded.pose.position;
      const Vec3 offset = isNear(p) ? offset_ : Vec3{std::round(p.x), std::round(p.y), std::round(p.z)};
      const std::string points = pointsOf(recorded, offset);
      Summary summary;
      add(summary, points, offset);
      files.push_back(
          {sensorFile(recorded.planned, "las"), headerOf(summary, offset, sensor) + extraBytes() + crs() + points, ""});
    });
    for (size_t sensor : output_.sensors)
      if (!parts[sensor].empty())
        files.push_back({partPath(sensor, frame.frame), std::move(parts[sensor]), wholePath(sensor)});
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override {
    writePoses(frames, files);
    if (!output_.oneFile) return;
    for (size_t sensor : output_.sensors) files.addMade(wholePath(sensor), [&] { writeWhole(sensor, frames, files); });
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

  bool isNear(const Vec3& p) const {
    const Vec3 d = p - offset_;
    return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) < kReach * output_.scale;
  }

  /// Rounds metres from the offset to units of the file. Throws Error(format) if they do not fit into 32 bits.
  Point pointOf(const Vec3& d) const {
    const double farthest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    if (!(farthest / output_.scale < std::numeric_limits<int32_t>::max()))
      throw Error(ErrorCode::format, "outputs: LAS has no coordinates of " + gnosphere::numberText(farthest) +
                                         " m from their offset with a 'scale' of " +
                                         gnosphere::numberText(output_.scale) + " m; state a greater one");
    const auto units = [&](double metres) { return static_cast<int32_t>(std::lround(metres / output_.scale)); };
    return {units(d.x), units(d.y), units(d.z)};
  }

  std::string wholePath(size_t sensor) const { return path(drive_.sensors[sensor].name + ".las"); }

  /// Puts the file of a sensor together from the parts of all frames, which are runs of points.
  void writeWhole(size_t sensor, const std::vector<FrameSummary>& frames, const FinalFiles& files) const {
    std::vector<std::filesystem::path> parts;
    for (uint64_t frame = 0; frame < frames.size(); ++frame) {
      const auto hasPoints = [&](const ScanSummary& s) { return s.planned.sensor == sensor && s.points > 0; };
      if (std::ranges::any_of(frames[frame].scans, hasPoints)) parts.push_back(files / partPath(sensor, frame));
    }
    Summary summary;
    for (const auto& part : parts) add(summary, readWholeFile(part), offset_);
    AtomicFile whole(files / wholePath(sensor), partOf(files / wholePath(sensor)));
    whole.write(headerOf(summary, offset_, sensor) + extraBytes() + crs());
    for (const auto& part : parts) whole.write(readWholeFile(part));
    whole.commit();
  }

  size_t pointBytes() const { return kOwnBytes + layout_.stride; }
  uint16_t sourceOf(size_t sensor) const {
    return static_cast<uint16_t>((output_.flightLine == 0 ? 1 : output_.flightLine) + sensor);
  }

  /// Returns the points of a scan as a file has them.
  std::string pointsOf(const RecordedScan& recorded, const Vec3& offset) const {
    if (!isNear(recorded.pose.position) && output_.oneFile)
      throw Error(ErrorCode::format, "outputs: with 'one_file' and a 'scale' of " +
                                         gnosphere::numberText(output_.scale) + " m LAS has coordinates up to " +
                                         gnosphere::numberText(kReach * output_.scale / 1000) +
                                         " km from the start of the drive, and the vehicle goes beyond; leave "
                                         "'one_file' out, or state a greater scale");
    const Scan& scan = recorded.scan;
    const bool strong = scan.has(Field::intensity), timed = scan.has(Field::time);
    const auto intensities = strong ? scan.column<float>(Field::intensity) : ColumnView<float>();
    const auto times = timed ? scan.column<float>(Field::time) : ColumnView<float>();
    const auto classes = scan.column<uint16_t>(Field::classId);
    const float factor = intensityFactor(drive_.sensors[recorded.planned.sensor], 65535);
    std::unordered_map<float, Moment> moments;  // by time; all beams of a column share one
    // Times that the trajectory states from its own start keep their digits if the large numbers are added first.
    const double gpsOfDrive = drive_.epoch + kGpsOfUnix;
    const std::string rows = output_.fields.empty() ? "" : packedRows(scan, layout_);
    const std::vector<std::vector<uint8_t>>& patterns = lines_[recorded.planned.sensor];
    const std::vector<uint8_t>& lines = patterns[recorded.planned.number % patterns.size()];
    size_t rowStart = 0;
    const uint16_t source =
        output_.sourcePerScan ? static_cast<uint16_t>(recorded.planned.number + 1) : sourceOf(recorded.planned.sensor);
    std::string points;
    points.reserve(scan.ranges.size() * pointBytes());
    for (size_t entry = 0; entry < scan.ranges.size(); ++entry) {
      if (!scan.returned(entry)) continue;
      const float time = timed ? times[entry] : 0;
      const auto [moment, isNew] = moments.try_emplace(recorded.sensorMoves ? time : 0);
      if (isNew) moment->second = momentOf(recorded, moment->first);
      const float* own = &scan.points[3 * entry];
      const Pose& pose = recorded.deskewed ? recorded.pose : moment->second.pose;
      const Vec3 at = pose * Vec3{own[0], own[1], own[2]};
      size_t number = entry % scan.returns, count = 0;
      for (size_t k = 0; k < scan.returns; ++k) count += scan.returned(entry - number + k);
      const float strength = strong ? std::min(65535.0f, std::max(0.0f, factor * intensities[entry])) : 0;
      const Row row = {pointOf(at - offset),
                       static_cast<uint16_t>(std::lround(strength)),
                       number + 1,
                       count,
                       classes[entry],
                       scan.instances[entry],
                       moment->second.scanAngle(at),
                       lines[entry / scan.returns],
                       gpsOfDrive + (recorded.planned.time + time)};
      appendPoint(points, row, source);
      points.append(rows, rowStart, layout_.stride);
      rowStart += layout_.stride;
    }
    return points;
  }

  static void appendPoint(std::string& out, const Row& row, uint16_t source) {
    append(out, row.point.x);
    append(out, row.point.y);
    append(out, row.point.z);
    append(out, row.strength);
    append(out, static_cast<uint8_t>(row.number | row.count << 4));
    append(out, row.line);  // classification flags, scanner channel, scan direction, edge of flight line
    append(out, static_cast<uint8_t>(row.classId));
    append(out, uint8_t{0});  // user data
    append(out, row.angle);
    append(out, source);
    append(out, row.gpsTime);
    append(out, row.object);
  }

  /// Adds points, as a file has them, to a summary.
  void add(Summary& summary, const std::string& points, const Vec3& offset) const {
    constexpr size_t kReturn = 14, kNumber = 15;
    for (size_t p = 0; p + pointBytes() <= points.size(); p += pointBytes()) {
      int32_t xyz[3];
      std::memcpy(xyz, &points[p], sizeof(xyz));
      const Vec3 at = output_.scale * Vec3{double(xyz[0]), double(xyz[1]), double(xyz[2])} + offset;
      summary.min = lowest(summary.min, at);
      summary.max = highest(summary.max, at);
      ++summary.count;
      if (const int number = points[p + kReturn] & kNumber; number > 0) ++summary.byReturn[number - 1];
    }
  }

  std::string headerOf(const Summary& points, const Vec3& offset, size_t sensor) const {
    constexpr uint16_t kAdjustedGpsTime = 1, kWkt = 1 << 4;
    const Vec3 min = points.count ? points.min : Vec3{}, max = points.count ? points.max : Vec3{};
    std::string out = "LASF";
    append(out, output_.flightLine == 0 ? uint16_t{0} : sourceOf(sensor));
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
    append(out, static_cast<uint16_t>(pointBytes()));
    out.append(6 * sizeof(uint32_t), '\0');  // counts of old versions
    for (int axis = 0; axis < 3; ++axis) append(out, output_.scale);
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

  /// Returns the record of the extra dimensions: the object, and a dimension per field.
  std::string extraBytes() const {
    std::string dimensions = dimension(ValueType::u32, "object", "instance of the scene or actor");
    for (const Field field : output_.fields) {
      const auto* meaning = std::ranges::find(kMeanings, field, &Meaning::field);
      const FieldInfo info = fieldInfo(field);
      dimensions += dimension(info.type, info.name, meaning == std::end(kMeanings) ? "" : meaning->text);
    }
    return recordHeader("LASF_Spec", 4, dimensions.size(), "Extra bytes") + dimensions;
  }

  static std::string dimension(ValueType type, const char* name, const char* description) {
    constexpr uint8_t kTypes[] = {9, 10, 1, 3, 5};  // of LAS: float, double, unsigned char, short and long
    std::string out(2, '\0');
    append(out, kTypes[static_cast<size_t>(type)]);
    append(out, uint8_t{0});
    appendFixed(out, name, 32);
    out.append(4 + 5 * 24, '\0');
    appendFixed(out, description, 32);
    return out;
  }

  RecordLayout layout_;                                   // of the fields
  Vec3 offset_;                                           // of the coordinates: where the drive starts, in whole metres
  std::vector<std::vector<std::vector<uint8_t>>> lines_;  // per sensor, pattern and beam: see linesOf()
};

}  // namespace

std::string mistakeOfLasField(Field field) {
  constexpr Field kOwn[] = {Field::x,          Field::y,       Field::z,        Field::intensity,
                            Field::time,       Field::classId, Field::instance, Field::returnNumber,
                            Field::returnCount};
  const std::string name = fieldInfo(field).name;
  if (std::ranges::find(kOwn, field) != std::end(kOwn)) return "the points of LAS have '" + name + "' without it";
  if (field == Field::tie) return "'tie' is of beams without returns, too, and LAS has none of them";
  if (fieldInfo(field).components > 1) return "'" + name + "' has several components, and LAS takes one";
  return "";
}

std::unique_ptr<Format> makeLas(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<Las>(drive, world, output);
}

}  // namespace gnosphere::drive
