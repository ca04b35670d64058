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

/// Returns the beams that meet a surface nearer than their least range, and that have no return from it.
Loss nearLoss(const Scene& scene, const SensorRequest& request, const SimulatorOptions& settings, const Pose& pose) {
  const Sensor& sensor = request.sensor;
  SensorRequest bare = {sensor, Effects::none()};
  bare.ignoredInstances = request.ignoredInstances;
  Sensor& all = bare.sensor;
  all.rangeMin = 0;
  all.nearHits = NearHits::seeThrough;
  for (Channel& channel : all.channels) channel.rangeMin = 0;
  for (BeamList& pattern : all.patterns) pattern.rangeMin.clear();
  const std::optional<Scan> scan = quietScan(scene, bare, settings, pose);
  Loss loss;
  double limit = 0;  // the largest least range of these beams
  for (size_t beam = 0; scan && beam < scan->beamCount(); ++beam) {
    const double least = rangeWindowOf(sensor, beam).least;
    if (!(scan->ranges[beam * scan->returns] < least)) continue;
    ++loss.beams;
    limit = std::max(limit, least);
  }
  const bool hide = sensor.nearHits == NearHits::hide;
  loss.why = "met a surface nearer than the least range";
  loss.remedy = "surfaces nearer than " + coordinateText(limit) + " m give no return" +
                (hide ? " and hide what is behind them, because near_hits of the sensor is hide" : "") +
                "; --pose moves the sensor";
  return loss;
}

uint64_t countOf(const Counters& counters, Cause cause) {
  return counters.causes[static_cast<size_t>(cause)];
}

}  // namespace

std::vector<Loss> lossesByEffects(const Counters& counters, bool allMasked) {
  const auto lost = [&](Cause cause, const char* why, const char* remedy) {
    return Loss{countOf(counters, cause), why, remedy};
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
      lost(Cause::notChosen, "not chosen",
           "they have fewer echoes than returns.mode counts, and another mode, such as all, reports these")};
  if (allMasked)
    losses.push_back({counters.beams, "masked", "masked_beams of the sensor names them"});
  else if (countOf(counters, Cause::dead) == counters.beams)
    losses.push_back(lost(Cause::dead, "dead", "drop-out.dead_beams, or masked_beams of the sensor, names them"));
  std::erase_if(losses, [](const Loss& loss) { return loss.beams == 0; });
  return losses;
}

uint64_t beamsWithoutSurface(const Counters& counters) {
  uint64_t beams = counters.misses;
  for (const Cause cause : {Cause::weak, Cause::attenuated, Cause::droppedOut, Cause::dead, Cause::notChosen})
    beams -= countOf(counters, cause);
  return beams;
}

std::string lossText(std::vector<Loss> losses, const Loss& unmet, uint64_t beams) {
  std::ranges::stable_sort(losses, std::greater(), &Loss::beams);
  std::string text = grouped(losses[0].beams) + " of " + grouped(beams) + " beams " + losses[0].why;
  for (size_t i = 1; i < losses.size(); ++i) text += ", " + grouped(losses[i].beams) + " " + losses[i].why;
  if (unmet.beams > 0) text += ", " + grouped(unmet.beams) + " " + unmet.why;
  return text + "; " + losses[0].remedy + (unmet.beams > losses[0].beams ? "; " + unmet.remedy : "");
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
  std::vector<Loss> losses = lossesByEffects(counters, maskedBeams(sensor) == sensor.beamCount());
  const uint64_t unmet = losses.empty() || losses[0].beams < counters.beams ? beamsWithoutSurface(counters) : 0;
  Loss near = unmet == 0 ? Loss() : nearLoss(scene, request, settings, pose);
  near.beams = std::min(near.beams, unmet);
  if (near.beams > 0) losses.push_back(near);
  std::string remedy = options.scene + " spans " + extentText(worldBounds(scene)) + ", and the sensor " +
                       (many ? "first " : "") + "at " + placeText(pose.position) + " sees as far as " +
                       coordinateText(sensor.rangeMax) + " m; " + (many ? "another --trajectory" : "--pose") +
                       " moves it, --scale changes the unit of the scene";
  if (const uint64_t hits = unmet == near.beams ? 0 : hitsOnBothFaces(scene, request, settings, pose); hits > 0)
    remedy = "the triangles of " + options.scene +
             " that are in view face away, and only their front reflects; with --faces both " + grouped(hits) + " of " +
             grouped(sensor.beamCount()) + " beams hit";
  if (losses.empty()) {
    complain("warning: " + nobody + " hits anything; " + remedy);
    return;
  }
  complain("warning: " + nobody + " returns anything" + (many ? "; of the first scan " : "; ") +
           lossText(losses, {unmet - near.beams, "met nothing", remedy}, counters.beams));
}

}  // namespace gnosphere::cli
