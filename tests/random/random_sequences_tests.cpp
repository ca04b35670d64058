// SPDX-License-Identifier: Apache-2.0
// One simulator whose materials, meshes, instances and sensors come, change and go in an order drawn at random. A model
// of its scene is kept beside the simulator. Each scan must have the bytes of a scan by a new simulator of that model.
#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "effects/scan_support.hpp"
#include "random/request.hpp"

namespace gnosphere::test {
namespace {

/// Objects with the indices that a simulator gives them: the index that was freed last is given again first.
template <typename T>
class Pool {
 public:
  size_t add(T object) {
    const size_t index = free_.empty() ? objects_.size() : free_.back();
    if (free_.empty())
      objects_.emplace_back();
    else
      free_.pop_back();
    objects_[index] = std::move(object);
    return index;
  }
  void remove(size_t index) {
    objects_[index].reset();
    free_.push_back(index);
  }
  std::vector<uint32_t> indices() const {
    std::vector<uint32_t> result;
    for (uint32_t i = 0; i < objects_.size(); ++i)
      if (objects_[i]) result.push_back(i);
    return result;
  }
  size_t size() const { return objects_.size(); }
  std::optional<T>& operator[](size_t index) { return objects_[index]; }
  const std::vector<std::optional<T>>& all() const { return objects_; }

 private:
  std::vector<std::optional<T>> objects_;  // empty where one was removed
  std::vector<size_t> free_;
};

class Sequence {
 public:
  Sequence(uint32_t number, TestOptions options)
      : random_(number), options_(std::move(options)), simulator_(Scene(), std::vector<SensorRequest>(), options_) {
    materials_.add(lambertian(0.5f));
    simulator_.addMaterial(*materials_[0]);
    addMesh();
    addInstances();
    addSensor();
  }

  /// Makes a change or a scan.
  void step() {
    switch (below(14)) {
      case 0: return addMaterial();
      case 1: return setMaterial();
      case 2: return removeMaterial();
      case 3: return addMesh();
      case 4: return setPositions();
      case 5: return removeMesh();
      case 6: return addInstances();
      case 7: return moveInstances();
      case 8: return removeInstances();
      case 9: return below(3) == 0 ? removeSensor() : addSensor();
      default: return scan();
    }
  }

 private:
  uint32_t below(uint32_t count) { return random_.bits() % count; }
  uint32_t oneOf(const std::vector<uint32_t>& indices) { return indices[below(static_cast<uint32_t>(indices.size()))]; }
  Transform anyPlace() {
    const double angle = 3 * random_(), x = 6 * random_(), y = 6 * random_();
    return translation(x, y, random_()) * rotationZ(angle);
  }

  Material anyMaterial() {
    Material material = lambertian(0.5f + 0.4f * static_cast<float>(random_()));
    material.doubleSided = below(3) > 0;
    material.classId = static_cast<uint16_t>(below(3));
    if (below(3) == 0) material.transmission = 0.7f;
    return material;
  }
  void addMaterial() {
    const Material material = anyMaterial();
    CHECK(simulator_.addMaterial(material) == materials_.add(material));
  }
  void setMaterial() {
    const uint32_t index = oneOf(materials_.indices());
    Material material = anyMaterial();
    material.doubleSided = materials_[index]->doubleSided;
    material.classId = materials_[index]->classId;
    simulator_.setMaterial(index, material);
    materials_[index] = material;
  }
  void removeMaterial() {
    const uint32_t index = oneOf(materials_.indices());
    const auto uses = [&](const auto& mesh) { return mesh && mesh->parts[0].material == index; };
    const bool used = std::ranges::any_of(meshes_.all(), uses);
    if (used || materials_.indices().size() == 1) {
      if (used) CHECK_THROWS_AS(simulator_.removeMaterial(index), Error);
      return;
    }
    simulator_.removeMaterial(index);
    materials_.remove(index);
  }

  void addMesh() {
    Mesh mesh = below(2) == 0 ? ball(3 + below(5), 5 + below(6), 1.5) : soup(random_.bits(), 4 + below(60), 4, 3);
    mesh.parts[0].material = oneOf(materials_.indices());
    CHECK(simulator_.addMesh(mesh) == meshes_.add(mesh));
  }
  void setPositions() {
    const std::vector<uint32_t> meshes = meshes_.indices();
    if (meshes.empty()) return;
    const uint32_t index = oneOf(meshes);
    for (float& x : meshes_[index]->positions) x += 0.3f * static_cast<float>(random_());
    simulator_.setPositions(index, meshes_[index]->positions);
  }
  void removeMesh() {
    const std::vector<uint32_t> meshes = meshes_.indices();
    if (meshes.empty()) return;
    const uint32_t index = oneOf(meshes);
    const auto places = [&](const auto& instance) { return instance && instance->mesh == index; };
    if (std::ranges::any_of(instances_.all(), places)) {
      CHECK_THROWS_AS(simulator_.removeMesh(index), Error);
      return;
    }
    simulator_.removeMesh(index);
    meshes_.remove(index);
  }

  void addInstances() {
    const std::vector<uint32_t> meshes = meshes_.indices();
    if (meshes.empty()) return;
    std::vector<Instance> instances(1 + below(3));
    for (Instance& instance : instances) {
      instance = {"", oneOf(meshes), anyPlace(), static_cast<uint16_t>(below(3))};
      instance.world = below(3) / 2;
    }
    std::vector<uint32_t> expected;
    if (below(5) == 0) {
      Instance wrong = instances[0];
      wrong.mesh = static_cast<uint32_t>(meshes_.size());
      instances.push_back(wrong);
      CHECK_THROWS_AS(simulator_.addInstances(instances), Error);
      instances.pop_back();
    }
    for (const Instance& instance : instances) expected.push_back(static_cast<uint32_t>(instances_.add(instance)));
    CHECK(simulator_.addInstances(instances) == expected);
  }
  void moveInstances() {
    std::vector<uint32_t> moved;
    std::vector<double> rows;
    for (const uint32_t i : instances_.indices()) {
      if (below(2) == 0) continue;
      if (below(4) > 0) instances_[i]->transform = anyPlace();  // otherwise it stays where it is
      const auto& own = instances_[i]->transform.rows;
      moved.push_back(i);
      rows.insert(rows.end(), own.begin(), own.end());
    }
    simulator_.setTransforms(moved, std::span<const double>(rows));
  }
  void removeInstances() {
    std::vector<uint32_t> removed;
    for (const uint32_t i : instances_.indices())
      if (below(3) == 0) removed.push_back(i);
    simulator_.removeInstances(removed);
    for (size_t i = removed.size(); i > 0; --i) {
      instances_.remove(removed[i - 1]);
      for (const uint32_t sensor : sensors_.indices()) std::erase(sensors_[sensor]->ignoredInstances, removed[i - 1]);
    }
  }

  void addSensor() {
    SensorRequest request = {gridSensor(40 + below(40), 4 + below(8), -30, 30), options_.effects, options_.fields};
    for (const uint32_t i : instances_.indices())
      if (below(6) == 0) request.ignoredInstances.push_back(i);
    CHECK(simulator_.addSensor(request) == sensors_.add(request));
  }
  void removeSensor() {
    const uint32_t index = oneOf(sensors_.indices());
    if (sensors_.indices().size() == 1) return;
    simulator_.removeSensor(index);
    sensors_.remove(index);
  }

  /// Returns a scene from which a new simulator gets the same indices. An instance that was removed is one of an empty
  /// mesh there.
  Scene scene() const {
    Scene result;
    for (const auto& material : materials_.all()) result.materials.push_back(material.value_or(Material()));
    for (const auto& mesh : meshes_.all()) result.meshes.push_back(mesh.value_or(Mesh()));
    const Instance removed = {"", static_cast<uint32_t>(result.meshes.size())};
    result.meshes.emplace_back();
    for (const auto& instance : instances_.all()) result.instances.push_back(instance.value_or(removed));
    return result;
  }

  Shot anyShot() {
    Shot shot;
    if (below(2) == 0) pose_.position = {3 * random_(), 3 * random_(), random_()};
    shot.pose = pose_;  // often that of the shot before, whose hits may be kept
    shot.sensor = oneOf(sensors_.indices());
    shot.world = below(3) / 2;
    if (below(4) == 0) shot.ignoredInstances = instances_.indices();
    if (!shot.ignoredInstances.empty()) shot.ignoredInstances.resize(1);
    return shot;
  }
  void scan() {
    std::vector<Shot> shots(1 + below(3));
    for (Shot& shot : shots) shot = anyShot();
    std::vector<SensorRequest> requests;
    for (const auto& sensor : sensors_.all())
      requests.push_back(sensor.value_or(SensorRequest(gridSensor(1, 1, 0, 0))));
    Simulator fresh(scene(), requests, options_);
    std::vector<Scan> expected(shots.size());
    for (size_t i = 0; i < shots.size(); ++i) fresh.scanInto(shots[i], expected[i]);
    const auto requireSame = [&](size_t i, const Scan& scan) {
      CHECK(firstBytes(expected[i], scan) == "none");
      CHECK(valuesOf<uint16_t>(expected[i], Field::classId) == valuesOf<uint16_t>(scan, Field::classId));
    };
    Shot wrong = shots[0];
    wrong.sensor = sensors_.size();
    CHECK_THROWS_AS(simulator_.scanAll(std::vector{shots[0], wrong}, [](size_t, const Scan&) {}), Error);
    simulator_.scanAll(shots, requireSame);
    Scan again;
    simulator_.scanInto(shots.back(), again);
    requireSame(shots.size() - 1, again);
  }

  Random random_;
  TestOptions options_;
  Simulator simulator_;
  Pool<Material> materials_;
  Pool<Mesh> meshes_;
  Pool<Instance> instances_;
  Pool<SensorRequest> sensors_;
  Pose pose_;
};

void requireSequence(uint32_t number, const TestOptions& options, int steps) {
  Sequence sequence(number, options);
  for (int step = 0; step < steps; ++step) {
    INFO("sequence " << number << ", step " << step);
    sequence.step();
  }
}

}  // namespace

TEST_CASE("whatever came and went before, a scan has the bytes of a new simulator's") {
  TestOptions options = vulkanOptions();
  options.fields = {Field::classId};
  SECTION("device") {
    needVulkan();
    options.accuracy = Accuracy::exact;
    for (const uint32_t number : numbersToTry(50)) requireSequence(number, options, 150);
  }
  SECTION("reference, with the effects that the scene calls for") {
    options.device = DeviceChoice::Kind::reference;
    options.effects = Effects();
    options.fields = {Field::classId, Field::intensity, Field::material, Field::normal};
    for (const uint32_t number : numbersToTry(100)) requireSequence(number, options, 150);
  }
}

}  // namespace gnosphere::test
