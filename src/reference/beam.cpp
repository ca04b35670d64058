// SPDX-License-Identifier: Apache-2.0
#include "reference/beam.hpp"

#include <numbers>

#include "effects/trajectory.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::reference {

namespace {

/// Surfaces that light goes on behind, and the one that stops it.
constexpr size_t kLayers = 4;

/// What one sub-ray met in one layer.
struct Piece {
  double range, energy;
  size_t order;  ///< layer by layer, sub-ray by sub-ray
  Hit hit;
};

/// Shares of the energy that hits it: thrown back, and going on behind.
struct Shares {
  double back = 1, on = 0;
};

Shares sharesOf(const View& view, const Line& line, const BeamEffects& effects, const Hit& hit) {
  const Triangle triangle = view.tree.sweeps().at(view.tree.triangles()[hit.triangle], line.time);
  const gpu::Optics4& optics = effects.optics[materialOf(view.scene, triangle)];
  Shares shares;
  if (effects.plan.looksAtMaterials) {
    const Vec3 direction = line.frame.directionToWorld(line.direction);
    const double cosine = -dot(normalAgainst(direction, triangle.corners), direction);
    shares.back = gpu::reflected(optics, static_cast<float>(cosine));
  }
  if (effects.plan.has(gpu::kTransmission)) shares.on = gpu::transmitted(optics);
  return shares;
}

/// A sub-ray through all that lets light pass.
void trace(const View& view, const Line& line, const BeamEffects& effects, size_t subRay, std::vector<Piece>& pieces,
           BeamDoubt& doubt) {
  std::vector<Hit> hits;
  double energy = effects.plan.subRays[subRay].weight;
  while (energy > 0 && hits.size() < kLayers) {
    const Hit hit = nearest(view, line, hits.empty() ? 0 : hits.back().range);
    if (hit.triangle == kNobody) break;
    const Shares shares = sharesOf(view, line, effects, hit);
    const double back = energy * shares.back;
    energy *= shares.on;
    // What lets all light pass gives no echo.
    if (back > 0 || energy == 0)
      pieces.push_back({hit.range, back, hits.size() * effects.plan.subRays.size() + subRay, hit});
    hits.push_back(hit);
  }
  doubt.tie |= inDoubt(view, line, hits, energy > 0 && hits.size() < kLayers, doubt.tolerance);
}

Line lineOf(const Beam& beam, double u, double v) {
  const Vec3 along = beam.axis.direction + u * beam.left + v * beam.up;
  return {beam.axis.frame, (1 / norm(along)) * along, beam.axis.time};
}

/// Sorted pieces that follow each other within the separation.
BeamEcho echoOf(std::span<const Piece> pieces, double pulseWidth) {
  const double first = pieces.front().range;
  double energy = 0, moment = 0, square = 0;
  const Piece* strongest = &pieces.front();
  for (const Piece& piece : pieces) {
    const double depth = piece.range - first;
    energy += piece.energy;
    moment += piece.energy * depth;
    square += piece.energy * depth * depth;
    if (piece.energy > strongest->energy || (piece.energy == strongest->energy && piece.order < strongest->order))
      strongest = &piece;
  }
  const double mean = energy > 0 ? moment / energy : 0;
  const double variance = energy > 0 ? std::max(square / energy - mean * mean, 0.0) : 0;
  const double perDeviation = 2 * std::sqrt(2 * std::numbers::ln2);  // full width at half maximum
  return {first + mean, energy, std::sqrt(pulseWidth * pulseWidth + perDeviation * perDeviation * variance),
          strongest->hit};
}

std::vector<BeamEcho> gather(std::vector<Piece>& pieces, const gpu::EffectParameters& parameters) {
  std::sort(pieces.begin(), pieces.end(),
            [](const Piece& a, const Piece& b) { return std::pair(a.range, a.order) < std::pair(b.range, b.order); });
  std::vector<BeamEcho> echoes;
  size_t first = 0;
  while (first < pieces.size() && echoes.size() < gpu::kMaxEchoes) {
    size_t end = first + 1;
    while (end < pieces.size() && pieces[end].range <= pieces[end - 1].range + parameters.separation) ++end;
    echoes.push_back(echoOf({&pieces[first], end - first}, parameters.pulseWidth));
    first = end;
  }
  return echoes;
}

gpu::Optics4 packed(const Optics& optics) {
  gpu::Optics4 result = {};
  result.reflection = {optics.reflectance, optics.gloss, optics.roughness, optics.retro};
  result.passage.x = optics.transmission;
  return result;
}

}  // namespace

std::vector<BeamEffects> beamEffects(const SimulatorOptions& options, const Scene& scene,
                                     const std::vector<Sensor>& sensors) {
  std::vector<gpu::Optics4> optics;
  for (const Optics& one : opticsOf(scene, options.materials, options.effects.intensity.wavelength))
    optics.push_back(packed(one));
  std::vector<BeamEffects> result;
  for (SensorPlan& plan : planSensors(scene, sensors, options)) result.push_back({std::move(plan), optics});
  return result;
}

Beam beamOf(const Sensor& sensor, const Shot& shot, bool sensorMoves, size_t index) {
  const Channel& channel = sensor.channels[index / sensor.columns];
  const double column = static_cast<double>(index % sensor.columns);
  const double azimuth = (-180 + 360 * column / sensor.columns + channel.azimuthOffsetDeg) * std::numbers::pi / 180;
  const double elevation = channel.elevationDeg * std::numbers::pi / 180;
  const double c = std::cos(azimuth), s = std::sin(azimuth);
  const Vec3& from = channel.origin;
  const double time = timeOf(sensor, index);
  const Pose pose = sensorMoves ? poseAt(shot.motion, shot.pose, time) : shot.pose;

  Beam beam = {{SensorFrame(pose), sensor.direction(index), time}, {}, {}, {}, pose};
  beam.origin = {c * from.x - s * from.y, s * from.x + c * from.y, from.z};
  beam.left = {-s, c, 0};
  beam.up = {-std::sin(elevation) * c, -std::sin(elevation) * s, std::cos(elevation)};
  beam.axis.frame.position = beam.axis.frame.position + beam.axis.frame.directionToWorld(beam.origin);
  return beam;
}

std::vector<BeamEcho> echoesOf(const View& view, const Beam& beam, const BeamEffects& effects,
                               const gpu::EffectParameters& parameters, size_t index, BeamDoubt& doubt) {
  const SensorPlan& plan = effects.plan;
  if (!plan.footprint()) {
    const Hit hit = nearest(view, beam.axis);
    const bool met = hit.triangle != kNobody;
    doubt.tie = inDoubt(view, beam.axis, {&hit, met ? 1u : 0u}, !met, doubt.tolerance);
    if (!met) return {};
    const double energy = plan.looksAtMaterials ? sharesOf(view, beam.axis, effects, hit).back : 1;
    return {{hit.range, energy, parameters.pulseWidth, hit}};
  }
  double u = 0, v = 0;  // tangents of how far the beam is astray
  if (plan.has(gpu::kStrays)) {
    const gpu::vec2 error = gpu::angleError(parameters, static_cast<uint32_t>(index));
    u = error.x * std::hypot(beam.axis.direction.x, beam.axis.direction.y);
    v = error.y;
  }
  std::vector<Piece> pieces;
  for (size_t i = 0; i < effects.plan.subRays.size(); ++i) {
    const SubRay& ray = effects.plan.subRays[i];
    trace(view, lineOf(beam, ray.u + u, ray.v + v), effects, i, pieces, doubt);
  }
  return gather(pieces, parameters);
}

}  // namespace gnosphere::reference
