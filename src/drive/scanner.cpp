// SPDX-License-Identifier: Apache-2.0
#include "drive/scanner.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "base/units.hpp"
#include "drive/pose_math.hpp"
#include "drive/ros.hpp"
#include "gnosphere/options.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::drive {
namespace {

template <typename Effect>
bool isOn(const Effect& effect) {
  return effect.use != EffectUse::off;
}

/// Returns the weather that the effects of a sensor ask for.
Weather ownWeather(const Effects& effects) {
  Weather weather;
  if (isOn(effects.fog)) weather.visibility = effects.fog.visibility;
  if (isOn(effects.rain)) weather.rainRate = effects.rain.rate;
  if (isOn(effects.snow)) weather.snowRate = effects.snow.rate;
  if (isOn(effects.volumes)) weather.volumes = effects.volumes.boxes;
  return weather;
}

/// Returns the rows of a material table whose names the scene has. readDrive() has already warned of the other rows.
MaterialTable materialsOf(const Scene& scene, const MaterialTable& table) {
  std::vector<std::string> unused;
  opticsOf(scene, table, 905, &unused);
  const std::set<std::string> absent(unused.begin(), unused.end());
  MaterialTable result = table;
  std::erase_if(result.rows, [&](const MaterialTable::Row& row) { return absent.contains(row.name); });
  return result;
}

}  // namespace

Scanner::Scanner(const Drive& drive, const World& world, const std::vector<std::set<Field>>& fields,
                 SimulatorOptions options)
    : drive_(drive),
      world_(world),
      placed_(world.scene().instances.size()),
      warned_(drive.sensors.size()),
      warn_(options.warn) {
  for (const std::string& assignment : drive.simulator) assign(options, assignment);
  options.materials = materialsOf(world.scene(), drive.materials);
  std::vector<SensorRequest> requests;
  for (size_t s = 0; s < drive.sensors.size(); ++s) requests.push_back(requestOf(s, fields[s]));
  simulator_.emplace(world.scene(), requests, options);
  for (size_t s = 0; s < requests.size(); ++s) {
    const Plan plan = simulator_->plan(s);
    motions_.push_back({plan.has("sensor-motion"), plan.has("object-motion"), plan.has("radial-speed")});
  }
  for (size_t i = 0; i < placed_.size(); ++i) placed_[i] = world.scene().instances[i].transform;
}

void Scanner::scan(FrameRecord& record) {
  const std::vector<PlannedScan> planned = scansOf(drive_, record.frame);
  record.scans.resize(planned.size());
  for (size_t i = 0; i < planned.size(); ++i) {
    record.scans[i].planned = planned[i];
    scan(record.scans[i]);
  }
}

SensorRequest Scanner::requestOf(size_t sensor, std::set<Field> fields) const {
  const RigSensor& rigged = drive_.sensors[sensor];
  fields.insert(Field::time);
  if (isFlat(rigged.sensor)) fields.insert(Field::cause);  // a laser scan has NaN for beams that are dead or lost
  if (rigged.effects.intensity.use == EffectUse::off) fields.erase(Field::intensity);
  SensorRequest request(rigged.sensor, rigged.effects, {fields.begin(), fields.end()});
  request.sensor.name = rigged.name;  // which warnings and errors tell, as a rig may have several heads of one kind
  for (const size_t actor : rigged.ignores)
    for (const uint32_t instance : world_.instancesOf(actor)) request.ignoredInstances.push_back(instance);
  request.variableWeather = weatherFor(sensor, drive_.start).has_value();
  return request;
}

std::optional<Weather> Scanner::weatherFor(size_t sensor, double time) const {
  const Effects& effects = drive_.sensors[sensor].effects;
  const WeatherKinds& stated = drive_.weatherKinds;
  const std::optional<Weather> ofDrive = drive_.weatherAt(time);
  const bool fog = stated.fog && isOn(effects.fog), rain = stated.rain && isOn(effects.rain),
             snow = stated.snow && isOn(effects.snow);
  if (!ofDrive || !(fog || rain || snow)) return {};
  Weather weather = ownWeather(effects);
  if (fog) weather.visibility = ofDrive->visibility;
  if (rain) weather.rainRate = ofDrive->rainRate;
  if (snow) weather.snowRate = ofDrive->snowRate;
  return weather;
}

void Scanner::scan(RecordedScan& recorded) {
  const auto& [sensor, number, time] = recorded.planned;
  const RigSensor& rigged = drive_.sensors[sensor];
  recorded.duration = durationOf(rigged.sensor, number);
  recorded.pose = drive_.sensorPose(sensor, time);
  recorded.sensorMoves = recorded.duration > 0 && motions_[sensor].ofSensor;
  recorded.actorsMove = recorded.duration > 0 && motions_[sensor].ofActors;
  recorded.deskewed = rigged.effects.sensorMotion.deskew;
  Shot shot;
  shot.pose = recorded.pose;
  shot.sensor = sensor;
  shot.frame = number;
  shot.weather = weatherFor(sensor, time);
  if (recorded.sensorMoves || motions_[sensor].speeds) shot.motion = motionOf(recorded);
  recorded.motion = recorded.sensorMoves ? shot.motion : SensorMotion();
  placeWorld(recorded, shot);
  simulator_->scanInto(shot, recorded.scan);
  recorded.scan.sensor = rigged.sensor.name;
  recorded.points = 0;
  for (size_t entry = 0; entry < recorded.scan.ranges.size(); ++entry) {
    recorded.points += recorded.scan.returned(entry);
    uint32_t& owner = recorded.scan.instances[entry];
    if (owner != kNoTriangle) owner = world_.objectOf(owner);
  }
}

SensorMotion Scanner::motionOf(const RecordedScan& recorded) const {
  constexpr double kSagitta = 1e-4, kMostPieces = 1000;  // m
  const RigSensor& rigged = drive_.sensors[recorded.planned.sensor];
  const double begin = recorded.planned.time;
  const TimeSpan span = poseTimesOf(rigged.sensor, recorded.planned.number);
  const bool atOnce = !(span.from < span.to);
  const Trajectory::Span around = drive_.ego.around(begin);
  const double from = atOnce ? around.from : begin + span.from, to = atOnce ? around.to : begin + span.to;
  if (!drive_.ego.movesWithin(from, to)) return {};
  std::vector<double> times = {from, to};
  if (!atOnce) {
    const std::vector<double> within = drive_.ego.timesWithin(from, to);
    times.insert(times.end(), within.begin(), within.end());
    times.insert(times.end(), {begin, begin + recorded.duration});
  }
  std::sort(times.begin(), times.end());
  const double length = lengthOf(rigged.mount.position);
  SensorMotion motion;
  const auto add = [&](double time) {
    if (motion.stamps.empty() || time - begin > motion.stamps.back().time)
      motion.stamps.push_back({time - begin, drive_.sensorPose(recorded.planned.sensor, time)});
  };
  for (size_t i = 0; i < times.size(); ++i) {
    // A chord of the angle a is off its arc by length * a^2 / 8. One chord about all beams that fire at once has the
    // velocity of its middle; of two, which meet there, the later one would count alone.
    if (i > 0 && !atOnce) {
      const double angle = angleBetween(drive_.ego.at(times[i - 1]).orientation, drive_.ego.at(times[i]).orientation);
      const double pieces = std::clamp(std::ceil(angle * std::sqrt(length / (8 * kSagitta))), 1.0, kMostPieces);
      for (double k = 1; k < pieces; ++k) add(times[i - 1] + (times[i] - times[i - 1]) * k / pieces);
    }
    add(times[i]);
  }
  return motion;
}

void Scanner::warnOfDetours(const RecordedScan& recorded) {
  constexpr double kOff = 0.05;  // m
  const size_t sensor = recorded.planned.sensor;
  const RigSensor& rigged = drive_.sensors[sensor];
  const double begin = recorded.planned.time, end = begin + recorded.duration;
  const auto check = [&](const std::string& name, const World::Detour& detour) {
    if (detour.off < kOff) return;
    warned_[sensor] = true;
    warn_("within scan " + std::to_string(recorded.planned.number) + " of '" + rigged.name + "' " + name +
          (detour.ofParts ? " moves its parts"
                          : " turns by " + gnosphere::numberText(std::round(detour.angle / kDegree)) + " degrees") +
          ", and its points, which go straight from where they are at the start to where they are at the end of a "
          "scan, are up to " +
          gnosphere::numberText(std::round(100 * detour.off) / 100) +
          " m off their ways; shorter scans keep nearer to them");
  };
  if (!warn_) return;
  for (size_t scene = 0; scene < drive_.scenes.size() && !warned_[sensor]; ++scene)
    if (drive_.sceneAnimations[scene])
      check("scenes[" + std::to_string(scene) + "]", world_.detourOfScene(scene, begin, end));
  for (size_t actor = 0; actor < drive_.actors.size() && !warned_[sensor]; ++actor)
    if (!rigged.isIgnored(actor) && world_.movesWithin(actor, begin, end))
      check("the actor '" + drive_.actors[actor].name + "'", world_.detourOfActor(actor, begin, end));
}

void Scanner::placeWorld(const RecordedScan& recorded, Shot& shot) {
  const double begin = recorded.planned.time, end = begin + recorded.duration;
  const World::Setter start = {
      [&](size_t instance, const Transform& transform) {
        if (placed_[instance].rows == transform.rows) return;
        simulator_->setTransform(instance, transform);
        placed_[instance] = transform;
      },
      [&](size_t mesh, const Deformation& deformation) { simulator_->setDeformation(mesh, deformation); }};
  const World::Setter motion = {[&](size_t instance, const Transform& transform) {
                                  if (placed_[instance].rows != transform.rows)
                                    shot.instanceMotions.push_back({instance, transform});
                                },
                                [&](size_t mesh, const Deformation& deformation) {
                                  shot.meshMotions.push_back({mesh, deformation});
                                }};
  world_.placeScenes(begin, start);
  if (recorded.actorsMove) world_.placeScenes(end, motion);
  for (size_t actor = 0; actor < drive_.actors.size(); ++actor) {
    world_.place(actor, world_.poseOf(actor, begin), begin, start);
    if (!recorded.actorsMove || !world_.movesWithin(actor, begin, end)) continue;
    world_.place(actor, world_.endOf(actor, begin, end), end, motion);
  }
  if (recorded.actorsMove) warnOfDetours(recorded);
}

}  // namespace gnosphere::drive
