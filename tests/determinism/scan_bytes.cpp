// SPDX-License-Identifier: Apache-2.0
// Scans a town with `standard` and `exact`, by each of the given ways of binning, and writes one cloud each into a
// folder. The script beside it runs this under other thread counts and subgroup sizes and compares the bytes.
#include <cstdio>

#include "gnosphere/gnosphere.hpp"
#include "town/town.hpp"

using namespace gnosphere;

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: %s FOLDER nearest|nearest32|lists...\n", argv[0]), 2;
  const Scene town = makeTown({.triangles = 60'000});
  const Pose pose = {{1.3, 0.4, 1.8}, {0.01, -0.02, 0.3, 0.95}};
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact})
    for (int i = 2; i < argc; ++i) {
      const std::string way = argv[i];
      SimulatorOptions options;
      options.accuracy = accuracy;
      options.binning = way == "lists" ? Binning::lists : way == "nearest32" ? Binning::nearest32 : Binning::nearest;
      Simulator simulator(town, builtinSensors()[0], options);
      const DeviceInfo& device = simulator.device();
      if (accuracy == Accuracy::standard && i == 2)
        std::printf("%s, subgroups of %u\n", device.name.c_str(), device.subgroupSize);
      const char* setting = accuracy == Accuracy::exact ? "/exact-" : "/standard-";
      writeCloud(simulator.scan(pose), argv[1] + (setting + way) + ".npy");
    }
  return 0;
}
