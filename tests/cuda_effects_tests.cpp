// SPDX-License-Identifier: Apache-2.0
// Effects on the CUDA backend have the bytes of those on Vulkan: its kernels on the host, and on a CUDA device where
// there is one. What effects mean is tested against the reference elsewhere.
#include <algorithm>
#include <catch2/generators/catch_generators.hpp>

#include "cuda/twin.hpp"
#include "effects/scan_support.hpp"
#include "town/town.hpp"

namespace gnosphere::test {
namespace {

using Profile = Effects::Divergence::Profile;
using Mode = Effects::Returns::Mode;
using At = Effects::AngleNoise::At;

constexpr double kPeriod = 0.1;  // seconds for a turn

const Pose kPose = {{1.3, 0.4, 1.8}, {0.01, -0.02, 0.3, 0.95}};

/// A town of which every other material is a pane, with a fence that has holes.
Scene glazedTown() {
  Scene scene = makeTown({.triangles = 20'000});
  for (size_t i = 0; i < scene.materials.size(); i += 2) scene.materials[i].transmission = 0.5f;
  Material fence = lambertian(0.5f, "fence");
  fence.doubleSided = true;
  fence.alphaMode = AlphaMode::mask;
  fence.alphaImage = static_cast<uint32_t>(scene.alphaImages.size());
  fence.baseColor[3] = 0.9f;
  scene.alphaImages.push_back({3, 2, {0, 255, 90, 200, 0, 255}, AlphaImage::Wrap::mirror, AlphaImage::Wrap::repeat});
  scene.materials.push_back(fence);
  Mesh mesh = plate(6, 3, static_cast<uint32_t>(scene.materials.size() - 1));
  mesh.uvs = {-1.7f, 0, 0, 4.5f, 3.1f, 0, 2, 4};
  scene.meshes.push_back(mesh);
  scene.instances.push_back({"fence", static_cast<uint32_t>(scene.meshes.size() - 1), translation(0, 0, 2)});
  return scene;
}

const Scene& town() {
  static const Scene scene = glazedTown();
  return scene;
}

/// Columns that no workgroup divides, and lasers with azimuths of their own.
Sensor unevenSensor() {
  Sensor sensor = gridSensor(181, 12, -25, 15, 80);
  for (size_t j = 0; j < sensor.channels.size(); j += 2) sensor.channels[j].azimuthOffsetDeg = 1.7 * double(j) - 9;
  sensor.rotationPeriod = kPeriod;
  return sensor;
}

/// And places of their own.
Sensor unevenHead() {
  Sensor sensor = unevenSensor();
  for (size_t j = 0; j < sensor.channels.size(); ++j) sensor.channels[j].origin = {0.03, 0.02 * double(j % 3), -0.01};
  return sensor;
}

struct Request {
  Effects effects;
  std::vector<Field> fields;
  Accuracy accuracy = Accuracy::exact;
};

/// Every field, and nothing but what fields ask for.
Request everyField() {
  Request request;
  request.fields = effectFields();
  request.fields.insert(request.fields.end(), {Field::barycentrics, Field::velocity});
  request.effects = Effects::none();
  request.effects.intensity.use = request.effects.radialSpeed.use = Use::automatic;
  return request;
}

Request with(void (*assign)(Effects& effects)) {
  Request request = everyField();
  request.effects.intensity.use = Use::on;
  assign(request.effects);
  return request;
}

/// Which arrays of two scans differ, and where they do first.
std::string difference(const Scan& a, const Scan& b) {
  std::string result;
  const auto compare = [&](const char* name, const auto& first, const auto& second) {
    size_t i = 0;
    while (i < first.size() && i < second.size() && std::memcmp(&first[i], &second[i], sizeof first[i]) == 0) ++i;
    if (i == first.size() && i == second.size()) return;
    result += std::string(name) + " " + std::to_string(i);
    if (i < first.size() && i < second.size())
      result += ": " + std::to_string(first[i]) + ", got " + std::to_string(second[i]);
    result += "; ";
  };
  compare("point", a.points, b.points);
  compare("range", a.ranges, b.ranges);
  compare("triangle", a.triangles, b.triangles);
  compare("instance", a.instances, b.instances);
  compare("intensity", a.intensities, b.intensities);
  compare("true range", a.trueRanges, b.trueRanges);
  compare("width", a.widths, b.widths);
  compare("label", a.labels, b.labels);
  compare("cause", a.causes, b.causes);
  compare("normal", a.normals, b.normals);
  compare("incidence", a.incidences, b.incidences);
  compare("material", a.materials, b.materials);
  compare("barycentric", a.barycentrics, b.barycentrics);
  compare("velocity", a.velocities, b.velocities);
  compare("radial speed", a.radialSpeeds, b.radialSpeeds);
  compare("count of causes", a.counters.causes, b.counters.causes);
  return result.empty() ? "none" : result;
}

/// The shots in all that a scan holds: of Vulkan, of CUDA's kernels on the host, and of a CUDA device.
void requireParity(const Request& request, const Sensor& sensor, const std::vector<Shot>& shots) {
  needVulkan();
  SimulatorOptions options = vulkanOptions();
  options.effects = request.effects;
  options.fields = request.fields;
  options.accuracy = request.accuracy;
  const std::vector<Sensor> sensors = {sensor, sensor};  // the second is asked: its number keys the draws
  Simulator vulkan(town(), sensors, options);
  CudaOnHost onHost(town(), sensors, options);
  std::optional<Simulator> onDevice;
  options.device = "cuda:0";
  if (cudaProblem().empty()) onDevice.emplace(town(), sensors, options);
  for (Shot shot : shots) {
    shot.sensor = 1;
    INFO("frame " << shot.frame);
    Scan expected, scan;
    vulkan.scan(shot, expected);
    CHECK(expected.counters.hits > 300);
    REQUIRE(difference(expected, onHost.scan(shot)) == "none");
    if (onDevice) {
      onDevice->scan(shot, scan);
      REQUIRE(difference(expected, scan) == "none");
    }
  }
}

Shot standing(uint64_t frame = 0) {
  Shot shot;
  shot.pose = kPose;
  shot.frame = frame;
  return shot;
}

/// 20 m/s ahead and 2 rad/s to the left.
Shot driving() {
  Shot shot = standing(3);
  const double half = 0.1;
  shot.motion.stamps = {{0, kPose}, {kPeriod, {{3.3, 0.4, 1.8}, {0, 0, std::sin(0.2 + half), std::cos(0.2 + half)}}}};
  return shot;
}

/// The fence comes nearer, and what is first in the town goes away.
Shot traffic(Shot shot) {
  shot.instanceMotions = {{town().instances.size() - 1, translation(-1.5, 0.5, 2)},
                          {0, translation(0.5, 1, 0) * town().instances[0].transform}};
  return shot;
}

}  // namespace

TEST_CASE("cuda effects: fields alone") {
  requireParity(everyField(), unevenSensor(), {standing()});
  Request few = everyField();
  few.fields = {Field::radialSpeed};
  requireParity(few, unevenSensor(), {standing()});
  few.fields = {Field::normal};
  requireParity(few, unevenSensor(), {standing()});
}

TEST_CASE("cuda effects: each that one line per beam shows") {
  using Model = Effects::Intensity::Model;
  using Scale = Effects::Intensity::Scale;
  const std::vector<Shot> shots = {standing(), standing(7)};
  const auto require = [&](void (*assign)(Effects & effects)) { requireParity(with(assign), unevenSensor(), shots); };
  require([](Effects& e) { e.intensity.scale = Scale::byte; });
  require([](Effects& e) { e.intensity.model = Model::carla; });
  require([](Effects& e) { e.detection = {Use::on, 0.1, 40, 0.3}; });
  require([](Effects& e) { e.dropOut = {Use::on, 0.1, 0.8, 0.4, {3, 700, 701}}; });
  require([](Effects& e) { e.rangeNoise = {Use::on, 0.01, 0.02, 1e-4, 4e-3}; });
  require([](Effects& e) { e.angleNoise = {Use::on, 1e-3, 2e-3, At::point}; });
  require([](Effects& e) { e.intensityNoise = {Use::on, 0.05}; });
  require([](Effects& e) { e.fog = {Use::on, 60}; });
  require([](Effects& e) { e.rain = {Use::on, 50}; });
  require([](Effects& e) { e.snow = {Use::on, 10}; });
  require([](Effects& e) { e.volumes = {Use::on, {{{3, -5, -1}, {12, 4, 5}, 0.05}}}; });
}

TEST_CASE("cuda effects: footprints of few and of many sub-rays, of beams that stay and of beams astray") {
  const std::vector<Shot> shots = {standing()};
  const auto require = [&](void (*assign)(Effects & effects)) { requireParity(with(assign), unevenSensor(), shots); };
  require([](Effects& e) { e.angleNoise = {Use::on, 2e-3, 1e-3, At::beam}; });
  require([](Effects& e) {
    e.divergence = {Use::on, 7, Profile::gaussian, 3e-3, 1.5e-3};
    e.returns = {Use::on, Mode::all, 3};
  });
  require([](Effects& e) {
    e.divergence = {Use::on, 19, Profile::uniform, 5e-3, 5e-3};
    e.returns = {Use::on, Mode::firstLast};
    e.angleNoise = {Use::on, 2e-3, 1e-3, At::beam};
  });
  require([](Effects& e) {
    e.divergence = {Use::on, 50, Profile::gaussian, 9e-3, 4e-3};
    e.returns = {Use::on, Mode::strongestSecondStrongest};
  });
}

TEST_CASE("cuda effects: panes and holes") {
  const std::vector<Shot> shots = {standing()};
  const auto require = [&](void (*assign)(Effects & effects)) { requireParity(with(assign), unevenSensor(), shots); };
  require([](Effects& e) { e.cutOuts.use = Use::on; });
  require([](Effects& e) {
    e.transmission.use = Use::on;
    e.returns = {Use::on, Mode::all, 4};
  });
  require([](Effects& e) {
    e.divergence = {Use::on, 5, Profile::gaussian, 3e-3, 1.5e-3};
    e.transmission.use = e.cutOuts.use = Use::on;
    e.returns = {Use::on, Mode::all, 5};
  });
}

TEST_CASE("cuda effects: a sensor, instances and lasers that are elsewhere when they fire") {
  Request request = with([](Effects& e) { e.sensorMotion.use = e.objectMotion.use = Use::on; });
  request.accuracy = Accuracy::standard;
  const std::vector<Shot> shots = {standing(), driving(), traffic(standing()), traffic(driving())};
  requireParity(request, unevenSensor(), shots);
  request.effects.sensorMotion.deskew = true;
  requireParity(request, unevenHead(), shots);
  request.effects.divergence = {Use::on, 7, Profile::gaussian, 3e-3, 1.5e-3};
  request.effects.returns = {Use::on, Mode::all, 2};
  requireParity(request, unevenHead(), shots);
}

TEST_CASE("cuda effects: all together, by seed and by frame") {
  Request request = with([](Effects& e) {
    e.seed = 5;
    e.detection = {Use::on, 0.1, 80, 0};
    e.dropOut = {Use::on, 0.1, 0.8, 0.4, {3, 700, 701}};
    e.rangeNoise = {Use::on, 0.01, 0.02, 1e-4, 0};
    e.intensityNoise = {Use::on, 0.05};
    e.angleNoise = {Use::on, 2e-3, 1e-3, At::beam};
    e.divergence = {Use::on, 7, Profile::gaussian, 3e-3, 1.5e-3};
    e.returns = {Use::on, Mode::lastStrongest};
    e.transmission.use = e.cutOuts.use = e.sensorMotion.use = e.objectMotion.use = e.radialSpeed.use = Use::on;
    e.fog = {Use::on, 100};
    e.rain = {Use::on, 20};
    e.snow = {Use::on, 2};
    e.volumes = {Use::on, {{{3, -5, -1}, {12, 4, 5}, 0.05}}};
  });
  request.accuracy = Accuracy::standard;
  requireParity(request, unevenHead(), {standing(), standing(1), traffic(driving())});
}

TEST_CASE("cuda effects: a plan names the stages and dispatches of Vulkan's, and the arrays there are") {
  needVulkan();
  Request request = with([](Effects& e) { e.fog = {Use::on, 60}; });
  const bool footprint = GENERATE(false, true);
  if (footprint) request.effects.divergence = {Use::on, 7, Profile::gaussian, 3e-3, 1.5e-3};
  SimulatorOptions options = vulkanOptions();
  options.effects = request.effects;
  options.fields = request.fields;
  const Sensor sensor = unevenSensor();
  const Plan expected = Simulator(town(), sensor, options).plan();
  const Plan plan = CudaOnHost(town(), {sensor}, options).backend().plan(0);
  CHECK(plan.binning == expected.binning);
  CHECK(plan.returns == expected.returns);
  CHECK(plan.effects.size() == expected.effects.size());
  REQUIRE(plan.stages.size() == expected.stages.size());
  const auto pipelines = [](const Plan::Stage& stage) {
    std::vector<std::pair<std::string, std::vector<uint32_t>>> result;
    for (const Plan::Pipeline& pipeline : stage.pipelines) result.emplace_back(pipeline.name, pipeline.constants);
    std::sort(result.begin(), result.end());
    return result;
  };
  for (size_t i = 0; i < plan.stages.size(); ++i) {
    CHECK(plan.stages[i].name == expected.stages[i].name);
    CHECK(plan.stages[i].dispatches == expected.stages[i].dispatches);
    CHECK(pipelines(plan.stages[i]) == pipelines(expected.stages[i]));
  }
  const auto bytesOf = [](const Plan& of, const std::string& name) {
    uint64_t sum = 0;
    for (const Plan::Buffer& buffer : of.buffers)
      if (buffer.name == name) sum += buffer.bytes;
    return sum;
  };
  for (const char* name : {"results", "subRays", "echoes", "projectedA", "rows", "tiles"}) {
    INFO(name);
    CHECK(bytesOf(plan, name) == bytesOf(expected, name));
  }
}

}  // namespace gnosphere::test
