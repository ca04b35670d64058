// SPDX-License-Identifier: Apache-2.0
// Memory of the host or of the device runs out at every place of batches, of runs with several views, and of changes of
// many instances in many worlds.
#include <optional>

#include "failure/injection.hpp"
#include "failure/kinds.hpp"

namespace gnosphere::test {
namespace {

/// Instances that every world sees, instances of three worlds, and between them some that no scan reaches.
Scene scatteredWorlds(uint32_t triangles = 40) {
  Scene scene = sceneOf(soup(5, 60, 30, 6));
  scene.meshes.push_back(soup(6, triangles, 3, 1));
  for (uint32_t i = 0; i < 24; ++i) {
    Instance instance;
    instance.mesh = 1;
    instance.world = i % 4;
    instance.transform = i % 3 == 0 ? translation(5000 + i, 0, 0) : translation(i - 12.0, 8 - i % 16, 0);
    scene.instances.push_back(instance);
  }
  return scene;
}

std::vector<Shot> shotsOf(size_t count, double offset) {
  std::vector<Shot> shots(count);
  for (size_t i = 0; i < count; ++i) {
    shots[i].pose.position = {offset + 0.3 * static_cast<double>(i), 0.2, 0.1};
    shots[i].world = static_cast<uint32_t>(i % 5);
  }
  return shots;
}

/// A simulator with worlds, and the scans and batches that it must make again after each failure.
class BatchSubject {
 public:
  explicit BatchSubject(DeviceChoice::Kind kind, uint32_t triangles = 40)
      : simulator(scatteredWorlds(triangles),
                  {{gridSensor(60, 8, -20, 20), Effects::none(), {}},
                   {gridSensor(40, 4, -20, 20), Effects::none(), {Field::classId, Field::normal}}},
                  optionsFor(kind)) {
    remember();
  }
  static SimulatorOptions optionsFor(DeviceChoice::Kind kind) {
    SimulatorOptions options;
    options.cache = "off";
    options.device.kind = kind;
    return options;
  }
  void remember() { expected_ = results(); }
  void check() { CHECK(results() == expected_); }

  Simulator simulator;
  std::vector<Shot> shots = shotsOf(9, 0);

 private:
  template <typename T>
  static void append(std::string& bytes, std::span<const T> values) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  static void append(std::string& bytes, const Scan& scan) {
    append<float>(bytes, scan.ranges);
    append<uint32_t>(bytes, scan.triangles);
    append<uint32_t>(bytes, scan.instances);
    for (uint32_t axis = 0; scan.has(Field::normal) && axis < 3; ++axis)
      for (const float value : scan.column<float>(Field::normal, axis)) append<float>(bytes, {&value, 1});
    bytes += std::to_string(scan.counters.triangles) + " " + std::to_string(scan.counters.hits) + ";";
  }
  // Single scans of every world come first and last, because they and batches use some arrays in turn.
  std::string results() {
    std::string bytes;
    const auto scanAlone = [&] {
      for (size_t i = 0; i < 10; ++i) {
        Scan scan;
        Shot shot = shots[i % 5];
        shot.sensor = i / 5;
        simulator.scanInto(shot, scan);
        append(bytes, scan);
      }
    };
    scanAlone();
    const Batch batch = simulator.scanBatch(shots);
    append<float>(bytes, batch.ranges());
    append<uint32_t>(bytes, batch.triangles());
    append<uint32_t>(bytes, batch.instances());
    bytes += std::to_string(batch.counters.triangles) + " " + std::to_string(batch.counters.hits);
    scanAlone();
    return bytes;
  }

  std::string expected_;
};

}  // namespace

TEST_CASE("without memory a batch is empty, and the next one is as before", "[combinations]") {
  const DeviceChoice::Kind kind = everyKind();
  BatchSubject subject(kind);
  Simulator& simulator = subject.simulator;
  std::vector<Shot> ofOther = subject.shots;
  for (Shot& shot : ofOther) shot.sensor = 1;
  Batch batch;
  bool whole = true;  // a batch that fails is empty
  const auto into = [&](std::span<const Shot> shots, std::span<const Field> fields) {
    try {
      simulator.scanBatchInto(shots, batch, fields);
    } catch (...) {
      whole = whole && batch.entries() == 0 && batch.views == 0;
      throw;
    }
  };
  size_t received = 0;  // scans, in the order of their shots
  const auto receive = [&](size_t shot, const Scan&) {
    whole = whole && shot == received;
    ++received;
  };
  const auto check = [&] {
    CHECK(whole);
    received = 0;
    subject.check();
  };
  const Field hits[] = {Field::triangle, Field::instance};
  failEach(nameOf(kind, "scanBatchInto"), Fails::memory, {[&] { into(subject.shots, {}); }, {}, check});
  failEach(nameOf(kind, "scanBatchInto, of hits"), Fails::memory, {[&] { into(subject.shots, hits); }, {}, check});
  failEach(nameOf(kind, "scanBatchInto, with fields"), Fails::memory, {[&] { into(ofOther, {}); }, {}, check});
  failEach(
      nameOf(kind, "scanAll"), Fails::memory,
      {[&] { simulator.scanAll(subject.shots, receive); }, [&] { CHECK(received == subject.shots.size()); }, check});
}

TEST_CASE("without memory many instances are moved together or not at all", "[combinations]") {
  const DeviceChoice::Kind kind = everyKind();
  BatchSubject subject(kind);
  Simulator& simulator = subject.simulator;
  std::vector<uint32_t> moved;
  std::vector<double> there, back;
  for (uint32_t i = 1; i < 20; ++i) {
    moved.push_back(i);
    const Transform from = scatteredWorlds().instances[i].transform, to = translation(i, 3, 1) * from;
    back.insert(back.end(), std::begin(from.rows), std::end(from.rows));
    there.insert(there.end(), std::begin(to.rows), std::end(to.rows));
  }
  const std::vector<float> single(there.begin(), there.end());
  const auto undo = [&] { simulator.setTransforms(moved, back); };
  const auto check = [&] { subject.check(); };
  failEach(nameOf(kind, "setTransforms"), Fails::memory, {[&] { simulator.setTransforms(moved, there); }, undo, check});
  failEach(nameOf(kind, "setTransforms, of floats"), Fails::memory,
           {[&] { simulator.setTransforms(moved, single); }, undo, check});

  std::vector<Instance> instances(10);
  for (uint32_t i = 0; i < 10; ++i) instances[i] = {"", i % 2, translation(2 * i, 5, 0), 0, "", i % 6};
  std::vector<uint32_t> added;
  const auto remove = [&] {
    for (size_t i = added.size(); i > 0; --i) simulator.removeInstance(added[i - 1]);
  };
  failEach(nameOf(kind, "addInstances"), Fails::memory,
           {[&] { added = simulator.addInstances(instances); }, remove, check});
  const Scene scene = scatteredWorlds();
  const std::vector<Instance> same(scene.instances.begin() + 1, scene.instances.begin() + 20);  // those of `moved`
  failEach(nameOf(kind, "removeInstances"), Fails::memory,
           {[&] { simulator.removeInstances(moved); }, [&] { CHECK(simulator.addInstances(same) == moved); }, check});
  failEach(nameOf(kind, "plan"), Fails::memory, {[&] { (void)simulator.plan(1); }, {}, check});
}

TEST_CASE("without memory of the device scans and batches fail, and the next ones are as before", "[combinations]") {
  needVulkan();
  // Arrays that have grown stay large, so each trial begins with a new simulator, in whose memory the one before has
  // left other numbers of triangles.
  std::optional<BatchSubject> subject;
  uint32_t trials = 0;
  const auto next = [&] { subject.emplace(DeviceChoice::Kind::vulkan, 30 + 5 * (++trials % 3)); };
  const auto each = [&](const char* name, const std::function<void(Simulator&)>& call,
                        const std::function<void(Simulator&)>& undo) {
    next();
    failEach("vulkan: " + std::string(name) + ", memory of the device", Fails::device,
             {[&] { call(subject->simulator); }, [&] { undo(subject->simulator); },
              [&] {
                subject->check();
                next();
              }});
  };
  const std::vector<Shot> many = shotsOf(60, 1);
  const auto nothing = [](Simulator&) {};
  each(
      "scanBatch", [&](Simulator& simulator) { (void)simulator.scanBatch(many); }, nothing);
  each(
      "scanAll", [&](Simulator& simulator) { simulator.scanAll(many, [](size_t, const Scan&) {}); }, nothing);
  const std::vector<Instance> instances(400, Instance{"", 1, translation(3, 3, 0)});
  std::vector<uint32_t> added;
  each(
      "scanInto, more instances",
      [&](Simulator& simulator) {
        added = simulator.addInstances(instances);
        Scan scan;
        try {
          simulator.scanInto(many[0], scan);
        } catch (const Error&) {
          for (size_t i = added.size(); i > 0; --i) simulator.removeInstance(added[i - 1]);
          throw;
        }
      },
      [&](Simulator& simulator) {
        for (size_t i = added.size(); i > 0; --i) simulator.removeInstance(added[i - 1]);
      });
  size_t index = 0;
  each(
      "addSensor",
      [&](Simulator& simulator) {
        index = simulator.addSensor({gridSensor(70, 8, -10, 10), Effects(), {Field::intensity}});
      },
      [&](Simulator& simulator) { simulator.removeSensor(index); });
  each(
      "addMesh", [&](Simulator& simulator) { index = simulator.addMesh(soup(8, 20'000, 1, 0.1)); },
      [&](Simulator& simulator) { simulator.removeMesh(index); });
}

TEST_CASE("without memory of the device a simulator is not made, and the next one is") {
  needVulkan();
  const Scene scene = scatteredWorlds();
  const SensorRequest request = {gridSensor(60, 8, -20, 20), Effects::none(), {}};
  const SimulatorOptions options = BatchSubject::optionsFor(DeviceChoice::Kind::vulkan);
  const Scan expected = Simulator(scene, request, options).scan({});
  failEach("vulkan: Simulator, memory of the device", Fails::device,
           {[&] { Simulator(scene, request, options); },
            {},
            [&] {
              const Scan scan = Simulator(scene, request, options).scan({});
              CHECK(sameBytes(scan, expected));
            }});
}

}  // namespace gnosphere::test
