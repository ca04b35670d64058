// SPDX-License-Identifier: Apache-2.0
// Two scenes that become one: the parts refer to each other as before, and clips move what they moved.
#include <cmath>
#include <limits>

#include "animation/made_model.hpp"
#include "gnosphere/animation.hpp"
#include "problem.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

const Transform kPlace = {{0, -2, 0, 5, 2, 0, 0, -3, 0, 0, 2, 1}};

Scene square() {
  MeshBuilder builder;
  builder.quad({2, -1, -1}, {0, 2, 0}, {0, 0, 2}, 1);
  return sceneOf(builder.take());
}

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Checks that an instance of `both` is where that of `one` is after `place`.
void checkSamePlace(const Scene& both, const SceneState& bothState, size_t bothInstance, const Scene& one,
                    const SceneState& state, size_t instance, const Transform& place) {
  const Points got = vertices(both, bothState, bothInstance), expected = vertices(one, state, instance);
  REQUIRE(got.size() == expected.size());
  for (size_t v = 0; v < got.size(); ++v) {
    const auto [x, y, z] = expected[v];
    CHECK(distance(got[v], at(place, x, y, z)) < 1e-5);
  }
}

/// A skinned strip whose knee turns, y-up and scaled, so that its root is no identity.
Scene bending() {
  GltfFileMaker file = skinnedFile();
  addChannel(file, 2, "rotation", "LINEAR", {0, 1}, Floats{0, 0, 0, 1, 0, 0, std::sqrt(0.5f), std::sqrt(0.5f)});
  return file.load({UpAxis::y, 3});
}

/// A triangle below an arm that moves.
Scene swinging() {
  GltfFileMaker file = animatedFile();
  file.json["nodes"] = {{{"mesh", 0}, {"translation", {0, 0, 5}}}, {{"name", "arm"}, {"children", {0}}}};
  addChannel(file, 1, "translation", "LINEAR", {0, 1}, Floats{0, 0, 0, 3, -1, 2});
  return file.load();
}

}  // namespace

TEST_CASE("clips of joined scenes move what they moved in their own, and nothing else") {
  const Scene still = square();
  for (const bool bendsFirst : {false, true}) {
    const Scene first = bendsFirst ? bending() : swinging(), second = bendsFirst ? swinging() : bending();
    const Scene both = joined(joined(still, first), second, kPlace);
    validate(both);
    REQUIRE(both.animation.clips.size() == 2);
    CHECK(both.animation.nodes.size() == first.animation.nodes.size() + second.animation.nodes.size() + 1);
    const SceneState rest = stateAt(both, {}, 0), firstMoves = stateAt(both, both.animation.clips[0], 0.4),
                     secondMoves = stateAt(both, both.animation.clips[1], 0.4);
    const SceneState firstRest = stateAt(first, {}, 0), firstMoved = stateAt(first, first.animation.clips[0], 0.4),
                     secondRest = stateAt(second, {}, 0), secondMoved = stateAt(second, second.animation.clips[0], 0.4);
    for (const SceneState* state : {&rest, &firstMoves, &secondMoves})
      checkSamePlace(both, *state, 0, still, stateAt(still, {}, 0), 0, {});
    checkSamePlace(both, rest, 1, first, firstRest, 0, {});
    checkSamePlace(both, rest, 2, second, secondRest, 0, kPlace);
    checkSamePlace(both, firstMoves, 1, first, firstMoved, 0, {});
    checkSamePlace(both, firstMoves, 2, second, secondRest, 0, kPlace);
    checkSamePlace(both, secondMoves, 1, first, firstRest, 0, {});
    checkSamePlace(both, secondMoves, 2, second, secondMoved, 0, kPlace);
    CHECK(distance(vertices(first, firstMoved).back(), vertices(first, firstRest).back()) > 0.1);
  }
}

TEST_CASE("materials and images of joined scenes stay with their triangles") {
  Scene first = square(), second = square();
  first.materials[0].name = "road";
  first.leftOut = {"one"};
  second.materials = {{}, {}};
  second.materials[1].name = "leaf";
  second.materials[1].alphaMode = AlphaMode::mask;
  second.materials[1].alphaImage = 0;
  second.alphaImages = {{1, 1, {7}}};
  second.meshes[0].parts[0].material = 1;
  second.meshes[0].uvs.resize(2 * second.meshes[0].vertexCount());
  second.instances[0].classId = 4;
  second.instances[0].world = 2;
  second.leftOut = {"two"};
  first.unreadImages = 1;
  second.unreadImages = 2;
  const Scene both = joined(joined(first, second), second, kPlace);
  validate(both);
  CHECK(both.materials[both.meshes[0].parts[0].material].name == "road");
  for (const size_t i : {1u, 2u}) {
    CHECK(both.instances[i].mesh == i);
    CHECK(both.instances[i].classId == 4);
    CHECK(both.instances[i].world == 2);
    const Material& leaf = both.materials[both.meshes[i].parts[0].material];
    CHECK(leaf.name == "leaf");
    CHECK(leaf.alphaImage == i - 1);
  }
  CHECK(both.instances[1].transform.rows == Transform().rows);
  CHECK(both.instances[2].transform.rows == kPlace.rows);
  CHECK(both.leftOut == std::vector<std::string>{"one", "two", "two"});
  CHECK(both.unreadImages == 5);
}

TEST_CASE("a scene that is wrong, or a place that is not finite, is not joined") {
  Scene wrong = square();
  wrong.instances[0].mesh = 9;
  const std::string problem = "instance 0: mesh 9 does not exist, the scene has 1";
  CHECK(problemOf([&] { joined({}, wrong); }) == "joined: `other`: " + problem);
  // The meshes of the other scene must not become those that a wrong index of the first one means.
  CHECK(problemOf([&] { joined(wrong, square()); }) == "joined: `scene`: " + problem);
  Transform nowhere;
  nowhere.rows[3] = std::numeric_limits<double>::quiet_NaN();
  CHECK(problemOf([&] { joined({}, square(), nowhere); }) == "joined: the transform is not finite");
}
