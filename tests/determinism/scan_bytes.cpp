// SPDX-License-Identifier: Apache-2.0
// Scans a town with `standard`, with `exact`, and with `standard` and effects, by each of the given ways of binning,
// and writes one cloud each into a folder. The script beside it runs this under other thread counts and subgroup sizes
// and compares the bytes.
#include <cstdio>
#include <map>

#include "gnosphere/gnosphere.hpp"
#include "town/town.hpp"

using namespace gnosphere;

namespace {

/// All that draws or weighs, along a line or over a footprint.
void addEffects(bool footprint, SimulatorOptions& options) {
  Effects& effects = options.effects = {};
  effects.detection = {Use::on, 0.1, 80, 0.2};
  effects.dropOut = {Use::on, 0.1, 0.8, 0.4, {3, 700}};
  effects.rangeNoise = {Use::on, 0.01, 0.02, 1e-4, 0};
  effects.intensityNoise = {Use::on, 0.05};
  effects.angleNoise = {Use::on, 1e-3, 1e-3,
                        footprint ? Effects::AngleNoise::At::beam : Effects::AngleNoise::At::point};
  effects.fog.visibility = 60;
  effects.rain.rate = 20;
  effects.volumes.boxes = {{{3, -5, -1}, {12, 4, 5}, 0.05}};
  effects.returns.count = 3;
  if (footprint) effects.divergence = {Use::on, 7, Effects::Divergence::Profile::gaussian, 3e-3, 1.5e-3};
  options.fields = {Field::intensity, Field::width, Field::normal, Field::label};
}

const std::map<std::string, Binning> kWays = {
    {"nearest", Binning::nearest}, {"lists", Binning::lists}, {"slabs", Binning::slabs}};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: %s FOLDER nearest|lists|slabs...\n", argv[0]), 2;
  const Scene town = makeTown({.triangles = 60'000});
  const Pose pose = {{1.3, 0.4, 1.8}, {0.01, -0.02, 0.3, 0.95}};
  for (const std::string setting : {"standard", "exact", "effects", "footprint"})
    for (int i = 2; i < (setting == "footprint" ? 3 : argc); ++i) {  // which has one way
      const std::string way = argv[i];
      SimulatorOptions options;
      options.accuracy = setting == "exact" ? Accuracy::exact : Accuracy::standard;
      if (setting == "effects" || setting == "footprint") addEffects(setting == "footprint", options);
      options.binning = kWays.at(way);
      Simulator simulator(town, builtinSensors()[0], options);
      const DeviceInfo& device = simulator.device();
      if (setting == "standard" && i == 2)
        std::printf("%s, subgroups of %u\n", device.name.c_str(), device.subgroupSize);
      CloudOptions cloud = {defaultFields()};
      cloud.fields.insert(cloud.fields.end(), options.fields.begin(), options.fields.end());
      writeCloud(simulator.scan(pose), std::string(argv[1]) + "/" + setting + "-" + way + ".npy", cloud);
    }
  return 0;
}
