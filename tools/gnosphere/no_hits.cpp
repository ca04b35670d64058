// SPDX-License-Identifier: Apache-2.0
#include "no_hits.hpp"

#include <algorithm>
#include <optional>

#include "console.hpp"
#include "gnosphere/error.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::cli {
namespace {

/// Returns the scan of another simulator that neither warns nor traces; none if there is no memory for it.
std::optional<Scan> quietScan(const Scene& scene, const SensorRequest& request, SimulatorOptions settings,
                              const Pose& pose) {
  settings.warn = nullptr;
  settings.trace = nullptr;
  try {
    return Simulator(scene, request, settings).scan(pose);
  } catch (const Error&) {
    return {};
  }
}

/// Returns how many beams hit if both faces of every triangle reflect; 0 if they do already, or if there is no memory
/// for a second simulator.
uint64_t hitsOnBothFaces(const Scene& scene, const SensorRequest& request, SimulatorOptions settings,
                         const Pose& pose) {
  const bool material = settings.faces == ReflectingFaces::material;
  if (settings.faces == ReflectingFaces::both ||
      (material && std::ranges::all_of(scene.materials, &Material::doubleSided)))
    return 0;
  settings.faces = ReflectingFaces::both;
  const std::optional<Scan> scan = quietScan(scene, request, settings, pose);
  return scan ? scan->counters.hits : 0;
}

/// Returns how many beams meet a surface that is nearer than their least range.
uint64_t beamsOntoNearSurfaces(const Scene& scene, const Sensor& sensor, const SimulatorOptions& settings,
                               const Pose& pose) {
  if (widestWindow(sensor).least <= 0 && sensor.rangeMin <= 0) return 0;
  Sensor all = sensor;
  all.rangeMin = 0;
  all.nearHits = NearHits::seeThrough;
  for (Channel& channel : all.channels) channel.rangeMin = 0;
  for (BeamList& pattern : all.patterns) pattern.rangeMin.clear();
  const std::optional<Scan> scan = quietScan(scene, {all, Effects::none()}, settings, pose);
  if (!scan) return 0;
  uint64_t beams = 0;
  for (size_t beam = 0; beam < scan->beamCount(); ++beam)
    beams += scan->ranges[beam * scan->returns] < rangeWindowOf(sensor, beam).least;
  return beams;
}

/// Beams that surfaces nearer than the least range take; those that see through them meet nothing behind.
Loss nearLoss(uint64_t beams, const Sensor& sensor) {
  const bool hide = sensor.nearHits == NearHits::hide;
  return {beams, "met a surface nearer than the least range",
          "surfaces nearer than " + coordinateText(sensor.rangeMin) + " m give no return" +
              (hide ? " and hide what is behind them, because near_hits of the sensor is hide" : "") +
              "; --pose moves the sensor"};
}

}  // namespace

std::vector<Loss> lossesByEffects(const Counters& counters) {
  const auto lost = [&](Cause cause, const char* why, const char* remedy) {
    return Loss{counters.causes[static_cast<size_t>(cause)], why, remedy};
  };
  std::vector<Loss> losses = {
      lost(Cause::weak, "too weak",
           "their surfaces are too dark or too far for the threshold of detection, which a larger detection.range "
           "lowers and detection=off leaves out in clear air"),
      lost(Cause::attenuated, "attenuated",
           "fog, rain, snow or dust leave too little light for the threshold of detection, which a larger "
           "detection.range lowers"),
      lost(Cause::droppedOut, "dropped out",
           "they are lost at random, with the probabilities drop-out.general_rate and drop-out.zero_intensity_rate"),
      lost(Cause::dead, "dead", "drop-out.dead_beams, or masked_beams of the sensor, names them")};
  std::erase_if(losses, [](const Loss& loss) { return loss.beams == 0; });
  return losses;
}

uint64_t beamsWithoutSurface(const Counters& counters) {
  uint64_t beams = counters.misses;
  for (const Loss& loss : lossesByEffects(counters)) beams -= loss.beams;
  return beams;
}

std::string lossText(std::vector<Loss> losses, uint64_t beams) {
  std::ranges::stable_sort(losses, std::greater(), &Loss::beams);
  std::string text = grouped(losses[0].beams) + " of " + grouped(beams) + " beams " + losses[0].why;
  for (size_t i = 1; i < losses.size(); ++i) text += ", " + grouped(losses[i].beams) + " " + losses[i].why;
  return text + "; " + losses[0].remedy;
}

void warnOfNoHits(const std::string& nobody, const ScanningOptions& options, const std::string& trajectory,
                  const Scene& scene, const SensorRequest& request, const SimulatorOptions& settings, const Pose& pose,
                  const Counters& counters) {
  const Sensor& sensor = request.sensor;
  if (scene.placedTriangleCount() == 0) {
    complain("warning: " + options.scene + " has no triangle, so every beam misses");
    return;
  }
  const bool many = !trajectory.empty();
  std::vector<Loss> losses = lossesByEffects(counters);
  const uint64_t unmet = beamsWithoutSurface(counters);
  const uint64_t near = unmet == 0 ? 0 : std::min(unmet, beamsOntoNearSurfaces(scene, sensor, settings, pose));
  if (near > 0) losses.push_back(nearLoss(near, sensor));
  std::string remedy = options.scene + " spans " + extentText(worldBounds(scene)) + ", and the sensor " +
                       (many ? "first " : "") + "at " + placeText(pose.position) + " sees as far as " +
                       coordinateText(sensor.rangeMax) + " m; " + (many ? "another --trajectory" : "--pose") +
                       " moves it, --scale changes the unit of the scene";
  if (const uint64_t hits = unmet == near ? 0 : hitsOnBothFaces(scene, request, settings, pose); hits > 0)
    remedy = "the triangles of " + options.scene +
             " that are in view face away, and only their front reflects; with --faces both " + grouped(hits) + " of " +
             grouped(sensor.beamCount()) + " beams hit";
  if (losses.empty()) {
    complain("warning: " + nobody + " hits anything; " + remedy);
    return;
  }
  if (unmet > near) losses.push_back({unmet - near, "met nothing", remedy});
  complain("warning: " + nobody + " returns anything" + (many ? "; of the first scan " : "; ") +
           lossText(losses, counters.beams));
}

}  // namespace gnosphere::cli
