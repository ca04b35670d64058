// SPDX-License-Identifier: Apache-2.0
// The layout of KITTI's raw data (Geiger et al., IJRR 2013): DATE/DATE_drive_0001_sync/velodyne_points and oxts. The
// inertial unit is at the vehicle's origin; there are no cameras, so calib_velo_to_cam.txt only turns the axes.
#include <cmath>

#include "base/decimal_point.hpp"
#include "base/units.hpp"
#include "drive/formats/format.hpp"
#include "drive/pose_math.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::drive {
namespace {

// The world's origin, on the earth. KITTI's own tools map latitudes and longitudes to metres by Mercator's projection,
// scaled by the cosine of the first latitude, and this is its inverse.
constexpr double kLatitude = 49, kLongitude = 8.4, kAltitude = 115;
constexpr double kEarthRadius = 6378137;

constexpr const char* kDataFormat =
    "lat:   latitude of the oxts-unit (deg)\nlon:   longitude of the oxts-unit (deg)\n"
    "alt:   altitude of the oxts-unit (m)\nroll:  roll angle (rad)\npitch: pitch angle (rad)\nyaw:   heading (rad)\n"
    "vn:    velocity towards north (m/s)\nve:    velocity towards east (m/s)\nvf:    forward velocity (m/s)\n"
    "vl:    leftward velocity (m/s)\nvu:    upward velocity (m/s)\nax:    acceleration in x (m/s^2)\n"
    "ay:    acceleration in y (m/s^2)\naz:    acceleration in z (m/s^2)\naf:    forward acceleration (m/s^2)\n"
    "al:    leftward acceleration (m/s^2)\nau:    upward acceleration (m/s^2)\nwx:    angular rate around x (rad/s)\n"
    "wy:    angular rate around y (rad/s)\nwz:    angular rate around z (rad/s)\n"
    "wf:    angular rate around forward axis (rad/s)\nwl:    angular rate around leftward axis (rad/s)\n"
    "wu:    angular rate around upward axis (rad/s)\npos_accuracy:  position accuracy (m)\n"
    "vel_accuracy:  velocity accuracy (m/s)\nnavstat:       navigation status\nnumsats:       number of satellites\n"
    "posmode:       position mode\nvelmode:       velocity mode\norimode:       orientation mode\n";

std::string formattedLine(const char* format, const std::vector<double>& values) {
  const DecimalPoint point;
  std::string line;
  for (double value : values) {
    char text[64];
    std::snprintf(text, sizeof(text), format, value);
    line.append(line.empty() ? "" : " ").append(text);
  }
  return line;
}

std::string calibration(const Pose& pose) {
  const Transform t = transformOf(pose);
  const auto& m = t.rows;
  return "calib_time: 01-Jan-1970 00:00:00\nR: " +
         formattedLine("%.12e", {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}) +
         "\nT: " + formattedLine("%.12e", {m[3], m[7], m[11]}) + "\n";
}

class KittiRaw : public Format {
 public:
  KittiRaw(const Drive& drive, const World& world, const Output& output) : Format(drive, world, output) {
    date_ = dateText(unixNanoseconds(drive, drive.start)).substr(0, 10);
    for (char& c : date_)
      if (c == '-') c = '_';
    const std::string number = numberText("%04llu", output.sequence.value_or(1));
    folder_ = path(date_ + "/" + date_ + "_drive_" + number + "_sync/");
  }

  std::vector<Field> fields() const override { return {Field::intensity}; }

  void encode(const FrameRecord& frame, std::vector<OutputFile>& files) const override {
    eachScan(frame, [&](const RecordedScan& recorded) {
      std::string rows = kittiRows(recorded.scan, drive_.sensors[recorded.planned.sensor]);
      const std::string number = numberText("%010llu", recorded.planned.number);
      files.push_back({folder_ + "velodyne_points/data/" + number + ".bin", std::move(rows), ""});
      files.push_back({folder_ + "oxts/data/" + number + ".txt", oxtsOf(recorded.planned.time), ""});
    });
  }

  void finish(const std::vector<FrameSummary>& frames, FinalFiles& files) const override {
    std::string starts, clouds, ends;
    eachScan(frames, [&](const ScanSummary& scan) {
      const RigSensor& sensor = drive_.sensors[scan.planned.sensor];
      const double duration = durationOf(sensor.sensor, scan.planned.number);
      const auto line = [&](double share) {
        return dateText(unixNanoseconds(drive_, scan.planned.time + share * duration)) + "\n";
      };
      starts += line(0);
      // The points of a scan that is deskewed, or in which the sensor stands, are in the frame of its start, and other
      // ones are at their own on average halfway.
      const Effects::SensorMotion& motion = sensor.effects.sensorMotion;
      clouds += line(motion.deskew || motion.use == EffectUse::off ? 0 : 0.5);
      ends += line(1);
    });
    const std::string day = path(date_) + "/";
    files.write(folder_ + "velodyne_points/timestamps_start.txt", starts);
    files.write(folder_ + "velodyne_points/timestamps.txt", clouds);
    files.write(folder_ + "velodyne_points/timestamps_end.txt", ends);
    files.write(folder_ + "oxts/timestamps.txt", starts);
    files.write(folder_ + "oxts/dataformat.txt", kDataFormat);
    files.write(day + "calib_imu_to_velo.txt", calibration(inverse(drive_.sensors[output_.sensors[0]].mount)));
    const Pose axes = {{}, quaternionOf({Vec3{0, -1, 0}, Vec3{0, 0, -1}, Vec3{1, 0, 0}})};
    files.write(day + "calib_velo_to_cam.txt", calibration(axes));
    std::string cameras = "calib_time: 01-Jan-1970 00:00:00\n";
    for (const char* camera : {"00", "01", "02", "03"})
      cameras +=
          std::string("R_rect_") + camera + ": 1 0 0 0 1 0 0 0 1\nP_rect_" + camera + ": 1 0 0 0 0 1 0 0 0 0 1 0\n";
    files.write(day + "calib_cam_to_cam.txt", cameras);
  }

 private:
  std::string oxtsOf(double time) const {
    const Pose pose = drive_.ego.at(time);
    const Trajectory::Rates rates = drive_.ego.ratesAt(time);
    const Vec3 first = drive_.ego.at(drive_.start).position, p = pose.position - first;
    const double scale = std::cos(kLatitude * kDegree);
    const double east = scale * kEarthRadius * kLongitude * kDegree + p.x,
                 north = scale * kEarthRadius * std::log(std::tan(kDegree * (90 + kLatitude) / 2)) + p.y;
    const double longitude = east / (scale * kEarthRadius) / kDegree,
                 latitude = 2 * std::atan(std::exp(north / (scale * kEarthRadius))) / kDegree - 90;
    const auto [yaw, pitch, roll] = yawPitchRollOf(pose.orientation);
    // An accelerometer at rest measures that it is held up. x, y, z are the vehicle's axes; forward, leftward and
    // upward are level.
    const Vec3 v = rates.velocity, held = rates.acceleration + Vec3{0, 0, kGravity}, w = rates.turnRate;
    const Quaternion own = inverse(pose).orientation, level = yawPitchRoll(-yaw, 0, 0);
    const Vec3 a = own * held, levelV = level * v, levelA = level * held, levelW = level * (pose.orientation * w);
    std::vector<double> values = {latitude, longitude, kAltitude + p.z, roll, pitch, yaw, v.y, v.x};
    for (const Vec3& vector : {levelV, a, levelA, w, levelW})
      values.insert(values.end(), {vector.x, vector.y, vector.z});
    return formattedLine("%.14g", values) + " 0 0 4 10 4 4 0\n";
  }

  std::string date_, folder_;
};

}  // namespace

std::unique_ptr<Format> makeKittiRaw(const Drive& drive, const World& world, const Output& output) {
  return std::make_unique<KittiRaw>(drive, world, output);
}

}  // namespace gnosphere::drive
