// SPDX-License-Identifier: Apache-2.0
#include "no_hits.hpp"

#include <algorithm>

#include "console.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::cli {
namespace {

/// Returns how many beams hit if both faces of every triangle reflect; 0 if they do already, or if there is no memory
/// for a second simulator.
uint64_t hitsOnBothFaces(const Scene& scene, const SensorRequest& request, SimulatorOptions settings,
                         const Pose& pose) {
  const bool material = settings.faces == ReflectingFaces::material;
  if (settings.faces == ReflectingFaces::both ||
      (material && std::ranges::all_of(scene.materials, &Material::doubleSided)))
    return 0;
  settings.faces = ReflectingFaces::both;
  settings.warn = nullptr;
  settings.trace = nullptr;
  try {
    return Simulator(scene, request, settings).scan(pose).counters.hits;
  } catch (const Error&) {
    return 0;
  }
}

}  // namespace

void warnOfNoHits(const std::string& nobody, const ScanningOptions& options, const std::string& trajectory,
                  const Scene& scene, const SensorRequest& request, const SimulatorOptions& settings,
                  const Pose& pose) {
  const Sensor& sensor = request.sensor;
  if (scene.placedTriangleCount() == 0) {
    complain("warning: " + options.scene + " has no triangle, so every beam misses");
    return;
  }
  const std::string start = "warning: " + nobody + " hits anything; ";
  if (const uint64_t hits = hitsOnBothFaces(scene, request, settings, pose); hits > 0) {
    complain(start + "the triangles of " + options.scene +
             " that are in view face away, and only their front reflects; with --faces both " + grouped(hits) + " of " +
             grouped(sensor.beamCount()) + " beams hit");
    return;
  }
  const bool many = !trajectory.empty();
  complain(start + options.scene + " spans " + extentText(worldBounds(scene)) + ", and the sensor " +
           (many ? "first " : "") + "at " + placeText(pose.position) + " sees as far as " +
           coordinateText(sensor.rangeMax) + " m; " + (many ? "another --trajectory" : "--pose") +
           " moves it, --scale changes the unit of the scene");
}

}  // namespace gnosphere::cli
