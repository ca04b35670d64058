// SPDX-License-Identifier: Apache-2.0
#include "random/request.hpp"

#include <cmath>
#include <cstdlib>
#include <numeric>
#include <sstream>

#include "deformable.hpp"
#include "effects/scan_support.hpp"
#include "lists/list_sensors.hpp"

namespace gnosphere::test {
namespace {

/// Random choices of all kinds, seeded by the number of a request.
class Draw {
 public:
  explicit Draw(uint32_t seed) : random_(seed * 2654435761u + 12345) {}
  /// Returns a number between `low` and `high`, with equal chances for intervals of equal length.
  double between(double low, double high) { return low + (high - low) * (random_() + 1) / 2; }
  /// Returns a positive number between `low` and `high`, with equal chances for intervals of equal ratio.
  double magnitude(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  uint32_t bits() { return random_.bits(); }
  uint32_t below(uint32_t count) { return bits() % count; }
  /// Returns true with a probability of `percent` / 100.
  bool often(uint32_t percent) { return below(100) < percent; }
  template <typename T>
  T of(const std::vector<T>& choices) {
    return choices[below(static_cast<uint32_t>(choices.size()))];
  }
  Vec3 within(double half) { return {between(-half, half), between(-half, half), between(-half, half)}; }
  Quaternion turn(double most) {
    const Vec3 half = within(most / 2);
    const double rest = 1 - half.x * half.x - half.y * half.y - half.z * half.z;
    return {half.x, half.y, half.z, std::sqrt(std::max(rest, 0.0))};
  }

 private:
  Random random_;
};

Material anyMaterial(Draw& draw) {
  Material material = lambertian(static_cast<float>(draw.between(0.02, 0.95)));
  material.roughness = static_cast<float>(draw.between(0.2, 1));
  material.metallic = draw.often(20) ? 1 : 0;
  material.doubleSided = draw.often(70);
  if (draw.often(10)) material.retro = 20;
  return material;
}

/// A map of any orientation, of unequal and sometimes negative scales, to a place at most `reach` metres away.
Transform anyPlace(Draw& draw, double reach) {
  const double tilt = draw.often(50) ? draw.between(-3, 3) : 0, c = std::cos(tilt), s = std::sin(tilt);
  const Transform tilted = {{1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 0}};
  const auto scale = [&] { return draw.magnitude(0.4, 2.5) * (draw.often(15) ? -1 : 1); };
  const double x = scale(), y = scale(), z = scale();
  const Vec3 at = draw.within(reach);
  return translation(at.x, at.y, at.z / 4) * rotationZ(draw.between(-3.2, 3.2)) * tilted * scaling(x, y, z);
}

void add(Scene& scene, Mesh mesh, const Transform& place) {
  for (MeshPart& part : mesh.parts) part.material = static_cast<uint32_t>(scene.materials.size() - 1);
  scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size()), place});
  scene.meshes.push_back(std::move(mesh));
}

Mesh box(double half, uint32_t cuts) {
  MeshBuilder builder;
  builder.box({-half, -half, -half}, {half, half, half}, cuts);
  return builder.take();
}

/// Triangles of up to 50 m that are centimetres wide.
Mesh slivers(Draw& draw, uint32_t count) {
  MeshBuilder builder;
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3 a = draw.within(20), along = draw.within(draw.magnitude(1, 50)), aside = draw.within(0.02);
    builder.triangle(a, {a.x + along.x, a.y + along.y, a.z + along.z}, {a.x + aside.x, a.y + aside.y, a.z + aside.z});
  }
  return builder.take();
}

Scene anyScene(Draw& draw, std::ostringstream& text) {
  Scene scene;
  const auto material = [&] { scene.materials.push_back(anyMaterial(draw)); };
  if (draw.often(60)) {
    material();
    const double half = draw.magnitude(15, 500), slope = draw.often(30) ? 3 : 0;
    MeshBuilder ground;
    ground.quad({-half, -half, -1.7}, {2 * half, 0, 0}, {0, 2 * half, slope}, draw.of<uint32_t>({1, 3, 40}));
    add(scene, ground.take(), {});
    text << " ground";
  }
  for (uint32_t soups = draw.below(3); soups > 0; --soups) {
    material();
    const double size = draw.magnitude(0.05, 30), spread = draw.magnitude(2, 60);
    const auto count = static_cast<uint32_t>(draw.magnitude(1, size > 3 ? 60 : 4000));
    add(scene, soup(draw.bits(), count, spread, size), {});
    text << " soup " << count << " of " << size << " m";
  }
  for (uint32_t boxes = draw.below(5); boxes > 0; --boxes) {
    material();
    const double half = draw.magnitude(0.2, 25);
    Mesh mesh = box(half, draw.of<uint32_t>({1, 2, 12}));
    add(scene, std::move(mesh), anyPlace(draw, 20));
    text << " box";
  }
  for (uint32_t balls = draw.below(3); balls > 0; --balls) {
    material();
    const uint32_t rings = draw.of<uint32_t>({4, 12, 50});
    Mesh mesh = ball(rings, 2 * rings, draw.magnitude(0.1, 12));
    add(scene, std::move(mesh), anyPlace(draw, 8));
    text << " ball " << rings;
  }
  if (draw.often(20)) {
    material();
    add(scene, slivers(draw, 40), {});
    text << " slivers";
  }
  if (draw.often(20)) {
    material();
    Random random(draw.bits());
    const uint32_t influences = draw.below(3), targets = influences == 0 ? 2 : draw.below(2);
    add(scene, limb(random, 4, influences, targets), anyPlace(draw, 6));
    text << " limb";
  }
  for (uint32_t panes = draw.often(50) ? 1 + draw.below(3) : 0; panes > 0; --panes) {
    material();
    Material& glass = scene.materials.back();
    glass.metallic = 0;
    if (draw.often(50))
      glass.transmission = 0.8f;
    else {
      glass.alphaMode = AlphaMode::blend;
      glass.baseColor[3] = 0.3f;
    }
    Mesh pane = draw.often(70) ? plate(0, draw.magnitude(0.3, 10)) : ball(6, 12, 2);
    add(scene, std::move(pane), anyPlace(draw, 10));
    text << " pane";
  }
  if (draw.often(30)) {
    const float opacity = draw.often(50) ? 1.0f : 0.6f;
    Mesh fence = plate(0, draw.magnitude(0.5, 6));
    addFence(scene, std::move(fence), anyPlace(draw, 10), opacity);
    text << " fence";
  }
  if (scene.instances.empty()) {
    material();
    add(scene, box(5, 3), {});
  }
  if (draw.often(15)) {
    for (Instance& instance : scene.instances) instance.world = draw.below(3);
    text << ", worlds";
  }
  return scene;
}

/// Returns a spinning head with random channels, range windows, sector, footprint and masked beams.
Sensor anyGrid(Draw& draw) {
  const uint32_t columns = 100 + draw.below(900), channels = 1 + draw.below(24);
  const double low = draw.between(-89, 0), high = draw.between(1, 89);
  Sensor sensor = gridSensor(columns, channels, low, high, draw.magnitude(20, 300));
  sensor.rotationPeriod = draw.often(80) ? 0.1 : 0;
  if (draw.often(20)) sensor.nearHits = NearHits::hide;
  const double largestLeast = sensor.nearHits == NearHits::hide ? 30 : 3;  // hides many surfaces
  sensor.rangeMin = draw.often(40) ? draw.magnitude(0.05, largestLeast) : 0;
  if (draw.often(30)) sensor.azimuthSpanDeg = draw.between(-360, 360);
  if (draw.often(30)) sensor.azimuthStartDeg = draw.between(-180, 180);
  if (draw.often(70)) sensor.divergenceHorizontal = draw.magnitude(3e-4, 2e-2);
  if (draw.often(70)) sensor.divergenceVertical = draw.magnitude(3e-4, 2e-2);
  sensor.maxReturns = 1 + draw.below(3);
  const bool offsets = draw.often(50), origins = draw.often(50), times = draw.often(50), own = draw.often(20);
  for (Channel& channel : sensor.channels) {
    if (offsets) channel.azimuthOffsetDeg = draw.between(-12, 12);
    if (origins) channel.origin = draw.within(0.05);
    if (times) channel.timeOffset = draw.between(0, 1e-4);
    if (own) channel.rangeMax = draw.between(10, 100);
  }
  for (uint32_t masked = draw.often(20) ? 300 : 0; masked > 0; --masked)
    sensor.maskedBeams.push_back(draw.below(static_cast<uint32_t>(sensor.beamCount())));
  std::sort(sensor.maskedBeams.begin(), sensor.maskedBeams.end());
  sensor.maskedBeams.erase(std::unique(sensor.maskedBeams.begin(), sensor.maskedBeams.end()), sensor.maskedBeams.end());
  sensor.name = "any grid";
  return sensor;
}

/// Returns a list of beams, in a rosette or in random directions, from one origin or from three.
Sensor anyList(Draw& draw) {
  BeamList beams;
  const uint32_t count = 200 + draw.below(4000);
  if (draw.often(50))
    beams = rosette(count, draw.between(0.1, 1.5));
  else
    for (uint32_t i = 0; i < count; ++i) {
      beams.directions.push_back(unit(draw.within(1)));
      beams.times.push_back(0.1 * i / count);
    }
  if (draw.often(40))
    beams = headsAt({draw.within(0.3), draw.within(0.3), draw.within(draw.magnitude(0.1, 30))}, beams);
  Sensor sensor = listSensor("any list", std::move(beams), draw.magnitude(20, 300));
  sensor.rotationPeriod = 0.1;
  if (draw.often(70)) sensor.divergenceHorizontal = sensor.divergenceVertical = draw.magnitude(3e-4, 2e-2);
  sensor.maxReturns = 1 + draw.below(3);
  return sensor;
}

/// Returns a head of the catalogue with fewer columns, so that the reference takes a second.
Sensor anyHead(Draw& draw) {
  const Sensor head = builtinSensor(draw.of(sensorCatalogue()).name);
  if (!head.isGrid()) return head.beamCount() > 40'000 ? anyList(draw) : head;
  Sensor sensor = head;
  while (sensor.beamCount() > 20'000 && sensor.columns % 2 == 0) sensor.columns /= 2;
  const uint64_t step = head.columns / sensor.columns;
  sensor.maskedBeams.clear();
  for (const uint32_t beam : head.maskedBeams)
    if (beam % head.columns % step == 0)
      sensor.maskedBeams.push_back(
          static_cast<uint32_t>(beam / head.columns * sensor.columns + beam % head.columns / step));
  return sensor;
}

Effects anyEffects(Draw& draw, std::ostringstream& text) {
  const std::string preset = draw.often(75) ? "auto" : "os1-rain";
  text << ", " << preset;
  Effects effects = effectPreset(preset);
  effects.seed = draw.below(1000);
  effects.divergence.subRays = draw.of<uint32_t>({5, 7, 19, 37});
  if (draw.often(30)) effects.divergence.profile = Effects::Divergence::Profile::uniform;
  effects.returns.mode = static_cast<Effects::Returns::Mode>(draw.below(12));
  effects.returns.separation = draw.magnitude(0.05, 1);
  text << ", " << effects.divergence.subRays << " sub-rays, mode " << int(effects.returns.mode);
  const auto maybe = [&](uint32_t percent, EffectUse& use, const char* name) {
    if (!draw.often(percent)) return;
    use = EffectUse::on;
    text << " +" << name;
  };
  effects.detection.range = draw.between(5, 80);
  effects.rangeNoise.sigma = 0.01;
  if (draw.often(30)) effects.rangeNoise.sigmaAtThreshold = 0.1;
  effects.angleNoise.azimuth = effects.angleNoise.elevation = draw.magnitude(1e-4, 5e-3);
  effects.intensityNoise.sigma = 0.02;
  effects.dropOut.generalRate = 0.05;
  maybe(30, effects.detection.use, "detection");
  maybe(30, effects.rangeNoise.use, "range-noise");
  maybe(25, effects.angleNoise.use, "angle-noise");
  maybe(15, effects.intensityNoise.use, "intensity-noise");
  maybe(15, effects.dropOut.use, "drop-out");
  if (draw.often(15)) effects.fog.visibility = 100;
  if (draw.often(10)) effects.snow.rate = 3;
  if (draw.often(10)) effects.volumes.boxes = {{{-3, -8, -2}, {6, 5, 2}, 0.1}};
  effects.sensorMotion.deskew = draw.often(30);
  return effects;
}

/// Returns the motion of a sensor that drives straight or turns, at up to 25 m/s along each axis and 5 rad/s.
SensorMotion driving(Draw& draw, const Pose& start) {
  SensorMotion motion{{{-0.01, start}}};
  const Vec3 speed = draw.within(draw.magnitude(0.5, 30));
  Pose end = start;
  end.position = {start.position.x + 0.1 * speed.x, start.position.y + 0.1 * speed.y,
                  start.position.z + 0.02 * speed.z};
  const Quaternion& q = start.orientation;
  const double half = draw.often(60) ? draw.between(-0.3, 0.3) : 0, c = std::cos(half), s = std::sin(half);
  // The orientation at the end is q after a turn by 2 * half about the sensor's z axis.
  end.orientation = {q.x * c + q.y * s, q.y * c - q.x * s, q.z * c + q.w * s, q.w * c - q.z * s};
  motion.stamps.push_back({0.11, end});
  return motion;
}

/// Shots, some of them from the same pose. Between some of them instances or vertices have moved or instances were
/// added, and some see motion within the scan.
std::vector<Step> anySteps(Draw& draw, const Request& request, bool moving, bool turning, std::ostringstream& text) {
  const Scene& scene = request.scene;
  std::vector<Step> steps(4);
  const bool upright = draw.often(60), samePose = draw.often(30), changing = draw.often(40);
  const auto moved = [&](uint32_t i, bool turns) {
    const Vec3 by = draw.within(2);
    const double angle = turns ? draw.between(-0.3, 0.3) : 0;
    return translation(by.x, by.y, by.z / 4) * scene.instances[i].transform * rotationZ(angle);
  };
  for (Step& step : steps) {
    Shot& shot = step.shot;
    shot.frame = draw.below(1000);
    shot.world = draw.below(3);
    shot.sensor = draw.below(static_cast<uint32_t>(request.sensors.size()));
    shot.pose.position = draw.within(draw.magnitude(0.1, 12));
    shot.pose.position.z = draw.between(-1.5, 2);
    if (upright) {
      const double half = draw.between(-1.5, 1.5);
      shot.pose.orientation = {0, 0, std::sin(half), std::cos(half)};
    } else {
      shot.pose.orientation = draw.turn(1);
    }
    if (samePose) shot.pose = steps[0].shot.pose;
    if (moving && draw.often(50)) shot.motion = driving(draw, shot.pose);
    if (request.sensors[shot.sensor].variableWeather && draw.often(60))
      shot.weather = Weather{draw.often(50) ? 80.0 : 0, draw.often(30) ? 20.0 : 0, draw.often(30) ? 2.0 : 0,
                             std::vector<Effects::Volume>(shot.frame % 3, {{-3, -8, -2}, {6, 5, 2}, 0.05})};
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
      if (changing && draw.often(30)) step.transforms.push_back({i, moved(i, true)});
      if (changing && draw.often(5)) step.added.push_back({"", scene.instances[i].mesh, moved(i, true)});
      if (!moving || changing || !draw.often(15)) continue;
      if (turning && draw.often(20)) step.transforms.push_back({i, scene.instances[i].transform * scaling(1, 0, 1)});
      shot.instanceMotions.push_back({i, moved(i, turning)});
    }
    for (uint32_t i = 0; i < scene.meshes.size(); ++i) {
      const Mesh& mesh = scene.meshes[i];
      if (!mesh.deformable()) continue;
      Random random(draw.bits());
      if (changing) step.deformations.push_back({i, bend(random, mesh)});
      if (moving && turning && draw.often(50)) shot.meshMotions.push_back({i, bend(random, mesh)});
    }
    if (draw.often(15))
      for (int i = 0; i < 3; ++i)
        shot.ignoredInstances.push_back(draw.below(static_cast<uint32_t>(scene.instances.size())));
    text << (shot.motion.stamps.empty() ? ", still" : ", driving") << " +" << shot.instanceMotions.size() << " +"
         << shot.meshMotions.size() << " +" << step.transforms.size() << " +" << step.deformations.size();
  }
  return steps;
}

/// Moves the scene and all poses by an offset, such as that of a scene with geographic coordinates.
void shift(Request& request, const Vec3& by) {
  const Transform away = translation(by.x, by.y, by.z);
  for (Instance& instance : request.scene.instances) instance.transform = away * instance.transform;
  for (Step& step : request.steps) {
    for (auto& [instance, transform] : step.transforms) transform = away * transform;
    for (Instance& instance : step.added) instance.transform = away * instance.transform;
    for (InstanceMotion& motion : step.shot.instanceMotions) motion.end = away * motion.end;
    for (SensorMotion::Stamp& stamp : step.shot.motion.stamps) stamp.pose.position = away * stamp.pose.position;
    step.shot.pose.position = away * step.shot.pose.position;
    if (!step.shot.weather) continue;
    for (Effects::Volume& box : step.shot.weather->volumes) box = {away * box.min, away * box.max, box.extinction};
  }
}

/// Draws the choices that change the time of a scan, and not its cloud.
Tuning anyTuning(Draw& draw, std::ostringstream& text) {
  Tuning tuning;
  if (draw.often(20)) {
    tuning.binning = draw.of<Binning>({Binning::nearest, Binning::lists, Binning::slabs});
    text << ", binning " << int(tuning.binning);
  }
  if (draw.often(20)) {
    tuning.subRays = draw.of<SubRays>({SubRays::lanes, SubRays::one});
    text << ", sub-rays " << int(tuning.subRays);
  }
  if (draw.often(75)) return tuning;
  for (bool* use : {&tuning.culling.range, &tuning.culling.rows, &tuning.culling.columns, &tuning.culling.cones,
                    &tuning.keepStill, &tuning.float64})
    *use = draw.often(60);
  tuning.culling.occlusion = static_cast<Culling::Occlusion>(draw.below(3));
  if (draw.often(50)) tuning.maxBatchBytes = static_cast<uint64_t>(draw.magnitude(1e4, 1e7));
  if (draw.often(50)) tuning.maxSubmissionWork = static_cast<uint64_t>(draw.magnitude(1e3, 1e6));
  text << ", tuned";
  return tuning;
}

SensorRequest anySensor(Draw& draw, const Scene& scene, bool clean, bool exact, std::ostringstream& text) {
  SensorRequest request;
  request.sensor = draw.often(45) ? anyHead(draw) : draw.often(70) ? anyGrid(draw) : anyList(draw);
  text << "; " << request.sensor.name << " of " << request.sensor.beamCount();
  const std::vector<Field> geometry = {Field::normal, Field::incidence, Field::material, Field::classId};
  if (clean) {
    request.effects = Effects::none();
    request.effects.sensorMotion.use = request.effects.objectMotion.use = exact ? EffectUse::off : EffectUse::automatic;
    request.fields = draw.of<std::vector<Field>>({{}, {}, geometry});
    text << ", clean";
  } else {
    request.effects = anyEffects(draw, text);
    request.fields = draw.of<std::vector<Field>>(
        {{}, {Field::intensity}, {Field::label, Field::cause}, stillFields(), effectFields(), {Field::velocity}});
    request.variableWeather = draw.often(15);
  }
  text << ", " << request.fields.size() << " fields";
  if (draw.often(15)) request.ignoredInstances.push_back(draw.below(static_cast<uint32_t>(scene.instances.size())));
  return request;
}

}  // namespace

Request anyRequest(uint32_t number) {
  Draw draw(number);
  Request request;
  std::ostringstream text;
  request.scene = anyScene(draw, text);
  const bool clean = draw.often(30), exact = draw.often(20);  // the accuracy `exact` has no motion
  for (uint32_t count = draw.often(25) ? 2 : 1; count > 0; --count)
    request.sensors.push_back(anySensor(draw, request.scene, clean, exact, text));
  request.options = vulkanOptions();
  if (exact) {
    request.options.accuracy = Accuracy::exact;
    text << ", exact";
  }
  request.options.tuning = anyTuning(draw, text);
  if (draw.often(20)) {
    request.options.faces = draw.often(50) ? ReflectingFaces::front : ReflectingFaces::both;
    text << ", faces " << int(request.options.faces);
  }
  request.steps = anySteps(draw, request, !exact, clean, text);
  if (draw.often(15)) {
    shift(request, {4.1e5, 5.6e6, 300});
    text << ", far away";
  }
  request.text = text.str();
  return request;
}

void change(Simulator& simulator, const Step& step) {
  for (const auto& [instance, transform] : step.transforms) simulator.setTransform(instance, transform);
  for (const auto& [mesh, deformation] : step.deformations) simulator.setDeformation(mesh, deformation);
  simulator.addInstances(step.added);
}

std::vector<uint32_t> numbersToTry(uint32_t most) {
  // Panes, slivers, footprints, rain, errors and motions in a scan of 1,938 beams, whose kernels compile in less time
  // than those of most requests.
  constexpr uint32_t kRich = 122;
  const char* first = std::getenv("GNOSPHERE_RANDOM_SEED");
  std::vector<uint32_t> numbers(everyCombination() ? most : 1);
  const uint32_t own = everyCombination() ? 0 : kRich;
  std::iota(numbers.begin(), numbers.end(), first ? static_cast<uint32_t>(std::stoul(first)) : own);
  return numbers;
}

}  // namespace gnosphere::test
