// SPDX-License-Identifier: Apache-2.0
// Meshes whose vertices follow joints and morph targets.
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

#include "deformable.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

Sensor head() {
  return gridSensor(360, 24, -30, 30, 60);
}

}  // namespace

TEST_CASE("deformed vertices lie where the formulas of glTF put them", "[deform]") {
  for (const uint32_t influences : {0u, 1u, 4u, 9u}) {
    Random random(17 + influences);
    const Mesh mesh = limb(random, 7, influences, influences == 4 ? 0 : 2, {1e4, -2e4, 30});
    for (int k = 0; k < 5; ++k) {
      const Deformation deformation = bend(random, mesh);
      const std::vector<float> positions = deformedPositions(mesh, deformation);
      const std::vector<Vec3> expected = expectedPositions(mesh, deformation);
      REQUIRE(positions.size() == 3 * expected.size());
      double worst = 0;
      for (size_t v = 0; v < expected.size(); ++v)
        worst = std::max({worst, std::abs(mesh.origin.x + positions[3 * v] - expected[v].x),
                          std::abs(mesh.origin.y + positions[3 * v + 1] - expected[v].y),
                          std::abs(mesh.origin.z + positions[3 * v + 2] - expected[v].z)});
      INFO(influences << " influences: " << worst << " m");
      REQUIRE(worst < 3e-6);  // the mesh is 4 m long
    }
    REQUIRE(deformedPositions(mesh, {}) == mesh.positions);
  }
}

TEST_CASE("deformed meshes are scanned where they are", "[deform][gpu]") {
  needVulkan();
  for (const Accuracy accuracy : {Accuracy::standard, Accuracy::exact}) {
    Random random(5);
    Scene scene = limbs(random, 6);
    TestOptions options = vulkanOptions(), reference;
    options.accuracy = reference.accuracy = accuracy;
    reference.device = DeviceChoice::Kind::reference;
    Simulator device = makeSimulator(scene, head(), options), truth = makeSimulator(scene, head(), reference);
    for (int frame = 0; frame < 4; ++frame) {
      INFO("accuracy " << nameOf(accuracy) << ", frame " << frame);
      const Pose pose = {{0.3 * frame, 0.1, 0.2}, {}};
      const Scan scan = device.scan(pose), expected = truth.scan(pose);
      requireSame(expected, scan);
      REQUIRE(scan.counters.hits > 500);
      REQUIRE(sameBytes(scan, Simulator(scene, {head(), Effects::none()}, options).scan(pose)));
      for (size_t mesh = 1; mesh < scene.meshes.size(); ++mesh) {
        if (frame == 2 && mesh == 3) continue;
        scene.meshes[mesh].deformation = frame == 1 && mesh == 4 ? Deformation() : bend(random, scene.meshes[mesh]);
        device.setDeformation(mesh, scene.meshes[mesh].deformation);
        truth.setDeformation(mesh, scene.meshes[mesh].deformation);
      }
    }
  }
}

TEST_CASE("a deformation that does not fit its mesh is refused", "[deform]") {
  using Catch::Matchers::ContainsSubstring;
  using Catch::Matchers::MessageMatches;
  Random random(3);
  Scene scene = limbs(random, 1);
  const Mesh good = scene.meshes[1];
  TestOptions options;
  options.device = DeviceChoice::Kind::reference;
  const auto refused = [&](const Scene& given, const char* words) {
    REQUIRE_THROWS_MATCHES(makeSimulator(given, head(), options), Error, MessageMatches(ContainsSubstring(words)));
  };
  const auto with = [&](auto change) {
    Scene changed = scene;
    change(changed.meshes[1]);
    return changed;
  };
  refused(with([](Mesh& mesh) { mesh.joints[5] = 99; }), "a vertex follows joint 99, the mesh has");
  refused(with([](Mesh& mesh) { mesh.jointWeights[0] += 0.5f; }), "sum to 1.5");
  refused(with([](Mesh& mesh) { mesh.jointWeights[0] = -1; }), "is negative or NaN");
  refused(with([](Mesh& mesh) { mesh.joints.pop_back(); }), "joints and weights, there are");
  refused(with([](Mesh& mesh) { mesh.influences = 0; }), "both must be 0 or both more");
  refused(with([](Mesh& mesh) { mesh.morphTargets[0].pop_back(); }), "morph target 0 has");
  refused(with([](Mesh& mesh) { mesh.deformation.joints.resize(2); }), "its deformation has 2 joints");
  Simulator simulator = makeSimulator(scene, head(), options);
  Deformation deformation = bend(random, good);
  deformation.joints[1].rows[3] = std::numeric_limits<double>::infinity();
  REQUIRE_THROWS_MATCHES(simulator.setDeformation(1, deformation), Error,
                         MessageMatches(ContainsSubstring("mesh 1: the map of joint 1 is not finite")));
  REQUIRE_THROWS_MATCHES(simulator.setDeformation(0, {}), Error,
                         MessageMatches(ContainsSubstring("mesh 0 has neither joints nor morph targets")));
  REQUIRE_THROWS_MATCHES(simulator.setPositions(1, good.positions), Error,
                         MessageMatches(ContainsSubstring("setDeformation() moves it")));
}
