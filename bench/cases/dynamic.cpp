// SPDX-License-Identifier: Apache-2.0
// gnosphere-bench dynamic: everything may move, so a rival's structure is renewed for every scan.
#include <algorithm>
#include <cmath>
#include <memory>

#include "cases.hpp"
#include "cases/results.hpp"
#include "rivals/embree.hpp"
#include "town/town.hpp"

namespace gnosphere::bench {
namespace {

struct Options {
  std::string device = "auto", sensor = "HDL-64E";
  uint64_t triangles = 1'000'000;
  uint32_t runs = 20;
};

int run(const Options& options) {
  const Scene town = makeTown({options.triangles, 1});
  const Sensor sensor = findSensor(options.sensor);
  const Pose pose = {{0, 0, 1.8}, {}};
  SimulatorOptions settings;
  settings.device = options.device;
  settings.faces = Faces::both;
  Simulator simulator(town, sensor, settings);
  Scan ours = simulator.scan(pose);
  printHead(simulator.device());
  const std::pair<EmbreeWay, bool> kWays[] = {{EmbreeWay::flat, false},
                                              {EmbreeWay::instanced, false},
                                              {EmbreeWay::rebuilt, true},
                                              {EmbreeWay::placed, true},
                                              {EmbreeWay::refitted, true}};
  std::vector<Moved> moved;
  for (size_t i = 0; i < town.instances.size(); ++i) moved.push_back({i, town.instances[i].transform});
  for (const auto& [way, moving] : kWays) {
    const std::unique_ptr<Rival> rival = makeEmbree(town, pose.position, way);
    Hits hits;
    std::vector<double> build, update, trace, device, ratio, total;
    for (uint32_t run = 0; run <= options.runs; ++run) {
      if (run == 0 || way == EmbreeWay::rebuilt) build.push_back(rival->build());
      if (moving && way != EmbreeWay::rebuilt) update.push_back(rival->update(moved));
      trace.push_back(rival->trace(sensor, pose, hits));
      total.push_back(trace.back() + (way == EmbreeWay::rebuilt ? build.back() : moving ? update.back() : 0));
      device.push_back(simulator.scan(pose).timings.wallMs);
      ratio.push_back(total.back() / device.back());
    }
    size_t differ = 0;
    for (size_t beam = 0; beam < ours.beamCount(); ++beam) {
      const float a = ours.ranges[beam], b = hits.ranges[beam];
      differ += std::isnan(a) != std::isnan(b) || std::abs(a - b) > 1e-3f + 1e-4f * a;
    }
    cli::say("rival", rival->name());
    cli::say("",
             cli::formatted("build %.1f  update %.1f  trace %.2f  total %.2f  ours wall %.2f ms  ours is %.2f times as "
                            "fast; %zu beams differ, %.0f MB",
                            spreadOf(build).median, spreadOf(update).median, spreadOf(trace).median,
                            spreadOf(total).median, spreadOf(device).median, spreadOf(ratio).median, differ,
                            static_cast<double>(rival->memoryBytes()) * 1e-6));
  }
  return 0;
}

}  // namespace

Action addDynamic(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  app.add_option("--device", options->device, "As gnosphere scan --device")->capture_default_str();
  app.add_option("--sensor", options->sensor, "A built-in name or a JSON file")->capture_default_str();
  app.add_option("--triangles", options->triangles, "Of the town")->capture_default_str();
  app.add_option("--runs", options->runs, "Timed scans")->capture_default_str();
  return [options] { return run(*options); };
}

}  // namespace gnosphere::bench
