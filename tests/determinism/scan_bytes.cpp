// SPDX-License-Identifier: Apache-2.0
// Scans a town with `standard` and `exact`, by every way of binning, and writes one cloud each into a folder. The
// script beside it runs this under other thread counts and subgroup sizes and compares the bytes.
#include <cstdio>

#include "gnosphere/gnosphere.hpp"
#include "town/town.hpp"

using namespace gnosphere;

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]), 2;
  const Scene town = makeTown({.triangles = 60'000});
  const Pose pose = {{1.3, 0.4, 1.8}, {0.01, -0.02, 0.3, 0.95}};
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact})
    for (const Binning binning : {Binning::nearest, Binning::nearest32, Binning::lists}) {
      SimulatorOptions options;
      options.accuracy = accuracy;
      options.binning = binning;
      Simulator simulator(town, builtinSensors()[0], options);
      const bool first = accuracy == Accuracy::standard && binning == Binning::nearest;
      if (first) std::printf("%s, subgroups of %u\n", simulator.device().name.c_str(), simulator.device().subgroupSize);
      const char* way = binning == Binning::nearest ? "nearest" : binning == Binning::nearest32 ? "nearest32" : "lists";
      writeCloud(simulator.scan(pose),
                 std::string(argv[1]) + (accuracy == Accuracy::exact ? "/exact-" : "/standard-") + way + ".npy");
    }
  return 0;
}
