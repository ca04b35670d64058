// SPDX-License-Identifier: Apache-2.0
// Effects on the device compared with the reference: equal random numbers, and differences only by single precision.
#include <array>

#include "base/vector.hpp"
#include "effects/scan_support.hpp"
#include "effects/street.hpp"
#include "lists/list_sensors.hpp"
#include "sensor/beams.hpp"

namespace gnosphere::test {
namespace {

/// A VLP-16 with fewer columns.
Sensor coarse(uint32_t columns) {
  Sensor sensor = builtinSensor("VLP-16");
  sensor.columns = columns;
  return sensor;
}

Differences compared(const Effects& effects, std::vector<Field> fields, const Sensor& sensor, const Slack& slack = {},
                     const Scene& scene = smallTown()) {
  TestOptions options = optionsOn("vulkan");
  options.effects = effects;
  options.fields = std::move(fields);
  const Scan other = scanOn(scene, sensor, kPose, options);
  options.device = DeviceChoice::Kind::reference;
  const Scan reference = scanOf(scene, sensor, kPose, options);
  REQUIRE(other.returns == reference.returns);
  const Differences result = differences(reference, other, slack);
  INFO("hits " << reference.counters.hits << " and " << other.counters.hits);
  CHECK(reference.counters.hits > result.beams / 20);
  return result;
}

/// Requires equality except for rounding; `trueRange` is Slack::trueRange.
void requireSame(const Effects& effects, double trueRange = 0) {
  std::vector<Field> fields = stillFields();
  fields.push_back(Field::barycentrics);
  // Normals of small triangles are as uncertain as their corners.
  const Differences found = compared(effects, fields, coarse(180), {0, 5e-4, 2e-3, trueRange});
  INFO(found.text());
  CHECK(found.ties < found.beams / 50);
  CHECK(found.all() == 0);
}

Effects nothing() {
  Effects effects = Effects::none();
  effects.intensity.use = EffectUse::automatic;  // requested by fields
  return effects;
}

Effects withIntensity(Effects::Intensity::Model model, Effects::Intensity::Scale scale) {
  Effects effects = nothing();
  effects.intensity.use = EffectUse::on;
  effects.intensity.model = model;
  effects.intensity.scale = scale;
  return effects;
}

Effects physical() {
  return withIntensity(Effects::Intensity::Model::physical, Effects::Intensity::Scale::unit);
}

/// Echoes may differ if pieces of one are about as far apart as separate echoes, and in the choice between two
/// triangles of nearly equal power.
void requireAlmostSame(const Effects& effects, const Scene& scene = smallTown()) {
  const Differences found = compared(effects, stillFields(), coarse(120), {2e-3, 1e-3, 2e-3}, scene);
  INFO(found.text());
  CHECK(found.ties < found.beams / 50);
  CHECK(found.all() <= found.beams / 500);
}

}  // namespace

TEST_CASE("intensities and surfaces equal the reference") {
  using Model = Effects::Intensity::Model;
  using Scale = Effects::Intensity::Scale;
  requireSame(physical());
  requireSame(withIntensity(Model::physical, Scale::byte));
  requireSame(withIntensity(Model::carla, Scale::unit));
}

/// A triangle of about 10 m by `width`, on average 10 m from the sensor and square to the line of sight. Neither single
/// precision nor the accuracy `exact` rounds its corners.
std::array<Vec3, 3> sliver(Random& random, double width) {
  const auto onGrid = [](const Vec3& p) {
    const auto rounded = [](double x) { return std::round(x * 0x1p20) * 0x1p-20; };
    return Vec3{rounded(p.x), rounded(p.y), rounded(p.z)};
  };
  const Vec3 d = anyDirection(random), across = unit(cross(d, anyDirection(random))), along = cross(d, across);
  const Vec3 foot = 10.0 * d + -0.5 * width * across;
  return {onGrid(foot + -5.0 * along), onGrid(foot + 5.0 * along), onGrid(10.0 * d + 0.5 * width * across)};
}

TEST_CASE("every hit has a normal of length 1 towards the sensor, also of triangles that rounding flattens") {
  Random random(72);
  MeshBuilder builder;
  BeamList beams;
  for (int i = 0; i < 400; ++i) {
    const Vec3 d = anyDirection(random), across = unit(cross(d, anyDirection(random))), along = cross(d, across);
    const double size = i % 2 ? 1e-3 : 1e-4, width = i % 4 < 2 ? size : 1e-3 * size;
    const Vec3 centre = 100.0 * d;
    builder.triangle(centre + -size * along, centre + size * along, centre + width * across);
    beams.directions.push_back(d);
  }
  const Scene scene = sceneOf(builder.take());
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    TestOptions options = optionsOn("vulkan");
    options.accuracy = accuracy;
    options.fields = {Field::normal};
    const Scan scan = scanOn(scene, listSensor("aimed", beams), Pose(), options);
    size_t hits = 0;
    for (size_t i = 0; i < scan.beamCount(); ++i) {
      if (!scan.hit(i)) continue;
      ++hits;
      const auto part = [&](uint32_t axis) { return double{scan.column<float>(Field::normal, axis)[i]}; };
      const Vec3 normal = {part(0), part(1), part(2)};
      const Vec3 point = {scan.points[3 * i], scan.points[3 * i + 1], scan.points[3 * i + 2]};
      INFO(nameOf(accuracy) << ", beam " << i);
      CHECK(std::abs(dot(normal, normal) - 1) < 1e-5);
      CHECK(dot(normal, point) < 0.01);
    }
    CHECK(hits > 20);
  }
}

TEST_CASE("the weights of corners are those of the beam also in long and narrow triangles") {
  Random random(71);
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact})
    for (const double width : {1.0, 0.1, 0.01, 0.003}) {
      MeshBuilder builder;
      BeamList beams;
      std::vector<std::array<double, 2>> expected;
      for (int i = 0; i < 100; ++i) {
        const auto [a, b, c] = sliver(random, width);
        builder.triangle(a, b, c);
        const double u = 0.1 + 0.35 * std::abs(random()), v = 0.1 + 0.35 * std::abs(random());
        const Vec3 d = unit(a + u * (b - a) + v * (c - a));
        beams.directions.push_back(d);
        const double sides[3] = {dot(d, cross(b, c)), dot(d, cross(c, a)), dot(d, cross(a, b))};
        const double sum = sides[0] + sides[1] + sides[2];
        expected.push_back({sides[1] / sum, sides[2] / sum});
      }
      TestOptions options = optionsOn("vulkan");
      options.accuracy = accuracy;
      options.fields = {Field::barycentrics};
      const Scan scan = scanOn(sceneOf(builder.take()), listSensor("aimed", beams), Pose(), options);
      const auto second = scan.column<float>(Field::barycentrics, 0),
                 third = scan.column<float>(Field::barycentrics, 1);
      size_t hits = 0;
      for (size_t i = 0; i < scan.beamCount(); ++i) {
        if (scan.triangles[i] != i) continue;  // another one is before it
        ++hits;
        INFO(nameOf(accuracy) << ", width " << width << ", beam " << i);
        // The beam, the range and the corners are rounded at 10 m, and products of edges of 10 m.
        const double bound = 0x1p-24 * (8 * 20 / width + 8);
        CHECK(std::abs(second[i] - expected[i][0]) < bound);
        CHECK(std::abs(third[i] - expected[i][1]) < bound);
        CHECK((second[i] >= 0 && third[i] >= 0 && second[i] + third[i] <= 1.000001f));
      }
      CHECK(hits > 80);
    }
}

TEST_CASE("undetected and randomly dropped returns are the same on every device") {
  Effects effects = physical();
  effects.detection = {EffectUse::on, 0.1, 60, 0};
  requireSame(effects);
  effects.detection.softness = 0.3;
  requireSame(effects);
  effects = physical();
  effects.dropOut = {EffectUse::on, 0.1, 0.8, 0.4, {3, 700, 701}};
  requireSame(effects);
}

TEST_CASE("measurement errors use the same random numbers") {
  Effects effects = physical();
  effects.rangeNoise = {EffectUse::on, 0.01, 0.02, 1e-4, 0};
  requireSame(effects);
  effects.rangeNoise.sigmaPerSquareMetre = 1e-4;
  requireSame(effects);
  effects.rangeNoise.sigmaAtThreshold = 0.3;
  requireSame(effects);
  effects.rangeNoise.bias = -8;  // near surfaces are returned at the range 0, whose tolerance is 0
  requireSame(effects, 1e-5);
  effects = physical();
  effects.intensityNoise = {EffectUse::on, 0.05};
  requireSame(effects);
  effects = physical();
  effects.angleNoise = {EffectUse::on, 1e-3, 2e-3, Effects::AngleNoise::At::point};
  requireSame(effects);
}

TEST_CASE("ranges that devices round to different steps are within the tolerance of the reference") {
  for (const uint64_t seed : {11, 13, 14}) {  // rounding adds to one of their ranges that are a step apart
    TestOptions options = optionsOn("vulkan");
    options.effects = physical();
    options.effects.seed = seed;
    options.effects.rangeNoise = {EffectUse::on, 0.01, 0.02, 1e-4, 2e-3};
    const Scan other = scanOn(smallTown(), coarse(1440), kPose, options);
    options.device = DeviceChoice::Kind::reference;
    const Comparison found = compare(scanOf(smallTown(), coarse(1440), kPose, options), other);
    CHECK(found.rangeErrorMax > 0.0019);
    CHECK(found.wrongRange == 0);
  }
}

TEST_CASE("scattering and attenuation of the medium are the same on every device") {
  Effects effects = physical();
  effects.fog = {EffectUse::on, 60};
  requireSame(effects);
  effects = physical();
  effects.rain = {EffectUse::on, 50};
  requireSame(effects);
  effects = physical();
  effects.snow = {EffectUse::on, 10};
  requireSame(effects);
  effects = physical();
  effects.volumes = {EffectUse::on, {{{3, -5, -1}, {12, 4, 5}, 0.05}, {{-20, -20, 0}, {-4, 20, 3}, 0.1}}};
  requireSame(effects);
}

TEST_CASE("no drop, flake or droplet of fog is nearer than the own window of its channel") {
  Sensor sensor = coarse(180);
  sensor.rangeMin = 2;
  for (size_t channel = 0; channel < sensor.channels.size(); ++channel)
    sensor.channels[channel].rangeMin = channel % 2 ? 0.7 : 6;
  for (const bool fog : {false, true}) {
    Effects effects = physical();
    effects.snow = {EffectUse::on, 20};
    effects.returns = {EffectUse::on, Effects::Returns::Mode::first};
    if (fog) effects.fog = {EffectUse::on, 30};
    const Differences found = compared(effects, stillFields(), sensor, {0, 5e-4, 2e-3});
    INFO(found.text());
    CHECK(found.all() == 0);
    TestOptions options = optionsOn("vulkan");
    options.effects = effects;
    const Scan scan = scanOn(smallTown(), sensor, kPose, options);
    float least[2] = {100, 100};
    for (size_t i = 0; i < scan.beamCount(); ++i) {
      float& of = least[i / sensor.columns % 2];
      if (scan.ranges[i] > 0) of = std::min(of, scan.ranges[i]);
    }
    CHECK(least[0] >= 6);
    CHECK(least[0] < 8);
    CHECK(least[1] >= 0.7f);
    CHECK(least[1] < 1.5f);
  }
}

TEST_CASE("masked beams of a list return nothing, not even from fog, and their cause is that they are dead") {
  Sensor sensor = listSensor("rosette", rosette(3000, 0.6));
  for (uint32_t beam = 0; beam < 3000; beam += 7) sensor.maskedBeams.push_back(beam);
  TestOptions options = optionsOn("vulkan");
  options.effects = physical();
  options.effects.fog = {EffectUse::on, 30};
  options.fields = {Field::cause, Field::label};
  for (const char* device : {"reference", "vulkan"}) {
    options.device = optionsOn(device).device;
    const Scan scan = scanOn(smallTown(), sensor, kPose, options);
    size_t wrong = 0, scattered = 0;
    for (uint32_t beam = 0; beam < 3000; ++beam) {
      const bool masked = beam % 7 == 0;
      scattered += static_cast<Label>(scan.column<uint8_t>(Field::label)[beam]) == Label::scatter;
      wrong += masked != (static_cast<Cause>(scan.column<uint8_t>(Field::cause)[beam]) == Cause::dead);
      wrong += masked && (scan.returned(beam) || scan.hit(beam));
    }
    CAPTURE(device);
    CHECK(wrong == 0);
    CHECK(scattered > 300);
  }
}

TEST_CASE("the normal points to the sensor also where only the edge of the footprint meets a surface") {
  // The sensor is 1 mm above the plane of a floor, so the axes of many beams pass above the floor or along it.
  Sensor sensor = gridSensor(500, 9, -0.2, 0.2, 60);
  sensor.divergenceHorizontal = sensor.divergenceVertical = 5e-3;
  MeshBuilder floor;
  floor.quad({-40, -40, kPose.position.z - 1e-3}, {80, 0, 0}, {0, 80, 0});
  const Scene scene = sceneOf(floor.take());
  TestOptions options = optionsOn("vulkan");
  options.effects = physical();
  options.effects.divergence.use = EffectUse::on;
  options.fields = stillFields();
  for (const char* device : {"reference", "vulkan"}) {
    options.device = optionsOn(device).device;
    const Scan scan = scanOn(scene, sensor, Pose{kPose.position, {}}, options);
    const auto up = scan.column<float>(Field::normal, 2), incidences = scan.column<float>(Field::incidence);
    size_t beyond = 0, wrong = 0;
    for (size_t beam = 0; beam < scan.beamCount(); ++beam)
      if (scan.hit(beam)) {
        wrong += !(up[beam] > 0.999f);
        beyond += std::abs(incidences[beam] - std::numbers::pi / 2) < 1e-6;
      }
    CAPTURE(device);
    CHECK(wrong == 0);
    CHECK(beyond > 1000);
  }
}

TEST_CASE("several returns of one beam keep their order and their surfaces") {
  Effects effects = physical();
  effects.fog = {EffectUse::on, 40};
  effects.returns.use = EffectUse::on;
  effects.returns.count = 2;
  requireSame(effects);
}

TEST_CASE("footprints hit the same surfaces") {
  Effects effects = physical();
  effects.divergence = {EffectUse::on, 7, Effects::Divergence::Profile::gaussian, 3e-3, 1.5e-3};
  effects.returns.use = EffectUse::on;
  effects.returns.count = 3;
  requireAlmostSame(effects);
}

TEST_CASE("beams with angular errors hit the same surfaces") {
  Effects effects = physical();
  effects.angleNoise = {EffectUse::on, 2e-3, 1e-3, Effects::AngleNoise::At::beam};
  requireAlmostSame(effects);
}

// The plate with holes is in front of everything, and every scan tests what lies behind earlier hits. Without fields
// the host resolves the words of all beams that meet no pane.
TEST_CASE("effects of lines give the same bytes with every way of binning, and equal the reference", "[combinations]") {
  Scene scene = smallTown();
  for (size_t i = 0; i < scene.materials.size(); i += 2) scene.materials[i].transmission = 0.6f;
  addFence(scene, plate(3, 2), translation(1.3, 0.4, 1.8));
  const std::vector<const char*> names = {"cut-outs=on", "angle-noise=on", "transmission=on", "divergence.sub_rays=1"};
  const Sensor sensor = coarse(180);
  for (size_t which = 0; which <= names.size(); ++which)
    for (const bool fields : {false, true}) {
      const bool all = which == names.size() || everyCombination();
      if (!all && fields == (which < 2)) continue;
      TestOptions options = optionsOn("vulkan");
      options.tuning.culling.occlusion = Culling::Occlusion::always;
      options.effects.angleNoise.azimuth = options.effects.angleNoise.elevation = 2e-3;
      options.effects.divergence.horizontal = 3e-3;
      options.effects.angleNoise.use = options.effects.divergence.use = EffectUse::off;
      options.effects.intensity.use = EffectUse::automatic;
      for (size_t i = 0; i < names.size(); ++i)
        if (which == i || which == names.size()) assign(options.effects, names[i]);
      if (fields) options.fields = {Field::intensity, Field::label, Field::cause, Field::normal, Field::material};
      const bool many = options.effects.transmission.use == EffectUse::on;
      if (fields && !many) options.fields.push_back(Field::barycentrics);
      TestOptions other = options;
      other.device = DeviceChoice::Kind::reference;
      const Scan reference = scanOf(scene, sensor, kPose, other);
      std::optional<Scan> first;
      const Binning left = which % 2 == 0 ? Binning::nearest : Binning::lists;
      for (const Binning binning : {Binning::slabs, Binning::nearest, Binning::lists}) {
        if (binning == left && !all) continue;
        INFO((which < names.size() ? names[which] : "all")
             << (fields ? " with" : " without") << " fields, binning " << static_cast<int>(binning));
        options.tuning.binning = binning;
        const Scan scan = scanOf(scene, sensor, kPose, options);
        const Differences found = differences(reference, scan, {0, 1e-3, 2e-3});
        INFO(found.text());
        CHECK(found.all() <= (many ? found.beams / 500 : 0));
        CHECK(found.ties < found.beams / 20);
        CHECK(scan.counters.hits == reference.counters.hits);
        if (!first) first = scan;
        CHECK(firstBytes(*first, scan) == "none");
        CHECK(first->counters.hits == scan.counters.hits);
        CHECK(first->counters.lostEchoes == scan.counters.lostEchoes);
      }
    }
}

/// A scan with footprints: its beams deviate, or the sensor drives.
struct FootprintScan {
  TestOptions options = optionsOn("vulkan");
  Sensor sensor = coarse(720);
  Shot shot;
};

FootprintScan footprintScan(bool moving) {
  FootprintScan scan;
  scan.options.effects = physical();
  scan.options.effects.returns.use = EffectUse::on;
  scan.options.fields = {Field::intensity, Field::label, Field::cause, Field::normal, Field::material};
  scan.shot.pose = kPose;
  if (!moving) {
    scan.options.effects.angleNoise = {EffectUse::on, 2e-3, 1e-3, Effects::AngleNoise::At::beam};
    return scan;
  }
  scan.options.effects.sensorMotion.use = EffectUse::on;
  scan.sensor.rotationPeriod = 0.1;
  Pose end = kPose;
  end.position.x += 1.5;
  scan.shot.motion = {{{0, kPose}, {0.1, end}}};
  return scan;
}

// With lists every candidate of a footprint is kept, otherwise only those before a triangle that stops the whole
// footprint. Large triangles in several shells stop many of them.
TEST_CASE("footprints have the same echoes with lists and with chains that end where the footprint is stopped") {
  Scene scene = smallTown();
  addFence(scene, plate(3, 2), translation(1.3, 0.4, 1.8));
  for (const bool moving : {false, true}) {
    INFO((moving ? "moving" : "at rest"));
    auto [options, sensor, shot] = footprintScan(moving);
    options.tuning.culling.occlusion = Culling::Occlusion::always;
    options.effects.divergence = {EffectUse::on, moving ? 7u : 19u, Effects::Divergence::Profile::gaussian, 3e-3,
                                  1.5e-3};
    options.effects.cutOuts.use = moving ? EffectUse::off : EffectUse::on;
    options.effects.returns.count = 3;
    std::vector<Scan> scans;
    for (const Binning binning : {Binning::lists, Binning::automatic}) {
      options.tuning.binning = binning;
      Simulator simulator = makeSimulator(scene, sensor, options);
      scans.emplace_back();
      simulator.scanInto(shot, scans.back());
    }
    CHECK(firstBytes(scans[0], scans[1]) == "none");
    CHECK(scans[0].counters.hits == scans[1].counters.hits);
    if (moving) CHECK(scans[1].counters.candidates < scans[0].counters.candidates);
  }
}

TEST_CASE("sub-rays that the lanes of a subgroup share have the echoes that one invocation finds") {
  needVulkan();
  Scene scene = smallTown();
  addFence(scene, plate(3, 2), translation(1.3, 0.4, 1.8));
  for (const double distance : {4, 5, 7}) {
    scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size()), translation(0, 0, 1.8)});
    scene.meshes.push_back(plate(distance, 2, static_cast<uint32_t>(scene.materials.size())));
  }
  scene.materials.push_back(lambertian(0.2f, "pane"));
  scene.materials.back().transmission = 0.6f;
  for (const auto& [moving, binning] :
       {std::pair(false, Binning::automatic), std::pair(true, Binning::automatic), std::pair(false, Binning::lists)}) {
    INFO((moving ? "moving" : "at rest") << ", binning " << int(binning));
    auto [options, sensor, shot] = footprintScan(moving);
    options.tuning.binning = binning;
    // Seven sub-rays need the eight lanes of lavapipe's subgroups, or four lanes as SwiftShader's with two each.
    options.effects.divergence = {EffectUse::on, 7, Effects::Divergence::Profile::gaussian, 6e-3, 3e-3};
    options.effects.transmission.use = options.effects.cutOuts.use = EffectUse::on;
    options.effects.returns.count = 4;
    options.fields.push_back(Field::width);
    std::vector<Scan> scans;
    for (const SubRays subRays : {SubRays::one, SubRays::lanes}) {
      options.tuning.subRays = subRays;
      Simulator simulator = makeSimulator(scene, sensor, options);
      if (2 * simulator.device().subgroupSize < 7) SKIP("a subgroup has no room for the sub-rays");
      scans.emplace_back();
      simulator.scanInto(shot, scans.back());
    }
    CHECK(firstBytes(scans[0], scans[1]) == "none");
    CHECK(scans[0].counters.hits == scans[1].counters.hits);
    CHECK(scans[0].counters.lostEchoes == scans[1].counters.lostEchoes);
    size_t third = 0;  // returns of the third pane
    for (size_t beam = 0; beam < scans[1].beamCount(); ++beam) third += scans[1].returned(4 * beam + 2);
    CHECK(third > 20);
  }
}

TEST_CASE("the lists of footprints have room for a town, and grow once where triangles are smaller than footprints") {
  needVulkan();
  TestOptions options = optionsOn("vulkan");
  options.effects = physical();
  options.effects.divergence = {EffectUse::on, 19, Effects::Divergence::Profile::gaussian, 3e-3, 1.5e-3};
  CHECK(scanOn(smallTown(), coarse(720), kPose, options).counters.retries == 0);
  options.effects.divergence.horizontal = options.effects.divergence.vertical = 0.03;
  const Scan dense = scanOn(sceneOf(ball(300, 300, 4)), coarse(720), Pose(), options);
  CHECK(dense.counters.projected > 2 * dense.beamCount());
  CHECK(dense.counters.candidates > 6 * dense.beamCount());
  CHECK(dense.counters.retries == 1);
}

TEST_CASE("transmitted light passes the same panes on every device") {
  Scene scene = smallTown();
  for (Material& one : scene.materials) one.transmission = 0.5f;
  Effects effects = physical();
  effects.transmission.use = effects.returns.use = EffectUse::on;
  effects.returns.count = 4;
  requireAlmostSame(effects, scene);
}

TEST_CASE("every device counts the beams whose light goes on behind four surfaces, and those of more than six echoes") {
  Scene scene;
  scene.materials = {lambertian(0.2f, "glass")};
  scene.materials[0].transmission = 0.6f;
  // Five panes to the left, and five to the right, which lie between them.
  for (int i = 0; i < 5; ++i)
    for (const double side : {-1, 1}) {
      scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size()), translation(0, 3 * side, 0)});
      scene.meshes.push_back(plate(5 + i + (side > 0 ? 0.5 : 0), 3));
    }
  TestOptions options = optionsOn("vulkan");
  options.effects = physical();
  options.effects.transmission.use = options.effects.returns.use = EffectUse::on;
  options.effects.returns.count = 3;
  std::vector<uint64_t> lost;
  for (const uint32_t subRays : {1u, 19u}) {
    INFO(subRays << " sub-rays");
    if (subRays > 1)
      options.effects.divergence = {EffectUse::on, subRays, Effects::Divergence::Profile::gaussian, 0.02, 0.02};
    options.device = optionsOn("vulkan").device;
    const Sensor sensor = gridSensor(700, 9, -8, 8, 60);
    const Scan scan = scanOn(scene, sensor, Pose(), options);
    options.device = DeviceChoice::Kind::reference;
    const Scan reference = scanOf(scene, sensor, Pose(), options);
    CHECK(scan.counters.lostEchoes == reference.counters.lostEchoes);
    lost.push_back(reference.counters.lostEchoes);
  }
  CHECK(lost[0] > 100);
  CHECK(lost[1] > lost[0] + 20);
}

TEST_CASE("a simulator tells once per sensor that beams see nothing behind four surfaces, unless few beams do") {
  for (const char* device : {"reference", "vulkan"}) {
    CAPTURE(device);
    TestOptions options = optionsOn(device);
    std::vector<std::string> warnings;
    options.warn = [&](const std::string& warning) { warnings.push_back(warning); };
    const Sensor sensor = fan(400, 1, 0, 50);
    const auto told = [&](int faces, double half, bool batch) {
      Scene scene;
      scene.materials = {lambertian(0.2f, "glass"), lambertian(0.5f, "wall")};
      scene.materials[0].transmission = 0.6f;
      for (int i = 0; i <= faces; ++i) {
        scene.instances.push_back({"", static_cast<uint32_t>(i), Transform()});
        scene.meshes.push_back(i < faces ? plate(5 + 0.02 * i, half) : plate(9, 30, 1));
      }
      warnings.clear();
      Simulator simulator(scene, std::vector<SensorRequest>(2, {sensor, Effects()}), options);
      for (const size_t index : {0, 0, 1}) {
        Shot shot;
        shot.sensor = index;
        Scan scan;
        Batch views;
        if (batch)
          simulator.scanBatchInto(std::vector<Shot>(3, shot), views, std::vector<Field>{Field::range});
        else
          simulator.scanInto(shot, scan);
      }
      return warnings.size();
    };
    for (const bool batch : {false, true}) {
      CAPTURE(batch);
      CHECK(told(4, 3, batch) == 2);
      CHECK(told(3, 3, batch) == 0);       // the wall is the fourth surface
      CHECK(told(4, 0.0005, batch) == 0);  // a beam or none
    }
    told(4, 3, false);
    REQUIRE(warnings.size() == 2);
    CHECK(warnings[0] == warnings[1]);
    CHECK(warnings[0] ==
          "sensor 'fan': 69 echoes of 400 beams are lost, because a beam sees at most 4 surfaces behind "
          "each other; a pane of glass with two faces is two surfaces, so model it as one");
  }
}

TEST_CASE("the light of a footprint returns from each of several panes behind each other") {
  needVulkan();
  const double distances[] = {5, 7, 9, 12};
  Scene scene;
  scene.materials = {lambertian(0.5f, "plaster"), lambertian(0.2f, "glass")};
  scene.materials[1].transmission = 0.6f;
  for (const double distance : distances) {
    scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size()), {}});
    scene.meshes.push_back(plate(distance, 6, distance == 12 ? 0 : 1));
  }
  TestOptions options = optionsOn("vulkan");
  options.effects = physical();
  options.effects.transmission.use = options.effects.returns.use = EffectUse::on;
  options.effects.returns.count = 4;
  options.effects.divergence = {EffectUse::on, 19, Effects::Divergence::Profile::gaussian, 3e-3, 1.5e-3};
  const Sensor sensor = gridSensor(360, 9, -8, 8, 60);
  const Scan scan = scanOn(scene, sensor, Pose(), options);
  size_t ahead = 0;
  for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
    const Vec3 direction = directionOf(sensor, beam);
    if (direction.x < std::cos(0.2)) continue;
    ++ahead;
    for (size_t k = 0; k < 4; ++k) {
      INFO("beam " << beam << ", return " << k);
      CHECK(std::abs(scan.ranges[4 * beam + k] - distances[k] / direction.x) < 0.01);
    }
  }
  CHECK(ahead > 100);
}

TEST_CASE("all effects together equal the reference") {
  Effects effects = physical();
  effects.detection = {EffectUse::on, 0.1, 80, 0};
  effects.dropOut = {EffectUse::on, 0.1, 0.8, 0.4, {3, 700, 701}};
  effects.rangeNoise = {EffectUse::on, 0.01, 0.02, 1e-4, 0};
  effects.intensityNoise = {EffectUse::on, 0.05};
  effects.angleNoise = {EffectUse::on, 2e-3, 1e-3, Effects::AngleNoise::At::beam};
  effects.divergence = {EffectUse::on, 7, Effects::Divergence::Profile::gaussian, 3e-3, 1.5e-3};
  effects.returns = {EffectUse::on, Effects::Returns::Mode::lastStrongest};
  effects.fog = {EffectUse::on, 100};
  effects.rain = {EffectUse::on, 20};
  effects.snow = {EffectUse::on, 2};
  effects.volumes = {EffectUse::on, {{{3, -5, -1}, {12, 4, 5}, 0.05}}};
  requireAlmostSame(effects);
}

}  // namespace gnosphere::test
