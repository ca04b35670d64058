// SPDX-License-Identifier: Apache-2.0
#include "reference/beam.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>

#include "base/vector.hpp"
#include "effects/trajectory.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::reference {

namespace {

/// Most surfaces that one sub-ray meets: all but the last let light pass.
constexpr size_t kLayers = 4;
/// Most echoes of a beam that reports at most 3 returns, and of one that reports more.
constexpr size_t kFewReturns = 3, kFewEchoes = 6, kManyEchoes = 16;
// Metres: the beams of a list are projected from a place not farther from their lasers.
constexpr double kFarthestLaser = 0.52;

/// One hit of one sub-ray.
struct Piece {
  double range;
  Bounded reach;  ///< metres: how far the surface goes on in front and behind, where the sub-ray stands for its light
  Bounded energy;
  size_t order;  ///< position in the order layer by layer, then sub-ray by sub-ray
  Hit hit;
};

/// The light of a sub-ray that comes to a surface, or to the end of the world.
struct Step {
  double range;
  Bounded light;
};
using Path = std::vector<Step>;

/// Shares of the incident energy: reflected (`back`), and transmitted to what lies behind (`on`).
struct Shares {
  Bounded back = 1, on = 0;
};

/// How a sub-ray meets the plane of a triangle.
struct Incidence {
  Vec3 normal;     ///< unit vector, in the sensor's frame
  double tilt;     ///< bound of the error of its direction, in radians
  Bounded cosine;  ///< of the angle of incidence
};

/// Moving corners by d tilts a triangle of height h by at most 2 d / h, and the cross product of two edges has an error
/// of 10 u times the product of their lengths.
Incidence incidenceOf(const View& view, const Line& line, const Triangle& triangle) {
  const Vec3 corners[3] = {line.frame.toSensor(triangle.corners[0]), line.frame.toSensor(triangle.corners[1]),
                           line.frame.toSensor(triangle.corners[2])};
  const double longest = std::max(
      {lengthOf(corners[1] - corners[0]), lengthOf(corners[2] - corners[1]), lengthOf(corners[0] - corners[2])});
  const double height = lengthOf(cross(corners[1] - corners[0], corners[2] - corners[0])) / longest;
  const CornerError error = errorOf(view, line, triangle.instance);
  const double farthest = std::max({lengthOf(corners[0]), lengthOf(corners[1]), lengthOf(corners[2])});
  const double tilt = (2 * (error.relative * farthest + error.absolute) + 10 * kUnitRoundoff * longest) / height +
                      kDirectionError + line.astray;
  const Vec3 normal = normalTowardsOrigin(corners);
  const double cosine = std::abs(dot(normal, line.direction));
  const double sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
  return {normal, tilt, rounded(cosine, std::min(sine * tilt + tilt * tilt / 2, 1.0), 8 * kUnitRoundoff)};
}

/// How far the part of the footprint that a sub-ray stands for reaches on the plane of the surface, in front of its hit
/// and behind it. On a slope neighbouring sub-rays may lie farther apart than the separation of echoes, but the light
/// between them fills the gap. The part is an ellipse whose half axes have the tangents of `cell`.
Bounded reachOf(const Beam& beam, const std::array<double, 2>& cell, const Incidence& incidence, double range) {
  const double across = dot(incidence.normal, beam.left), upwards = dot(incidence.normal, beam.up);
  const double error = std::max(cell[0], cell[1]) * incidence.tilt;
  const Bounded slope = rounded(lengthOf(across * cell[0], upwards * cell[1]), error, 8 * kUnitRoundoff);
  return given(range) * slope / max(incidence.cosine, 1e-6);
}

/// Energy that a surface reflects, as a multiple of what a white Lambertian surface at normal incidence reflects: the
/// diffuse part, the retro-reflector, and a glossy lobe in the direction of the light source: GGX (Walter et al., EGSR
/// 2007) with Smith's shadowing (Heitz, JCGT 2014), alpha = roughness^2, at least 0.05.
Bounded reflected(const Optics& optics, const Bounded& cosine) {
  const Bounded result = Bounded(double{optics.reflectance} + optics.retro) * cosine;
  if (!(optics.gloss > 0)) return result;
  const double alpha = std::max(double{optics.roughness} * optics.roughness, 0.05);
  const Bounded square = given(alpha * alpha), cosineSquare = cosine * cosine;
  const Bounded sineSquare = Bounded(1) - cosineSquare, t = cosineSquare * square + sineSquare;
  const Bounded shadowing = sqrt(cosineSquare + square * sineSquare);
  return result + Bounded(double{optics.gloss}) * (square / (Bounded(4) * t * t * shadowing));
}

Triangle triangleOf(const View& view, const Line& line, const Hit& hit) {
  return view.tree.sweeps().at(view.tree.triangles()[hit.triangle], line.time);
}

Shares sharesOf(const View& view, const BeamEffects& effects, const Triangle& triangle, const Bounded& cosine) {
  const Optics& optics = effects.optics[materialOf(view.scene, triangle)];
  Shares shares;
  if (effects.plan.looksAtMaterials) shares.back = reflected(optics, cosine);
  // Light passes the surface twice, on its way there and back.
  if (effects.plan.has(gpu::kTransmission)) shares.on = Bounded(double{optics.transmission} * optics.transmission);
  return shares;
}

/// Follows a sub-ray through all surfaces that let light pass. `goesOn` becomes true if light passes the last surface
/// that is looked at.
Path trace(const View& view, const Beam& beam, const Line& line, const BeamEffects& effects, size_t subRay,
           std::vector<Piece>& pieces, BeamDoubt& doubt, bool& goesOn) {
  std::vector<Hit> hits;
  Path path;
  Bounded energy = effects.footprint[subRay].weight;
  while (energy.value > 0 && hits.size() < kLayers) {
    const Hit hit = nearest(view, line, hits.empty() ? 0 : hits.back().range);
    if (hit.triangle == kNobody) break;
    const Triangle triangle = triangleOf(view, line, hit);
    const Incidence incidence = incidenceOf(view, line, triangle);
    const Shares shares = sharesOf(view, effects, triangle, incidence.cosine);
    path.push_back({hit.range, energy});
    const Bounded back = shares.back.error > 0 ? energy * shares.back : Bounded(energy.value * shares.back.value);
    energy = shares.on.value > 0 ? energy * shares.on : Bounded(0);
    // A surface that lets all light pass gives no echo.
    if (back.value > 0 || energy.value == 0)
      pieces.push_back({hit.range, reachOf(beam, effects.cell, incidence, hit.range), back,
                        hits.size() * effects.footprint.size() + subRay, hit});
    hits.push_back(hit);
  }
  goesOn |= energy.value > 0 && hits.size() == kLayers;
  const bool unmet = energy.value > 0 && hits.size() < kLayers;
  if (unmet) path.push_back({std::numeric_limits<double>::infinity(), energy});
  doubt.tie |= inDoubt(view, line, hits, unmet, doubt.tolerance);
  return path;
}

/// Returns the share of a beam's light that surfaces nearer than `range` leave.
Bounded lightTo(double range, const std::vector<Path>& paths) {
  Bounded light = 0;
  for (const Path& path : paths) {
    const auto next = std::find_if(path.begin(), path.end(), [&](const Step& step) { return step.range >= range; });
    if (next != path.end()) light = light + next->light;
  }
  return light;
}

Line lineOf(const Beam& beam, double u, double v) {
  const Vec3 along = beam.axis.direction + u * beam.left + v * beam.up;
  return {beam.axis.frame, (1 / lengthOf(along)) * along, beam.axis.time, beam.axis.window, beam.axis.reach};
}

/// Merges pieces that are in order of range, each weighted by its power at the receiver, energy / range^2. The echo has
/// the energy of a surface at its range that gives the power of all pieces. If pieces of two surfaces are equally
/// strong, it is in doubt which of them represents the echo.
Echo echoOf(std::span<const Piece> pieces, double pulseWidth, BeamDoubt& doubt) {
  const double first = pieces.front().range;
  // A range behind the first piece, as a multiple of the first piece's.
  const auto stretchAt = [&](double depth) {
    if (depth == 0) return Bounded(1);
    return Bounded(1) + Bounded(depth, 2 * doubt.tolerance) / Bounded(std::max(first, 1e-6), doubt.tolerance);
  };
  Bounded power = 0;
  double moment = 0, square = 0;
  const Piece* strongest = &pieces.front();
  for (const Piece& piece : pieces) {
    const double depth = piece.range - first;
    const Bounded stretch = stretchAt(depth), own = depth == 0 ? piece.energy : piece.energy / (stretch * stretch);
    power = power + own;
    moment += own.value * depth;
    square += own.value * depth * depth;
    if (piece.energy.value > strongest->energy.value ||
        (piece.energy.value == strongest->energy.value && piece.order < strongest->order))
      strongest = &piece;
  }
  for (const Piece& piece : pieces)
    if (piece.hit.triangle != strongest->hit.triangle) less(piece.energy, strongest->energy, doubt.tie);
  const double mean = power.value > 0 ? moment / power.value : 0;
  const double variance = power.value > 0 ? std::max(square / power.value - mean * mean, 0.0) : 0;
  const double perDeviation = 2 * std::sqrt(2 * std::numbers::ln2);  // full width at half maximum
  const Bounded stretch = stretchAt(mean);
  return {{first + mean, doubt.tolerance},
          mean == 0 ? power : power * (stretch * stretch),
          std::sqrt(pulseWidth * pulseWidth + perDeviation * perDeviation * variance),
          strongest->hit};
}

/// Removes the echo whose power at the receiver is the least of all between the nearest and the farthest one, and the
/// farther one of equally weak ones.
void loseWeakest(std::vector<Echo>& echoes, bool& doubt) {
  const auto powerOf = [](const Echo& echo) { return received(echo.energy, echo.range, 0); };
  size_t weakest = 1;
  for (size_t k = 2; k + 1 < echoes.size(); ++k)
    if (!less(powerOf(echoes[weakest]), powerOf(echoes[k]), doubt)) weakest = k;
  echoes.erase(echoes.begin() + static_cast<ptrdiff_t>(weakest));
}

/// Returns the range at which an echo that is longer than twice the separation ends, because light returns again behind
/// a valley: the start of the first window with more than four times the least energy since a window with less than a
/// quarter of the energy of a nearer one. The windows are as long as the separation, or a sixteenth of the echo, and
/// the energy of a piece is spread along the surface around it, and over a window at least.
std::optional<Bounded> riseOf(std::span<const Piece> pieces, const Bounded& separation, BeamDoubt& doubt) {
  constexpr int kWindows = 16;
  constexpr double kDepth = 4;
  const Bounded first(pieces.front().range, doubt.tolerance), end(pieces.back().range, doubt.tolerance);
  const Bounded span = end - first;
  if (!less(Bounded(2) * separation, span, doubt.tie)) return {};
  const Bounded width = max(separation, span * Bounded(1.0 / kWindows)), half = Bounded(0.5) * width;
  std::optional<Bounded> least;  // none before the valley
  Bounded peak = 0;
  for (int k = 0; k <= kWindows; ++k) {
    const Bounded low = first + Bounded(k - 0.5) * width, high = first + Bounded(k + 0.5) * width;
    if (low.value > end.value) break;
    Bounded energy = 0;
    for (const Piece& piece : pieces) {
      const Bounded range(piece.range, doubt.tolerance), reach = max(piece.reach, half);
      const Bounded within = min(high, range + reach) - max(low, range - reach);
      energy = energy + piece.energy * max(within, 0) / reach;
    }
    if (least && less(Bounded(kDepth) * *least, energy, doubt.tie)) return low;
    if (least || less(Bounded(kDepth) * energy, peak, doubt.tie)) least = least ? min(*least, energy) : energy;
    peak = max(peak, energy);
  }
  return {};
}

/// An echo begins with a piece. Another one belongs to it if the surface around that one begins no farther than the
/// separation behind the first piece, or overlaps the surface around a piece of the echo; but an echo ends where light
/// returns again behind a valley.
std::vector<Echo> gather(std::vector<Piece>& pieces, const std::vector<Path>& paths, const SensorPlan& plan,
                         BeamDoubt& doubt, uint64_t& lost) {
  const Effects& request = plan.effects;
  const size_t most = plan.returns <= kFewReturns ? kFewEchoes : kManyEchoes;
  std::sort(pieces.begin(), pieces.end(),
            [](const Piece& a, const Piece& b) { return std::pair(a.range, a.order) < std::pair(b.range, b.order); });
  const auto behind = [&](const Piece& piece) { return Bounded(piece.range, doubt.tolerance) + piece.reach; };
  const auto before = [&](const Piece& piece) { return Bounded(piece.range, doubt.tolerance) - piece.reach; };
  std::vector<Echo> echoes;
  size_t first = 0;
  while (first < pieces.size()) {
    size_t end = first + 1;
    const Bounded start(pieces[first].range, doubt.tolerance);
    Bounded last = max(start + given(request.returns.separation), behind(pieces[first]));
    for (size_t i = end; i < pieces.size(); ++i) {
      if (less(last, before(pieces[i]), doubt.tie)) continue;
      while (end <= i) last = max(last, behind(pieces[end++]));  // with all that lie between
    }
    if (const auto rise = riseOf({&pieces[first], end - first}, given(request.returns.separation), doubt)) {
      const auto beyond = [&](const Piece& piece) {
        return !less(Bounded(piece.range, doubt.tolerance), *rise, doubt.tie);
      };
      end = static_cast<size_t>(std::find_if(pieces.data() + first + 1, pieces.data() + end, beyond) - pieces.data());
    }
    echoes.push_back(echoOf({&pieces[first], end - first}, pulseLength(request), doubt));
    first = end;
    const bool isLast = first == pieces.size();
    echoes.back().light = lightTo(isLast ? std::numeric_limits<double>::infinity() : pieces[first].range, paths);
    if (echoes.size() > most) {
      loseWeakest(echoes, doubt.tie);
      ++lost;
    }
  }
  return echoes;
}

/// Tangents of half the angles of the footprint, to the left and up.
std::array<double, 2> halfAxesOf(const SensorPlan& plan) {
  const auto [horizontal, vertical] = fullAnglesOf(plan);
  return {std::tan(horizontal / 2), std::tan(vertical / 2)};
}

/// Half axes of the part of the footprint that a sub-ray stands for; 0 for a beam that is a line.
std::array<double, 2> cellOf(const SensorPlan& plan) {
  if (!plan.has(gpu::kDivergence) || plan.effects.divergence.subRays < 2) return {0, 0};
  const auto [left, up] = halfAxesOf(plan);
  // The area of a rectangle is 4 / pi of that of its ellipse.
  const bool isRectangle = plan.effects.divergence.shape == Effects::Divergence::Shape::rectangle;
  const double share = std::sqrt((isRectangle ? 4 / std::numbers::pi : 1) / double(plan.effects.divergence.subRays));
  return {left * share, up * share};
}

/// Returns sub-rays that represent equal areas of the unit disc, each from the middle of its area. Their places are
/// rings of 6, 12, 18 ... around a centre, and ring k is turned by 3 + 38 k degrees. Other numbers of sub-rays lie on
/// Vogel's spiral (1979), and those of a rectangle on a Fibonacci lattice in the square around the disc; the middle of
/// both is moved to the axis. The weights follow the beam's profile, exp(-2 radius^2) for a Gaussian one.
std::vector<FootprintRay> footprintOf(const SensorPlan& plan) {
  if (!plan.has(gpu::kDivergence)) return {FootprintRay{}};
  const Effects::Divergence& asked = plan.effects.divergence;
  const std::array<double, 2> halfAxes = halfAxesOf(plan);
  const uint32_t count = asked.subRays;
  std::vector<FootprintRay> rays;
  double sum = 0, leftOfMiddle = 0, upOfMiddle = 0;
  const auto addAt = [&](double x, double y) {
    const bool gaussian = asked.profile == Effects::Divergence::Profile::gaussian;
    rays.push_back({halfAxes[0] * x, halfAxes[1] * y, gaussian ? std::exp(-2 * (x * x + y * y)) : 1.0});
    sum += rays.back().weight;
    leftOfMiddle += rays.back().weight * rays.back().left;
    upOfMiddle += rays.back().weight * rays.back().up;
  };
  const auto add = [&](double radius, double angle) { addAt(radius * std::cos(angle), radius * std::sin(angle)); };
  const bool isRectangle = asked.shape == Effects::Divergence::Shape::rectangle;
  uint32_t rings = 0;
  while (1 + 3 * (rings + 1) * (rings + 2) <= count) ++rings;
  const bool fillsRings = !isRectangle && 1 + 3 * rings * (rings + 1) == count;
  if (fillsRings) {
    add(0, 0);
    for (uint32_t ring = 1; ring <= rings; ++ring)
      for (uint32_t i = 0; i < 6 * ring; ++i)
        add(std::sqrt((1.0 + 3.0 * ring * ring) / count),
            std::numbers::pi * ((3 + 38.0 * ring) / 180 + i / (3.0 * ring)));
  } else if (isRectangle) {
    const double golden = (std::sqrt(5.0) - 1) / 2;
    for (uint32_t i = 0; i < count; ++i) {
      const double turns = 0.5 + i * golden;
      addAt((2 * i + 1.0) / count - 1, 2 * (turns - std::floor(turns)) - 1);
    }
  } else {
    for (uint32_t i = 0; i < count; ++i) add(std::sqrt((i + 0.5) / count), std::numbers::pi * (3 - std::sqrt(5.0)) * i);
  }
  for (FootprintRay& ray : rays) {
    if (!fillsRings) {
      ray.left -= leftOfMiddle / sum;
      ray.up -= upOfMiddle / sum;
    }
    ray.weight /= sum;
  }
  return rays;
}

}  // namespace

BeamEffects beamEffects(const SensorPlan& plan, const Scene& scene, const MaterialTable& materials) {
  return {plan, opticsOf(scene, materials, plan.effects.intensity.wavelength), footprintOf(plan), cellOf(plan)};
}

Beam beamOf(const Sensor& sensor, const Shot& shot, bool sensorMoves, size_t index) {
  const Vec3 direction = directionOf(sensor, index, shot.frame);
  const double azimuth = azimuthOf(sensor, index, shot.frame), elevation = elevationOf(sensor, index, shot.frame);
  const double c = std::cos(azimuth), s = std::sin(azimuth);
  const double time = timeOf(sensor, index, shot.frame);
  const Pose pose = sensorMoves ? poseAt(shot.motion, shot.pose, time) : shot.pose;

  RangeWindow window = rangeWindowOf(sensor, index, shot.frame);
  const double least = window.least;
  if (sensor.nearHits == NearHits::hide) window.least = 0;
  Beam beam = {{SensorFrame(pose), direction, time, window}, {}, {}, {}, pose, least};
  beam.origin = originOf(sensor, index, shot.frame);
  // Lists are seen from a place near each laser.
  beam.axis.reach = sensor.isGrid() ? lengthOf(beam.origin) : std::min(lengthOf(beam.origin), kFarthestLaser);
  beam.left = {-s, c, 0};
  beam.up = {-std::sin(elevation) * c, -std::sin(elevation) * s, std::cos(elevation)};
  beam.axis.frame.position = beam.axis.frame.position + beam.axis.frame.directionToWorld(beam.origin);
  return beam;
}

Light lightOf(const Beam& beam, const SensorPlan& plan, const Receiver& receiver, size_t index) {
  Light light = {0, 0, 0, beam.axis.direction};
  if (!plan.has(gpu::kStrays)) return light;
  const auto [azimuth, elevation] = receiver.angleError(index);
  light.left = azimuth.value * lengthOf(beam.axis.direction.x, beam.axis.direction.y);
  light.up = elevation.value;
  light.astray = azimuth.error + elevation.error;
  light.direction = lineOf(beam, light.left, light.up).direction;
  return light;
}

std::vector<Echo> echoesOf(const View& view, const Beam& beam, const Light& light, const BeamEffects& effects,
                           BeamDoubt& doubt, uint64_t& lost) {
  const SensorPlan& plan = effects.plan;
  if (!plan.has(gpu::kFootprintEffects)) {
    const Hit hit = nearest(view, beam.axis);
    const bool met = hit.triangle != kNobody;
    doubt.tie = inDoubt(view, beam.axis, {&hit, met ? 1u : 0u}, !met, doubt.tolerance);
    if (!met) return {};
    Bounded energy = 1;
    if (plan.looksAtMaterials) {
      const Triangle triangle = triangleOf(view, beam.axis, hit);
      energy = sharesOf(view, effects, triangle, incidenceOf(view, beam.axis, triangle).cosine).back;
    }
    return {{{hit.range, doubt.tolerance}, energy, pulseLength(plan.effects), hit}};
  }
  std::vector<Piece> pieces;
  std::vector<Path> paths;
  bool goesOn = false;
  for (size_t i = 0; i < effects.footprint.size(); ++i) {
    const FootprintRay& ray = effects.footprint[i];
    Line line = lineOf(beam, ray.left + light.left, ray.up + light.up);
    line.astray = light.astray;
    paths.push_back(trace(view, beam, line, effects, i, pieces, doubt, goesOn));
  }
  lost += goesOn;
  return gather(pieces, paths, plan, doubt, lost);
}

}  // namespace gnosphere::reference
