// SPDX-License-Identifier: Apache-2.0
// Scans a town with `standard`, with `exact`, and with `standard` and effects, by each of the given ways of binning,
// and writes a cloud of each into a folder. With GNOSPHERE_SLOW the sensor is a list of beams, without effects. The
// script next to it runs this with different thread counts and subgroup sizes and compares the bytes.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "gnosphere/gnosphere.hpp"
#include "town/town.hpp"

using namespace gnosphere;

namespace {

/// Requests all effects that draw random numbers or sum weights, along a line or over a footprint.
void addEffects(bool footprint, SensorRequest& request) {
  Effects& effects = request.effects = {};
  effects.detection = {EffectUse::on, 0.1, 80, 0.2};
  effects.dropOut = {EffectUse::on, 0.1, 0.8, 0.4, {3, 700}};
  effects.rangeNoise = {EffectUse::on, 0.01, 0.02, 1e-4, 0};
  effects.intensityNoise = {EffectUse::on, 0.05};
  effects.angleNoise = {EffectUse::on, 1e-3, 1e-3,
                        footprint ? Effects::AngleNoise::At::beam : Effects::AngleNoise::At::point};
  effects.fog.visibility = 60;
  effects.rain.rate = 20;
  effects.volumes.boxes = {{{3, -5, -1}, {12, 4, 5}, 0.05}};
  effects.returns.count = 3;
  if (footprint) effects.divergence = {EffectUse::on, 7, Effects::Divergence::Profile::gaussian, 3e-3, 1.5e-3};
  request.fields = {Field::intensity, Field::width, Field::normal, Field::label};
}

/// Beams in any direction from heads at three places.
Sensor rig() {
  Sensor sensor;
  sensor.name = "rig";
  sensor.rangeMax = 100;
  BeamList& beams = sensor.patterns.emplace_back();
  uint32_t random = 1;
  const auto next = [&] { return (random = 1664525 * random + 1013904223) / 2147483648.0 - 1; };
  while (beams.size() < 3000) {
    const Vec3 d = {next(), next(), next()};
    const double length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    if (length < 0.1) continue;
    beams.directions.push_back({d.x / length, d.y / length, d.z / length});
    beams.origins.push_back({3.0 * static_cast<double>(beams.size() % 3) + 0.02 * next(), 0.02 * next(), 0.1});
  }
  return sensor;
}

const std::map<std::string, Binning> kWays = {
    {"nearest", Binning::nearest}, {"lists", Binning::lists}, {"slabs", Binning::slabs}};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: %s FOLDER nearest|lists|slabs...\n", argv[0]), 2;
  const Scene town = makeTown({.triangles = 60'000});
  const Pose pose = {{1.3, 0.4, 1.8}, {0.01, -0.02, 0.3, 0.95}};
  const bool list = std::getenv("GNOSPHERE_SLOW") != nullptr;
  for (const std::string setting : {"standard", "exact", "effects", "footprint"}) {
    if (list && setting != "standard" && setting != "exact") continue;
    for (int i = 2; i < (setting == "footprint" ? 3 : argc); ++i) {  // a footprint supports one way of binning
      const std::string way = argv[i];
      SimulatorOptions options;
      SensorRequest request = {list ? rig() : builtinSensors()[0], Effects::none()};
      options.accuracy = setting == "exact" ? Accuracy::exact : Accuracy::standard;
      if (setting == "effects" || setting == "footprint") addEffects(setting == "footprint", request);
      options.tuning.binning = kWays.at(way);
      Simulator simulator(town, request, options);
      const DeviceInfo& device = simulator.device();
      if (setting == "standard" && i == 2)
        std::printf("%s, subgroups of %u\n", device.name.c_str(), device.subgroupSize);
      CloudOptions cloud = {defaultFields()};
      cloud.fields.insert(cloud.fields.end(), request.fields.begin(), request.fields.end());
      writeCloud(simulator.scan(pose), std::string(argv[1]) + "/" + setting + "-" + way + ".npy", cloud);
    }
  }
  return 0;
}
