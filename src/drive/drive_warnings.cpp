// SPDX-License-Identifier: Apache-2.0
// Warnings about drive files that are valid and probably not meant so: clocks that do not match, sensors that make no
// scan, and weather and motion that do not reach a sensor.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "base/vector.hpp"
#include "drive/drive_reader.hpp"
#include "drive/formats/format.hpp"
#include "drive/median.hpp"
#include "drive/pose_math.hpp"
#include "drive/schedule.hpp"
#include "effects/trajectory.hpp"
#include "ros2/driver_cloud.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::drive {
namespace {

constexpr double kSlack = 1e-6;  // s: sums of Unix times and durations are as exact

/// Returns a time such as "1700000000.25 s".
std::string secondsText(double time) {
  char text[320];  // the largest double has 309 digits before the point
  std::string trimmed(text, std::to_chars(text, text + sizeof(text), time, std::chars_format::fixed, 3).ptr);
  trimmed.erase(trimmed.find_last_not_of('0') + 1);
  if (trimmed.back() == '.') trimmed.pop_back();
  return trimmed + " s";
}

/// A way between two stamps of a trajectory.
struct Way {
  double from = 0, to = 0;  ///< s
  double length = 0;        ///< m
  double speed() const { return length / (to - from); }
};

/// Returns the fastest way of a trajectory between these times; one of speed 0 if nothing moves.
Way fastestWay(const Trajectory& trajectory, double first, double last) {
  Way fastest = {0, 1, 0};
  const std::vector<Trajectory::Stamp>& stamps = trajectory.stamps();
  for (size_t i = 1; i < stamps.size(); ++i) {
    const Way way = {stamps[i - 1].time, stamps[i].time,
                     lengthOf(stamps[i].pose.position - stamps[i - 1].pose.position)};
    if (way.to > first && way.from < last && way.speed() > fastest.speed()) fastest = way;
  }
  return fastest;
}

/// Returns the median speed in m/s between the stamps of a trajectory that moves on, at least 0.
double usualSpeed(const Trajectory& trajectory) {
  std::vector<double> speeds;
  const std::vector<Trajectory::Stamp>& stamps = trajectory.stamps();
  for (size_t i = 1; i < stamps.size(); ++i)
    if (const double length = lengthOf(stamps[i].pose.position - stamps[i - 1].pose.position); length > 0)
      speeds.push_back(length / (stamps[i].time - stamps[i - 1].time));
  return medianOf(speeds);
}

std::string spanText(const Trajectory& trajectory) {
  return "is from " + secondsText(trajectory.begin()) + " to " + secondsText(trajectory.end());
}

/// Whether the points that this output writes have times of their own within a scan.
bool hasPointTimes(const Output& output) {
  return formatNamed(output.format).pointTimes || std::ranges::find(output.fields, Field::time) != output.fields.end();
}

/// Whether an output writes speeds that a sensor measures.
bool writesSpeeds(const Drive& drive, size_t sensor) {
  return std::ranges::any_of(drive.outputs, [&](const Output& output) {
    const bool speeds = std::ranges::find(output.fields, Field::radialSpeed) != output.fields.end() ||
                        std::ranges::find(output.fields, Field::velocity) != output.fields.end();
    return speeds && std::ranges::find(output.sensors, sensor) != output.sensors.end();
  });
}

/// Whether an actor that the sensor does not ignore moves during the drive.
bool actorsMove(const Drive& drive, const RigSensor& sensor) {
  for (size_t a = 0; a < drive.actors.size(); ++a) {
    const Actor& actor = drive.actors[a];
    const bool moves = (actor.animation && actor.animation->speed != 0) ||
                       actor.trajectory.movesWithin(drive.start, drive.start + drive.duration);
    if (moves && !sensor.isIgnored(a)) return true;
  }
  return false;
}

/// Whether the ego moves while a sensor makes one of the scans, each of which takes `duration` seconds. An ego that
/// stands in each scan and is elsewhere in the next does not.
bool egoMovesWithinScans(const Drive& drive, const RigSensor& sensor, double duration) {
  const double first = drive.start + sensor.offset, last = drive.start + drive.duration;
  std::vector<double> times = drive.ego.timesWithin(first, last);
  times.push_back(last);
  double from = first;
  for (const double to : times) {
    const double scan = first + std::floor((from - first) * sensor.rate) / sensor.rate;
    if ((from < scan + duration || to > scan + 1 / sensor.rate) && drive.ego.movesWithin(from, to)) return true;
    from = to;
  }
  return false;
}

}  // namespace

void DriveReader::warn(const std::string& path, const std::string& why) {
  drive_.warnings.push_back(path + ": " + why);
}

/// Warns of trajectories and weather whose times are not those of the drive, and of an epoch that comes twice.
void DriveReader::warnOfClocks() {
  constexpr double kUnix = 8e8;  // s; Unix times since 1995, before which nobody recorded clouds
  const double first = drive_.start, last = drive_.start + drive_.duration;
  if (drive_.epoch > kUnix && first > kUnix)
    warn("epoch", "is added to the times of the trajectory, and the drive begins at " + secondsText(first) +
                      " of them, which look like Unix times: without an epoch they are");
  const std::string span = "and the drive from " + secondsText(first) + " to " + secondsText(last);
  const Trajectory& ego = drive_.ego;
  const bool egoMoves = ego.stamps().size() > 1;
  if (egoMoves && (ego.begin() > last + kSlack || ego.end() < first - kSlack))
    warn("ego.trajectory", spanText(ego) + ", " + span + ", so the vehicle stands all the time; give another start");
  else if (egoMoves && ego.begin() > first + kSlack)
    warn("ego.trajectory", "begins at " + secondsText(ego.begin()) + ", " + span +
                               ", so the vehicle stands for the first " + secondsText(ego.begin() - first) +
                               "; give a later start");
  else if (egoMoves && ego.end() < last - kSlack)
    warn("ego.trajectory", "ends at " + secondsText(ego.end()) + ", " + span + ", so the vehicle stands for the last " +
                               secondsText(last - ego.end()) + "; give a shorter duration");

  // A drive may be a part of a recording, so that actors who come earlier or later, as the vehicle does, are meant.
  const double earliest = egoMoves ? std::min(first, ego.begin()) : first,
               latest = egoMoves ? std::max(last, ego.end()) : last;
  const auto isBeside = [&](const Actor& actor) {
    const Trajectory& trajectory = actor.trajectory;
    return trajectory.stamps().size() > 1 &&
           (trajectory.begin() > latest + kSlack || trajectory.end() < earliest - kSlack);
  };
  const auto found = std::ranges::find_if(drive_.actors, isBeside);
  if (found != drive_.actors.end()) {
    const auto count = std::ranges::count_if(drive_.actors, isBeside);
    warn(entryPath("actors", static_cast<size_t>(found - drive_.actors.begin())) + ".trajectory",
         spanText(found->trajectory) + ", " + span + ", so " + inQuotes(found->name) +
             (found->goneOutside ? " is never there" : " stands all the time") + "; \"begin\" moves its first time" +
             (count > 1 ? " (of " + std::to_string(count) + " trajectories beside the drive this is the first)" : ""));
  }

  const std::vector<WeatherStamp>& weather = drive_.weather;
  if (weather.size() > 1 &&
      (weather[0].time > latest - first + kSlack || weather.back().time < earliest - first - kSlack))
    warn("weather[0].time", "is " + secondsText(weather[0].time) +
                                ", and times of weather count from the start of the drive, which lasts " +
                                secondsText(drive_.duration));
}

/// Warns of a pose file of the vehicle whose times are in another unit, or that lacks poses during the drive, and
/// returns whether it does.
bool DriveReader::warnOfStamps() {
  constexpr size_t kFew = 10;       // poses, which a person may have placed
  constexpr double kGap = 20;       // times the usual spacing
  constexpr double kSlow = 60;      // s between the poses of a recording
  constexpr double kStands = 0.01;  // m
  const Trajectory& ego = drive_.ego;
  const std::vector<Trajectory::Stamp>& stamps = ego.stamps();
  const auto& stated = root_["ego"]["trajectory"];
  const bool recorded = stated.contains("file") && !stated.value("format", "tum").starts_with("carla");
  if (!recorded || stamps.size() < kFew) return false;
  const double usual = ego.spacing(), first = drive_.start, last = drive_.start + drive_.duration;
  if (usual > kSlow) {
    warn("ego.trajectory.file", doubtOfSeconds(usual));
    return true;
  }
  size_t longest = 0, count = 0;  // the longest gap ends at this stamp
  const auto lengthAt = [&](size_t i) { return stamps[i].time - stamps[i - 1].time; };
  for (size_t i = 1; i < stamps.size(); ++i) {
    if (lengthAt(i) <= kGap * usual || stamps[i].time <= first || stamps[i - 1].time >= last) continue;
    if (lengthOf(stamps[i].pose.position - stamps[i - 1].pose.position) < kStands) continue;
    ++count;
    if (longest == 0 || lengthAt(i) > lengthAt(longest)) longest = i;
  }
  if (count > 0)
    warn("ego.trajectory.file", "has no pose from " + secondsText(stamps[longest - 1].time) + " to " +
                                    secondsText(stamps[longest].time) + ", " +
                                    roundedText(lengthAt(longest) / usual, 2) +
                                    " times as long as between most poses, so the vehicle goes straight" +
                                    (count > 1 ? " (of " + std::to_string(count) + " gaps this is the longest)" : ""));
  return count > 0;
}

/// Warns of a pose file that has the vehicle upside down, as quaternions with w first instead of last do.
void DriveReader::warnOfOrientations() {
  constexpr double kOnEarth = 1e6;  // m; beyond, the origin may be the centre of the earth, and z is not up
  const auto& stated = root_["ego"]["trajectory"];
  if (!stated.contains("file") || stated.value("format", "tum") != "tum") return;
  size_t poses = 0, upsideDown = 0;
  for (const auto& [time, pose] : drive_.ego.stamps()) {
    if (time < drive_.start - kSlack || time > drive_.start + drive_.duration + kSlack) continue;
    ++poses;
    upsideDown += lengthOf(pose.position) < kOnEarth && (pose.orientation * Vec3{0, 0, 1}).z < -0.5;
  }
  if (upsideDown > poses / 2)
    warn("ego.trajectory.file", "has the vehicle upside down in " + std::to_string(upsideDown) + " of " +
                                    std::to_string(poses) + " poses; lines are t x y z qx qy qz qw, with w last");
}

/// Warns of actors, and of the vehicle if asked to, that go from one stamp to the next faster than anything on a road,
/// and much faster than the vehicle usually does, which may be an aircraft.
void DriveReader::warnOfJumps(bool ofEgo) {
  constexpr double kFast = 100, kTimes = 10;  // m/s; times as fast as the vehicle usually is
  const double limit = std::max(kFast, kTimes * usualSpeed(drive_.ego));
  const double first = drive_.start, last = drive_.start + drive_.duration;
  const auto text = [](const std::string& name, const Way& way) {
    return name + " goes " + roundedText(way.length, 3) + " m in " + roundedText(way.to - way.from, 3) + " s from " +
           secondsText(way.from) + " on, at " + roundedText(way.speed(), 3) +
           " m/s; positions are in metres and times in seconds";
  };
  const Way own = fastestWay(drive_.ego, first, last);
  if (ofEgo && own.speed() > limit) warn("ego.trajectory", text("the vehicle", own));
  size_t fastest = 0, count = 0;
  Way way = {0, 1, 0};
  for (size_t a = 0; a < drive_.actors.size(); ++a) {
    const Way found = fastestWay(drive_.actors[a].trajectory, first, last);
    if (!(found.speed() > limit)) continue;
    ++count;
    if (!(found.speed() > way.speed())) continue;
    fastest = a;
    way = found;
  }
  if (count > 0)
    warn(entryPath("actors", fastest) + ".trajectory",
         text(inQuotes(drive_.actors[fastest].name), way) +
             ", and what appears elsewhere is another actor, both with \"outside\": \"gone\"" +
             (count > 1 ? " (of " + std::to_string(count) + " actors that do so this is the fastest)" : ""));
}

/// Warns of scans that go on when the trajectory of a vehicle that moves has ended: it stops at once, which no inertial
/// unit measures.
void DriveReader::warnOfEnd() {
  const Trajectory& ego = drive_.ego;
  const double last = drive_.start + drive_.duration;
  if (ego.end() < last - kSlack || !ego.movesWithin(ego.end() - Trajectory::kAround, ego.end())) return;
  size_t found = drive_.sensors.size();
  double latest = 0, shorter = drive_.duration;  // the end of scans, and a duration without those that end too late
  for (size_t s = 0; s < drive_.sensors.size(); ++s) {
    const auto scan = lastScanOf(drive_, s, drive_.frameCount() - 1);
    if (!scan || scan->end <= ego.end() + kSlack) continue;
    if (scan->end > latest) found = s;
    latest = std::max(latest, scan->end);
    shorter = std::min(shorter, scan->start - drive_.start);
  }
  if (found == drive_.sensors.size()) return;
  shorter = 1e-3 * std::floor(1e3 * (shorter + 1e-9));  // whole milliseconds, which secondsText() does not round up
  warn("ego.trajectory", "ends at " + secondsText(ego.end()) + ", and the last scan of " +
                             inQuotes(drive_.sensors[found].name) + " at " + secondsText(latest) +
                             ", so the vehicle stops at once and stands for the rest of it; give a longer trajectory" +
                             (shorter > 0 ? ", or a duration of at most " + secondsText(shorter) : ""));
}

/// Warns of fields of a driver's clouds that have no value, and of heads whose lines are more than nodes for Livox's
/// expect.
void DriveReader::warnOfDriver(const RigSensor& sensor, const std::string& path) {
  if (!sensor.driver && !sensor.livoxCustom) return;
  const Effects& effects = sensor.effects;
  if (effects.intensity.use == EffectUse::off)
    warn(path + ".driver",
         "the intensities in the clouds of " + inQuotes(sensor.name) + " are 0, because its effect intensity is off");
  const uint32_t returns = effects.returns.count > 0 ? effects.returns.count : sensor.sensor.maxReturns;
  if (sensor.driver == ros2::Driver::autoware && effects.returns.use != EffectUse::off &&
      effects.returns.mode == Effects::Returns::Mode::all && returns > 1)
    warn(path + ".driver", "the return types in the clouds of " + inQuotes(sensor.name) +
                               " are 0, unknown, because its effect returns has the mode all; the mode dual gives "
                               "Autoware's types of pairs");
  constexpr uint32_t kMostLines = 6;  // of Livox's heads: those of the Avia
  const uint32_t lines = ros2::lastRingOf(sensor.sensor) + 1;
  if ((sensor.livoxCustom || sensor.driver == ros2::Driver::livox) && lines > kMostLines)
    warn(path + ".driver", "Livox's heads have at most 6 lines, and " + inQuotes(sensor.name) + " has " +
                               std::to_string(lines) +
                               "; nodes such as FAST-LIO drop points whose line is not below their scan_line");
}

/// Warns of a mounting on a vehicle so far away that its numbers may be in another unit. A site, where nothing
/// drives, may be larger.
void DriveReader::warnOfMount(const Pose& mount, const std::string& path) {
  const bool drives = drive_.ego.movesWithin(drive_.ego.begin(), drive_.ego.end());
  const double far = drives ? 50 : 1000;  // m
  if (const double distance = lengthOf(mount.position); distance > far)
    warn(path + ".mount.position",
         "is " + gnosphere::numberText(std::round(distance)) + " m from the vehicle's origin; positions are in metres");
}

/// Warns of fog, rain and snow of the drive's weather that the effects of a sensor turn off.
void DriveReader::warnOfWeather(const RigSensor& sensor, const std::string& path) {
  const auto any = [&](double WeatherStamp::*value) {
    return std::ranges::any_of(drive_.weather, [&](const WeatherStamp& stamp) { return stamp.*value > 0; });
  };
  std::vector<std::string> off;
  const auto check = [&](const char* name, EffectUse use, double WeatherStamp::*value) {
    if (use == EffectUse::off && any(value)) off.push_back(name);
  };
  check("fog", sensor.effects.fog.use, &WeatherStamp::fog);
  check("rain", sensor.effects.rain.use, &WeatherStamp::rain);
  check("snow", sensor.effects.snow.use, &WeatherStamp::snow);
  if (!off.empty())
    warn(path + ".effects", "turn " + listed(off) + " off, so " + inQuotes(sensor.name) +
                                " scans without this part of the drive's weather; \"use\": \"auto\" adds it");
}

/// Warns of motion within the scans of a sensor that its effects turn off, if an output has times of its points, or
/// their speeds.
void DriveReader::warnOfMotion(size_t index, const std::string& path) {
  const RigSensor& sensor = drive_.sensors[index];
  const double scan = durationOf(sensor.sensor, 0);
  if (!(scan > 0)) return;
  const auto hasTimes = [&](const Output& output) {
    return hasPointTimes(output) && std::ranges::find(output.sensors, index) != output.sensors.end();
  };
  const auto output = std::ranges::find_if(drive_.outputs, hasTimes);
  const bool timed = output != drive_.outputs.end(),
             objects = sensor.effects.objectMotion.use == EffectUse::off && actorsMove(drive_, sensor);
  std::vector<std::string> off;
  std::string consequences;
  if (timed && sensor.effects.sensorMotion.use == EffectUse::off && egoMovesWithinScans(drive_, sensor, scan))
    off.push_back("sensor-motion");
  if (objects) off.push_back("object-motion");
  if (timed && !off.empty())
    consequences = "a scan of " + inQuotes(sensor.name) +
                   " shows its start alone, although the times of its points in " + output->format + " go on to " +
                   secondsText(scan);
  if (objects && writesSpeeds(drive_, index))
    consequences += (consequences.empty() ? "" : ", and ") + std::string("radial_speed and velocity of ") +
                    inQuotes(sensor.name) + " have no speeds of actors";
  if (!consequences.empty())
    warn(path + ".effects", "turn " + listed(off) + " off, so " + consequences + "; \"use\": \"auto\" lets them move");
}

/// Warns of speeds of actors that a sensor whose beams fire at once does not measure.
void DriveReader::warnOfSpeeds(size_t index, const std::string& path) {
  const RigSensor& sensor = drive_.sensors[index];
  if (firesInTurn(sensor.sensor) || !writesSpeeds(drive_, index) || !actorsMove(drive_, sensor)) return;
  warn(path + ".sensor",
       "all beams of " + inQuotes(sensor.name) +
           " fire at once, so nothing moves within its scans, and radial_speed and velocity have no speeds of actors; "
           "a rotation_period of 0.001 s lets them move");
}

/// Returns the usual length of a sensor's beams in metres: 100, or for an aircraft its distance from the scenes.
double lengthOfBeams(const Drive& drive, const Sensor& sensor) {
  const Vec3 place = drive.ego.at(drive.start + 0.5 * drive.duration).position;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Scene& scene : drive.scenes) {
    const Bounds bounds = worldBounds(scene);
    if (!bounds.empty()) nearest = std::min(nearest, lengthOf(highest(lowest(place, bounds.max), bounds.min) - place));
  }
  return std::max(100.0, std::min(nearest, static_cast<double>(sensor.rangeMax)));
}

/// Warns of long scans of a list of beams whose vehicle shakes: between the poses that a scan knows it goes straight.
void DriveReader::warnOfPaths(size_t index, const std::string& path) {
  constexpr double kOff = 0.02, kFine = 0.01;  // m
  const RigSensor& sensor = drive_.sensors[index];
  const Trajectory& ego = drive_.ego;
  if (sensor.sensor.isGrid() || sensor.effects.sensorMotion.use == EffectUse::off) return;
  const ScanTimes scan = scanTimesOf(sensor.sensor, true);
  const std::vector<double> stamps = ego.timesWithin(drive_.start, drive_.start + drive_.duration);
  const double far = lengthOfBeams(drive_, sensor.sensor);
  // How far a beam is off `far` from the sensor at a stamp in the middle of a line between poses.
  const auto mostOff = [&](double step) {
    double most = 0;
    for (const double time : stamps) {
      const double from = time - step / 2, to = time + step / 2;
      const Pose pose = ego.at(time), between = poseAt({{{from, ego.at(from)}, {to, ego.at(to)}}}, {}, time);
      most = std::max(
          most, lengthOf(between.position - pose.position) + far * angleBetween(between.orientation, pose.orientation));
    }
    return most;
  };
  const double off = scan.step > 0 ? mostOff(scan.step) : 0;
  if (!(off > kOff)) return;
  // The distance grows with the step until that is as long as the time between stamps.
  const double step = std::min(scan.step, ego.spacing()), longest = kListIntervals * step * kFine / mostOff(step);
  const double unit = std::pow(10, std::floor(std::log10(longest)));
  warn(path + ".sensor",
       "a scan of " + inQuotes(sensor.name) + " lasts " + secondsText(scan.last - scan.earliest) + " and knows " +
           std::to_string(kListIntervals) + " poses, between which beams " + gnosphere::numberText(std::round(far)) +
           " m long are up to " + gnosphere::numberText(std::round(100 * off) / 100) +
           " m off where the trajectory leads them; in scans of at most " +
           gnosphere::numberText(unit * std::floor(longest / unit)) + " s they are within a centimetre");
}

/// Warns of a sensor that makes more scans than the drive has, whose file does not state how many are wanted.
void DriveReader::warnOfRate(size_t index, const std::string& path) {
  const RigSensor& sensor = drive_.sensors[index];
  const double period = scanPeriodOf(sensor.sensor);
  if (root_["sensors"][index].contains("rate") || !(period > 0) || sensor.rate * period >= 0.75) return;
  const std::string own = gnosphere::numberText(1 / period);
  warn(path + ".sensor", "makes " + own + " scans a second, and the drive has " + gnosphere::numberText(sensor.rate) +
                             " of them; give " + inQuotes(sensor.name) + " a \"rate\" of " + own + " to have all");
}

/// Warns of sensors whose scans lack something that the drive file seems to ask for.
void DriveReader::warnOfSensors() {
  for (size_t s = 0; s < drive_.sensors.size(); ++s) {
    const RigSensor& sensor = drive_.sensors[s];
    const std::string path = entryPath("sensors", s);
    if (sensor.offset >= drive_.duration - kSlack)
      warn(path + ".offset", "is " + secondsText(sensor.offset) + ", and the drive lasts " +
                                 secondsText(drive_.duration) + ", so " + inQuotes(sensor.name) + " makes no scan");
    warnOfRate(s, path);
    warnOfMount(sensor.mount, path);
    warnOfWeather(sensor, path);
    warnOfMotion(s, path);
    warnOfSpeeds(s, path);
    warnOfPaths(s, path);
    warnOfDriver(sensor, path);
  }
  if (drive_.imu) warnOfMount(drive_.imu->mount, "imu");
}

}  // namespace gnosphere::drive
