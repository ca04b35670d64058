// SPDX-License-Identifier: Apache-2.0
// Scenes whose materials, meshes, instances and sensors come and go between scans.
#include <algorithm>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <limits>
#include <random>

#include "columns.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

/// Whether two scans are the same, also in the fields that these tests ask for.
bool sameFields(const Scan& a, const Scan& b) {
  return sameBytes(a, b) && sameBytes(valuesOf<float>(a, Field::intensity), valuesOf<float>(b, Field::intensity)) &&
         sameBytes(valuesOf<float>(a, Field::normal), valuesOf<float>(b, Field::normal)) &&
         sameBytes(valuesOf<uint16_t>(a, Field::classId), valuesOf<uint16_t>(b, Field::classId)) &&
         sameBytes(valuesOf<uint8_t>(a, Field::label), valuesOf<uint8_t>(b, Field::label));
}

/// A scene that changes, kept beside a simulator that is told of each change.
class Model {
 public:
  Model(Scene scene, const SensorRequest& request, TestOptions options)
      : scene_(std::move(scene)),
        request_(request),
        options_(std::move(options)),
        simulator_(scene_, request_, options_) {}

  size_t add(Mesh mesh, const Transform& transform) {
    const size_t index = simulator_.addMesh(mesh);
    const size_t instance = simulator_.addInstance(static_cast<uint32_t>(index), transform);
    scene_.meshes.resize(std::max(scene_.meshes.size(), index + 1));
    scene_.instances.resize(std::max(scene_.instances.size(), instance + 1));
    scene_.meshes[index] = std::move(mesh);
    scene_.instances[instance] = {"", static_cast<uint32_t>(index), transform};
    return instance;
  }

  void remove(size_t instance) {
    const uint32_t mesh = scene_.instances[instance].mesh;
    simulator_.removeInstance(instance);
    simulator_.removeMesh(mesh);
    scene_.meshes[mesh] = {};  // an instance of an empty mesh is what remains of a removed one
  }

  /// The simulator's scan has the bytes of one that a simulator gives that was made for the scene as it is now.
  void requireFresh(const Pose& pose) {
    const Scan scan = simulator_.scan(pose), fresh = Simulator(scene_, request_, options_).scan(pose);
    REQUIRE(sameBytes(scan, fresh));
    REQUIRE(scan.counters.triangles == fresh.counters.triangles);
    REQUIRE(scan.counters.degenerate == fresh.counters.degenerate);
  }

  Simulator& simulator() { return simulator_; }
  Scene& scene() { return scene_; }

 private:
  Scene scene_;
  SensorRequest request_;
  TestOptions options_;
  Simulator simulator_;
};

SensorRequest bare(const Sensor& sensor) {
  return {sensor, Effects::none()};
}

Mesh glassPane(uint32_t material) {
  MeshBuilder builder;
  builder.quad({5, -3, -2}, {0, 6, 0}, {0, 0, 4}, 2);
  return builder.take(material);
}

Material glass() {
  Material material;
  material.name = "glass";
  material.transmission = 0.9f;
  return material;
}

}  // namespace

TEST_CASE("a thousand meshes come and go between scans: each scan is a fresh simulator's, and memory stays flat",
          "[combinations]") {
  needVulkan();
  for (const DeviceChoice& device : {DeviceChoice(), DeviceChoice(DeviceChoice::Kind::reference)}) {
    const bool reference = device.kind == DeviceChoice::Kind::reference;
    TestOptions options = vulkanOptions();
    options.device = device;
    Model model(sceneOf(soup(3, 300, 20, 5)), bare(gridSensor(120, 8, -30, 30)), options);
    std::mt19937 random(7);
    std::vector<size_t> there;
    uint64_t most = 0;
    const auto number = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
    const uint32_t rounds = reference ? 3 : 10, meshes = reference ? 20 : 100;
    for (uint32_t round = 0; round < rounds; ++round) {
      for (uint32_t i = 0; i < meshes; ++i)
        there.push_back(model.add(soup(round * meshes + i, 20 + i, 2, 1),
                                  translation(number(-30, 30), number(-30, 30), number(-5, 5))));
      // A wrong state of one round remains, so later rounds meet it again.
      const bool compared = reference || round % 3 == 0 || everyCombination();
      if (compared)
        model.requireFresh({{double(round), 0, 1}, {}});
      else
        model.simulator().scan({{double(round), 0, 1}, {}});
      if (round == 1) most = model.simulator().memory().scene;
      if (round > 1) CHECK(model.simulator().memory().scene <= most + most / 4);
      std::shuffle(there.begin(), there.end(), random);
      while (there.size() > 5) {
        model.remove(there.back());
        there.pop_back();
      }
      if (compared) model.requireFresh({{0, double(round), 1}, {}});
    }
  }
}

TEST_CASE("a mesh in place of a larger and of a smaller one leaves the others as they were") {
  needVulkan();
  Model model(sceneOf(ball(8, 12, 1, {6, 0, 0})), bare(gridSensor(180, 12, -40, 40)), vulkanOptions());
  const size_t first = model.add(ball(40, 40, 2, {0, 8, 0}), {});
  model.add(ball(6, 8, 1, {0, -6, 0}), {});
  model.remove(first);
  model.requireFresh({});
  const size_t small = model.add(ball(4, 6, 1, {-5, 0, 0}), {});
  model.requireFresh({});
  model.remove(small);
  model.add(ball(60, 60, 3, {-9, 0, 2}), {});
  model.requireFresh({});
}

TEST_CASE("a sensor that asks for surfaces finds those of meshes that lie in another order than they are numbered") {
  needVulkan();
  Scene scene = sceneOf(ball(6, 8, 1, {6, 0, 0}));
  for (const Mesh& mesh : {ball(10, 12, 1, {0, 6, 0}), ball(8, 8, 1, {-6, 0, 0}), ball(6, 8, 1, {0, -6, 0})}) {
    scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size()), {}});
    scene.meshes.push_back(mesh);
  }
  const Sensor sensor = gridSensor(360, 16, -20, 20);
  Simulator simulator(scene, bare(sensor), vulkanOptions());
  for (const size_t index : {2, 0}) {
    simulator.removeInstance(index);
    simulator.removeMesh(index);
  }
  for (const Mesh& mesh : {ball(8, 8, 1.5, {6, 0, 0}), ball(6, 8, 1.5, {-6, 0, 0})}) {
    const auto index = static_cast<uint32_t>(simulator.addMesh(mesh));
    scene.meshes[index] = mesh;
    REQUIRE(simulator.addInstance(index, {}) == index);
  }
  const SensorRequest request = {sensor, Effects::none(), {Field::normal}};
  const Scan scan = simulator.scan({}, simulator.addSensor(request));
  CHECK(sameFields(scan, Simulator(scene, request, vulkanOptions()).scan({})));
  for (uint32_t instance = 0; instance < 4; ++instance) CHECK(std::ranges::count(scan.instances, instance) > 0);
}

TEST_CASE("glass that is added lets light through from the next scan on, and its removal ends that") {
  needVulkan();
  for (const DeviceChoice& device : {DeviceChoice(), DeviceChoice(DeviceChoice::Kind::reference)}) {
    TestOptions options = vulkanOptions();
    options.device = device;
    MeshBuilder wall;
    wall.quad({9, -9, -9}, {0, 18, 0}, {0, 0, 18}, 3);
    Scene scene = sceneOf(wall.take());
    const SensorRequest request = {gridSensor(90, 6, -10, 10), {}, {Field::intensity}};
    Simulator simulator(scene, request, options);
    CHECK_FALSE(simulator.plan().has("transmission"));
    const Scan before = simulator.scan({});
    const size_t material = simulator.addMaterial(glass());
    const size_t mesh = simulator.addMesh(glassPane(static_cast<uint32_t>(material)));
    CHECK_FALSE(simulator.plan().has("transmission"));  // nothing shows the material yet
    const size_t instance = simulator.addInstance(static_cast<uint32_t>(mesh), {});
    CHECK(simulator.plan().has("transmission"));
    Scene withPane = scene;
    withPane.materials.push_back(glass());
    withPane.meshes.push_back(glassPane(1));
    withPane.instances.push_back({"", 1, {}});
    CHECK(sameFields(simulator.scan({}), Simulator(withPane, request, options).scan({})));
    CHECK_FALSE(sameFields(simulator.scan({}), before));  // less light comes back from the wall
    simulator.removeInstance(instance);
    CHECK_FALSE(simulator.plan().has("transmission"));  // nothing shows the material any more
    simulator.removeMesh(mesh);
    simulator.removeMaterial(material);
    CHECK_FALSE(simulator.plan().has("transmission"));
    CHECK(sameFields(simulator.scan({}), before));
  }
}

TEST_CASE("a cut-out material that is added brings its own image") {
  needVulkan();
  MeshBuilder wall;
  wall.quad({9, -9, -9}, {0, 18, 0}, {0, 0, 18}, 3);
  const Scene scene = sceneOf(wall.take());
  const SensorRequest request = {gridSensor(180, 12, -10, 10)};
  AlphaImage image = {4, 4, {}};
  for (int i = 0; i < 16; ++i) image.alpha.push_back(i % 3 == 0 ? 255 : 0);
  Material leaves;
  leaves.alphaMode = AlphaMode::mask;
  Mesh tree = glassPane(1);
  for (size_t v = 0; v < tree.vertexCount(); ++v) {
    tree.uvs.push_back(tree.positions[3 * v + 1]);
    tree.uvs.push_back(tree.positions[3 * v + 2]);
  }
  Simulator simulator(scene, request, vulkanOptions());
  simulator.scan({});
  REQUIRE(simulator.addMaterial(leaves, &image) == 1);
  simulator.addInstance(static_cast<uint32_t>(simulator.addMesh(tree)), {});
  Scene planted = scene;
  leaves.alphaImage = 0;
  planted.alphaImages.push_back(image);
  planted.materials.push_back(leaves);
  planted.meshes.push_back(tree);
  planted.instances.push_back({"", 1, {}});
  CHECK(simulator.plan().has("cut-outs"));
  CHECK(sameBytes(simulator.scan({}), Simulator(planted, request, vulkanOptions()).scan({})));
}

TEST_CASE("a scene that is added scans as the joined scene does, and a wrong place leaves nothing of it behind") {
  needVulkan();
  MeshBuilder wall;
  wall.quad({9, -9, -9}, {0, 18, 0}, {0, 0, 18}, 3);
  const Scene scene = sceneOf(wall.take());
  Scene added = sceneOf(glassPane(0));
  added.materials.push_back(glass());
  Material leaves;
  leaves.alphaMode = AlphaMode::mask;
  leaves.alphaImage = 1;
  added.materials.push_back(leaves);
  added.alphaImages = {{1, 1, {7}}, {2, 2, {0, 255, 255, 0}}};  // no material has the first
  Mesh tree = glassPane(2);
  for (size_t v = 0; v < tree.vertexCount(); ++v) tree.uvs.insert(tree.uvs.end(), {tree.positions[3 * v + 1], 0.5f});
  added.meshes.push_back(tree);
  added.meshes.push_back(glassPane(1));
  added.instances.push_back({"", 1, translation(0, 7, 0), 4});  // beside the first pane, where both are seen
  added.instances.push_back({"", 2, translation(1, -7, 0), 6});
  const Transform place = {{0, 1, 0, 1, -1, 0, 0, 0, 0, 0, 1, 0.5}};
  const SensorRequest request = {gridSensor(180, 12, -10, 10), {}, {Field::intensity, Field::classId, Field::normal}};
  Simulator simulator(scene, request, vulkanOptions());
  const Scan before = simulator.scan({});
  Transform nowhere = place;
  nowhere.rows[7] = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(simulator.addScene(added, nowhere), "entry 0: the transform is not finite");
  CHECK(sameFields(simulator.scan({}), before));
  CHECK(simulator.addMaterial(glass()) == 1);  // the indices are free again
  simulator.removeMaterial(1);
  const AddedScene indices = simulator.addScene(added, place);
  CHECK(indices.materials == std::vector<uint32_t>{1, 2, 3});
  CHECK(indices.meshes == std::vector<uint32_t>{1, 2, 3});
  CHECK(indices.instances == std::vector<uint32_t>{1, 2, 3});
  CHECK(simulator.plan().has("cut-outs"));
  CHECK(simulator.plan().has("transmission"));
  const Scan scan = simulator.scan({});
  CHECK(sameFields(scan, Simulator(joined(scene, added, place), request, vulkanOptions()).scan({})));
  for (const int classId : {4, 6}) CHECK(std::ranges::count(valuesOf<uint16_t>(scan, Field::classId), classId) > 0);
  const auto imageBytes = [&] {
    const Plan plan = simulator.plan();
    return std::ranges::find(plan.buffers, "alphaImages", &Plan::Buffer::name)->bytes;
  };
  const uint64_t bytes = imageBytes();
  for (const uint32_t instance : indices.instances) simulator.removeInstance(instance);
  for (const uint32_t mesh : indices.meshes) simulator.removeMesh(mesh);
  for (const uint32_t material : indices.materials) simulator.removeMaterial(material);
  CHECK(sameFields(simulator.scan({}), before));
  simulator.addScene(added, place);
  CHECK(imageBytes() == bytes);  // images take the places of those that were removed
}

TEST_CASE("a material of meshes in use changes its optics, its image, and whether it is glass") {
  for (const auto kind : {DeviceChoice::Kind::reference, DeviceChoice::Kind::vulkan}) {
    TestOptions options = vulkanOptions();
    if (kind == DeviceChoice::Kind::vulkan) needVulkan();
    options.device = kind;
    MeshBuilder wall, pane;
    wall.quad({9, -9, -9}, {0, 18, 0}, {0, 0, 18}, 3);
    pane.quad({4, -1, -9}, {0, 4, 0}, {0, 0, 18}, 2);
    Scene scene = sceneOf(wall.take());
    scene.materials = {Material(), Material(), glass()};
    scene.materials[1].alphaMode = AlphaMode::mask;
    scene.materials[1].alphaImage = 0;
    AlphaImage image = {4, 4, {}};
    for (int i = 0; i < 16; ++i) image.alpha.push_back(i % 3 == 0 ? 255 : 0);
    scene.alphaImages = {image};
    Mesh sheet = pane.take();
    for (size_t v = 0; v < sheet.vertexCount(); ++v) {
      sheet.uvs.push_back(sheet.positions[3 * v + 1]);
      sheet.uvs.push_back(sheet.positions[3 * v + 2]);
    }
    for (uint32_t i = 0; i < 3; ++i) {
      sheet.parts[0].material = i;
      scene.meshes.push_back(sheet);
      scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size() - 1), translation(0, 5.0 * i - 5, 0)});
    }
    const SensorRequest request = {gridSensor(180, 12, -10, 10), {}, {Field::intensity}};
    Simulator simulator(scene, request, options);
    const auto requireFresh = [&] {
      for (int turn = 0; turn < 2; ++turn)  // the second scan from a pose may use what the first has kept
        REQUIRE(sameFields(simulator.scan({}), Simulator(scene, request, options).scan({})));
    };
    const auto change = [&](uint32_t index, const auto& how, const AlphaImage* own = nullptr) {
      const Scan before = simulator.scan({});
      how(scene.materials[index]);
      simulator.setMaterial(index, scene.materials[index], own);
      requireFresh();
      CHECK_FALSE(sameFields(simulator.scan({}), before));
    };
    requireFresh();
    change(0, [](Material& material) { material.baseColor = {0.2f, 0.3f, 0.4f, 1}; });
    change(2, [](Material& material) { material.transmission = 0.3f; });
    change(0, [](Material& material) { material.transmission = 0.9f; });  // beside a pane that was one before
    change(2, [](Material& material) { material.transmission = 0; });
    change(0, [](Material& material) { material.transmission = 0; });  // no glass any more
    CHECK_FALSE(simulator.plan().has("transmission"));
    change(2, [](Material& material) { material.transmission = 0.5f; });
    for (uint8_t& alpha : image.alpha) alpha = 255 - alpha;
    scene.alphaImages[0] = image;
    change(
        1, [](Material& material) { material.alphaCutoff = 0.3f; }, &image);

    const auto refuse = [&](uint32_t index, const auto& how, const AlphaImage* own, const std::string& words) {
      Material other = scene.materials[index];
      how(other);
      CHECK_THROWS_WITH(simulator.setMaterial(index, other, own), Catch::Matchers::ContainsSubstring(words));
      requireFresh();
    };
    const auto same = [](Material&) {};
    refuse(
        0, [](Material& material) { material.doubleSided = !material.doubleSided; }, nullptr, "another side");
    refuse(
        0, [](Material& material) { material.classId = 7; }, nullptr, "another class");
    refuse(0, same, &image, "another kind of alpha");
    refuse(1, same, nullptr, "another kind of alpha");
    refuse(
        0, [](Material& material) { material.roughness = 2; }, nullptr, "roughness");
    CHECK_THROWS_WITH(simulator.setMaterial(3, Material()), Catch::Matchers::ContainsSubstring("material 3"));
  }
}

TEST_CASE("a material gets an image of its own if it shared the one before") {
  for (const auto kind : {DeviceChoice::Kind::reference, DeviceChoice::Kind::vulkan}) {
    TestOptions options = vulkanOptions();
    if (kind == DeviceChoice::Kind::vulkan) needVulkan();
    options.device = kind;
    MeshBuilder pane;
    pane.quad({4, -4, -4}, {0, 4, 0}, {0, 0, 8}, 2);
    Scene scene = sceneOf(pane.take());
    scene.materials.resize(2);
    for (Material& leaves : scene.materials) {
      leaves.alphaMode = AlphaMode::mask;
      leaves.alphaImage = 0;
    }
    scene.alphaImages = {{1, 1, {0}}, {1, 1, {255}}};
    scene.meshes[0].uvs.assign(2 * scene.meshes[0].vertexCount(), 0.5f);
    scene.meshes.push_back(scene.meshes[0]);
    scene.meshes[1].parts[0].material = 1;
    scene.instances = {{"", 0, {}}, {"", 1, translation(0, 4, 0)}};
    const SensorRequest request = {gridSensor(180, 6, -10, 10)};
    Simulator simulator(scene, request, options);
    CHECK(simulator.scan({}).counters.hits == 0);
    scene.materials[1].alphaImage = 1;
    simulator.setMaterial(1, scene.materials[1], &scene.alphaImages[1]);
    const Scan scan = simulator.scan({});
    CHECK(scan.counters.hits > 0);
    CHECK(sameBytes(scan, Simulator(scene, request, options).scan({})));
  }
}

// No texture tells where the holes are, so nothing of the plan changes but the optics.
TEST_CASE("holes of a material that change are seen by a sensor that stands still") {
  needVulkan();
  MeshBuilder panes;
  panes.quad({4, -4, -4}, {0, 8, 0}, {0, 0, 8}, 2);
  Scene scene = sceneOf(panes.take());
  Material& veil = scene.materials[0];
  veil.alphaMode = AlphaMode::mask;
  veil.baseColor[3] = 0.4f;
  SensorRequest request = {gridSensor(180, 6, -10, 10), Effects::none()};
  request.effects.cutOuts.use = EffectUse::on;
  Simulator simulator(scene, request, vulkanOptions());
  for (const float cutOff : {0.3f, 0.5f, 0.2f}) {
    veil.alphaCutoff = cutOff;
    simulator.setMaterial(0, veil);
    for (int scan = 0; scan < 4; ++scan) CHECK((simulator.scan({}).counters.hits > 0) == (cutOff < 0.4f));
  }
}

TEST_CASE("sensors of one scene have effects and fields of their own, and come and go") {
  needVulkan();
  const Scene scene = sceneOf(soup(3, 500, 20, 5));
  const Sensor sensor = gridSensor(120, 8, -30, 30);
  Effects quiet = Effects::none(), noisy = Effects::none();
  quiet.rangeNoise = {EffectUse::on, 0, 0.01};
  noisy.rangeNoise = {EffectUse::on, 0, 0.2};
  Simulator simulator(scene, {SensorRequest(sensor, quiet), SensorRequest(sensor, noisy, {Field::trueRange})},
                      vulkanOptions());
  const uint64_t sceneBytes = simulator.memory().scene, work = simulator.memory().work;
  const Scan one = simulator.scan({}, 0), other = simulator.scan({}, 1);
  const auto truth = other.column<float>(Field::trueRange);
  double quietSum = 0, noisySum = 0;
  for (size_t i = 0; i < one.ranges.size(); ++i) {
    if (!one.hit(i)) continue;
    quietSum += std::abs(one.ranges[i] - truth[i]);
    noisySum += std::abs(other.ranges[i] - truth[i]);
  }
  CHECK_FALSE(one.has(Field::trueRange));
  CHECK(noisySum > 10 * quietSum);

  const size_t third = simulator.addSensor({sensor, Effects::none()});
  CHECK(third == 2);
  CHECK(sameBytes(simulator.scan({}, third), Simulator(scene, bare(sensor), vulkanOptions()).scan({})));
  CHECK(sameBytes(simulator.scan({}, 1), other));
  CHECK(simulator.memory().work > work);
  simulator.removeSensor(0);
  simulator.removeSensor(third);
  CHECK(simulator.memory().scene < sceneBytes + sceneBytes / 4);
  CHECK_THROWS_WITH(simulator.scan({}, 0), "sensor 0 has been removed");
  CHECK(simulator.addSensor({sensor, quiet}) == third);
  CHECK(simulator.addSensor({sensor, quiet}) == 0);
  CHECK(sameBytes(simulator.scan({}, 0), one));
}

TEST_CASE("a fog that thickens shot by shot makes no pipeline and moves nothing of the scene") {
  needVulkan();
  for (const DeviceChoice& device : {DeviceChoice(), DeviceChoice(DeviceChoice::Kind::reference)}) {
    TestOptions options = vulkanOptions();
    options.device = device;
    const Scene scene = sceneOf(ball(20, 30, 40));
    const Sensor sensor = gridSensor(180, 16, -30, 30);
    SensorRequest request = {sensor, {}, {Field::label}};
    request.variableWeather = true;
    Simulator simulator(scene, request, options);
    const auto pipelines = [&] {
      Plan plan = simulator.plan();
      plan.buffers.clear();  // lists grow
      return toJson(plan);
    };
    const std::string before = pipelines();
    Shot shot;
    Scan scan;
    simulator.scanInto(shot, scan);
    CHECK(scan.counters.hits == sensor.beamCount());  // clear air
    const uint64_t sceneBytes = simulator.memory().scene;
    uint64_t scattered = 0;
    for (const double visibility : {400.0, 100.0, 25.0}) {
      shot.weather = Weather{visibility, 0, 0, {}};
      simulator.scanInto(shot, scan);
      const auto labels = scan.column<uint8_t>(Field::label);
      const auto now = static_cast<uint64_t>(std::count(labels.begin(), labels.end(), uint8_t(Label::scatter)));
      CHECK(now >= scattered);
      scattered = now;
      SensorRequest stated = request;  // the same fog, stated once for all
      stated.effects.fog.visibility = visibility;
      CHECK(sameFields(scan, Simulator(scene, stated, options).scan({})));
    }
    CHECK(scattered > 0);
    shot.weather = Weather{0, 20, 2, {{{-5, -5, -5}, {5, 5, 5}, 0.3}}};
    simulator.scanInto(shot, scan);
    CHECK(scan.counters.hits > 0);
    CHECK(pipelines() == before);
    CHECK(simulator.memory().scene == sceneBytes);
  }
}

TEST_CASE("what does not fit is refused with its name, and the simulator goes on") {
  needVulkan();
  const Scene scene = sceneOf(soup(3, 100, 20, 5));
  const Sensor sensor = gridSensor(60, 4, -30, 30);
  Simulator simulator(scene, bare(sensor), vulkanOptions());
  const Scan before = simulator.scan({});
  Mesh mesh = glassPane(7);
  CHECK_THROWS_WITH(simulator.addMesh(mesh), "the new mesh: material 7 does not exist, the scene has 1");
  mesh = glassPane(0);
  mesh.indices[0] = 99;
  CHECK_THROWS_WITH(simulator.addMesh(mesh), "the new mesh: index 99 is out of range, the mesh has 9 vertices");
  CHECK_THROWS_WITH(simulator.addInstance(5, {}), "mesh 5 does not exist, there are 1");
  CHECK_THROWS_WITH(simulator.removeMesh(0), "mesh 0 is used by 1 instances; remove them before it");
  CHECK_THROWS_WITH(simulator.removeMaterial(0), "material 0 is used by 1 meshes; remove them before it");
  CHECK_THROWS_WITH(simulator.removeSensor(3), "sensor 3 does not exist, there are 1");
  const size_t added = simulator.addMesh(glassPane(0));
  simulator.removeMesh(added);
  CHECK_THROWS_WITH(simulator.removeMesh(added), "mesh 1 has been removed");
  CHECK_THROWS_WITH(simulator.addInstance(1, {}), "mesh 1 has been removed");
  Sensor blind = sensor;
  blind.columns = 0;
  CHECK_THROWS_AS(simulator.addSensor(blind), Error);
  Shot shot;
  shot.weather = Weather{100, 0, 0, {}};
  Scan scan;
  CHECK_THROWS_WITH(
      simulator.scanInto(shot, scan),
      "the shot brings fog, which is not planned for sensor 'grid'; set variable_weather in the sensor's request, and "
      "do not turn fog off");
  CHECK(sameBytes(simulator.scan({}), before));
}

TEST_CASE("a sensor whose arrays do not fit is refused, and the others go on") {
  needVulkan();
  TestOptions options = vulkanOptions();
  options.tuning.maxBufferBytes = 1 << 20;
  const Sensor sensor = gridSensor(60, 4, -30, 30);
  Simulator simulator(sceneOf(soup(3, 100, 20, 5)), bare(sensor), options);
  const Scan before = simulator.scan({});
  CHECK_THROWS_AS(simulator.addSensor(bare(gridSensor(200'000, 4, -30, 30))), Error);
  CHECK(sameBytes(simulator.scan({}), before));
  CHECK(simulator.addSensor(bare(sensor)) == 1);
  CHECK(sameBytes(simulator.scan({}, 1), before));
}
