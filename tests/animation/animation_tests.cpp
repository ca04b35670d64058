// SPDX-License-Identifier: Apache-2.0
// Skins, morph targets and animations of glTF: what is read, and where things are at a time.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <set>

#include "animation/made_model.hpp"
#include "base/vector.hpp"
#include "geometry/dropped_triangles.hpp"
#include "gnosphere/animation.hpp"
#include "problem.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

const float kHalf = std::sqrt(0.5f);

void checkNear(const Points& got, const Points& expected, double within = 1e-6) {
  REQUIRE(got.size() == expected.size());
  for (size_t i = 0; i < got.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      INFO("point " << i << ", component " << c << ": " << got[i][c] << ", expected " << expected[i][c]);
      CHECK(std::abs(got[i][c] - expected[i][c]) < within);
    }
}

/// Where the triangle's corner (1,0,0) is.
Points corner(const Scene& scene, double time, ClipEnd end = ClipEnd::loop) {
  return {vertices(scene, time, end)[1]};
}

/// Keys of t^3 - 2t in every component, times 1, -1 and 2, with their slopes: a cubic is its own cubic spline.
Floats cubicKeys(const Floats& times) {
  Floats keys;
  for (const float t : times) {
    const float value = t * t * t - 2 * t, slope = 3 * t * t - 2;
    for (const float part : {slope, value, slope}) keys.insert(keys.end(), {part, -part, 2 * part});
  }
  return keys;
}

}  // namespace

TEST_CASE("translations: a step holds its key, a line goes straight, a cubic is exact") {
  const Floats times = {0.5f, 1, 2.5f};
  const auto load = [&](const char* interpolation, const Floats& values) {
    GltfFileMaker file = animatedFile();
    addChannel(file, 0, "translation", interpolation, times, values);
    return file.load();
  };
  const Scene step = load("STEP", {1, 2, 3, 4, 5, 6, 7, 8, 9}), line = load("LINEAR", {1, 2, 3, 4, 5, 6, 7, 8, 9});
  REQUIRE(step.animation.clips.size() == 1);
  CHECK(step.animation.clips[0].name == "clip");
  CHECK(step.animation.clips[0].duration == 2.5);
  GltfFileMaker two = animatedFile();  // the longer of two channels is as long as the clip
  addChannel(two, 0, "translation", "STEP", times, Floats{1, 2, 3, 4, 5, 6, 7, 8, 9});
  addChannel(two, 0, "scale", "STEP", {0, 1}, Floats{1, 1, 1, 2, 2, 2});
  CHECK(two.load().animation.clips.at(0).duration == 2.5);
  for (const Scene* scene : {&step, &line}) {
    checkNear(corner(*scene, 0), {{2, 2, 3}});    // before the first key
    checkNear(corner(*scene, 0.5), {{2, 2, 3}});  // at keys
    checkNear(corner(*scene, 1), {{5, 5, 6}});
    checkNear(corner(*scene, 9, ClipEnd::hold), {{8, 8, 9}});
    checkNear(corner(*scene, -9, ClipEnd::hold), {{2, 2, 3}});
  }
  checkNear(corner(step, 0.99), {{2, 2, 3}});
  checkNear(corner(step, 2.49), {{5, 5, 6}});
  checkNear(corner(line, 0.75), {{3.5, 3.5, 4.5}});
  checkNear(corner(line, 1.5), {{6, 6, 7}});
  // Clips also loop before their start.
  checkNear(corner(line, 2.5 + 1.5), {{6, 6, 7}});
  checkNear(corner(line, 5 + 0.75), {{3.5, 3.5, 4.5}});
  checkNear(corner(line, -1), {{6, 6, 7}});
  const Scene cubic = load("CUBICSPLINE", cubicKeys(times));
  for (const double t : {0.5, 0.7, 1.0, 1.3, 2.0, 2.4}) {
    const double f = t * t * t - 2 * t;
    INFO("time " << t);
    checkNear(corner(cubic, t), {{1 + f, -f, 2 * f}}, 2e-6);
  }
}

TEST_CASE("rotations turn by the shorter way, and by the stored one if they are cubic") {
  const auto load = [&](const char* interpolation, const Floats& values) {
    GltfFileMaker file = animatedFile();
    addChannel(file, 0, "rotation", interpolation, {0, 3}, values);
    return file.load();
  };
  // From 0 to 90 degrees about z; the second quaternion has the opposite sign.
  const Scene line = load("LINEAR", {0, 0, 0, 1, 0, 0, -kHalf, -kHalf});
  for (const double t : {0.0, 1.0, 2.0, 2.9}) {
    const double angle = t / 3 * M_PI / 2;
    checkNear(corner(line, t), {{std::cos(angle), std::sin(angle), 0}});
  }
  checkNear(corner(load("STEP", {0, 0, 0, 1, 0, 0, kHalf, kHalf}), 2.9), {{1, 0, 0}});
  // The slopes are 0 but for one of x, y, z, w = 0, 0, 1, 0 after the first key. At half the time the spline is
  // (a + b) / 2 + 3 s * 1/8.
  const Scene cubic = load("CUBICSPLINE", {0, 0, 0, 0, 0, 0, 0,     1,     0, 0, 1, 0,  //
                                           0, 0, 0, 0, 0, 0, kHalf, kHalf, 0, 0, 0, 0});
  const double z = 0.5 * std::sqrt(0.5) + 3.0 / 8, w = 0.5 * (1 + std::sqrt(0.5)), angle = 2 * std::atan2(z, w);
  checkNear(corner(cubic, 1.5), {{std::cos(angle), std::sin(angle), 0}});
  // Quaternions as normalised 16-bit integers.
  GltfFileMaker file = animatedFile();
  addChannel(file, 0, "rotation", "LINEAR", {0, 3}, std::vector<int16_t>{0, 0, 0, 32767, 0, 0, 23170, 23170},
             {{"normalized", true}});
  checkNear(corner(file.load(), 1.5), {{std::cos(M_PI / 4), std::sin(M_PI / 4), 0}}, 1e-4);
}

TEST_CASE("scales and parents: a clip moves everything below a node, and nothing else") {
  GltfFileMaker file = animatedFile();
  file.json["nodes"] = {{{"mesh", 0}, {"translation", {0, 0, 5}}},
                        {{"name", "arm"}, {"children", {0}}, {"scale", {1, 1, 1}}},
                        {{"name", "still"}, {"mesh", 0}, {"translation", {7, 0, 0}}}};
  addChannel(file, 1, "scale", "LINEAR", {0, 1}, Floats{1, 1, 1, 3, -1, 2});
  const Scene scene = file.load();
  const auto moved = vertices(scene, 0.5);
  checkNear({moved[1], moved[2]}, {{2, 0, 7.5}, {0, 0, 7.5}});
  checkNear({vertices(scene, 0.5, ClipEnd::loop, 1)[1]}, {{8, 0, 0}});
  REQUIRE(scene.animation.instances.size() == 1);
  CHECK(scene.meshes.size() == 1);
  // y-up files are turned, and scaled.
  const Scene turned = file.load({UpAxis::y, 10});
  checkNear({vertices(turned, 0.5)[1]}, {{20, -75, 0}}, 1e-5);
  checkNear(vertices(turned, stateAt(turned, {}, 0)), {{0, -50, 0}, {10, -50, 0}, {0, -50, 10}});
}

TEST_CASE("morph targets: weights of nodes and clips, sparse offsets, one mesh per node that deforms it") {
  GltfFileMaker file = animatedFile();
  const int first = file.accessor(Floats{0, 0, 1, 0, 0, 2, 0, 0, 3}, "VEC3");
  const int indices = file.view(bytesOf(std::vector<uint16_t>{2})), values = file.view(bytesOf(Floats{8, 0, 0}));
  const int second = file.push("accessors", {{"componentType", 5126},
                                             {"count", 3},
                                             {"type", "VEC3"},
                                             {"sparse",
                                              {{"count", 1},
                                               {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                               {"values", {{"bufferView", values}}}}}});
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", first}}, {{"POSITION", second}}};
  file.json["meshes"][0]["weights"] = {0.5, 0};
  file.node({{"mesh", 0}, {"weights", {0, 1}}, {"translation", {0, 0, 10}}});
  addChannel(file, 0, "weights", "LINEAR", {0, 2}, Floats{0, 0, 1, 0.5f});
  const Scene scene = file.load();
  REQUIRE(scene.meshes.size() == 2);
  CHECK(scene.instances[0].mesh == 0);
  CHECK(scene.instances[1].mesh == 1);
  // At rest, which is also what is loaded.
  checkNear(vertices(scene, stateAt(scene, {}, 0)), {{0, 0, 0.5}, {1, 0, 1}, {0, 1, 1.5}});
  checkNear(vertices(scene, stateAt(scene, {}, 0), 1), {{0, 0, 10}, {1, 0, 10}, {8, 1, 10}});
  CHECK(scene.meshes[0].deformation.morphWeights == Floats{0.5f, 0});
  CHECK(scene.meshes[1].deformation.morphWeights == Floats{0, 1});
  checkNear(vertices(scene, 1), {{0, 0, 0.5}, {1, 0, 1}, {2, 1, 1.5}});
  checkNear(vertices(scene, 1, ClipEnd::loop, 1), {{0, 0, 10}, {1, 0, 10}, {8, 1, 10}});
  const Bounds bounds = worldBounds(scene);
  CHECK(bounds.max.x == 8);
  // Morph targets may open a triangle with equal corners, so it is not dropped.
  Scene closed = scene;
  std::copy_n(scene.meshes[0].positions.begin(), 3, closed.meshes[0].positions.begin() + 3);
  CHECK(droppedTriangles(closed).degenerate == 0);
  closed.meshes[0].morphTargets.clear();
  CHECK(droppedTriangles(closed).degenerate == 1);

  GltfFileMaker cubic = animatedFile();
  cubic.json["meshes"][0]["primitives"][0]["targets"] = {
      {{"POSITION", cubic.accessor(Floats{0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")}}};
  addChannel(cubic, 0, "weights", "CUBICSPLINE", {0, 2}, Floats{0, 0, 0, 12, 8, 12});  // t^3: slopes 0 and 12
  for (const double t : {0.5, 1.0, 1.5}) checkNear({vertices(cubic.load(), t)[0]}, {{0, 0, t * t * t}});
}

TEST_CASE("a skinned mesh follows its joints and not its node") {
  GltfFileMaker file = skinnedFile();
  // The knee turns to 90 degrees about z.
  addChannel(file, 2, "rotation", "LINEAR", {0, 1}, Floats{0, 0, 0, 1, 0, 0, kHalf, kHalf});
  addChannel(file, 1, "translation", "LINEAR", {0, 1}, Floats{0, 0, 0, 0, 0, 4});
  const Scene scene = file.load();
  REQUIRE(scene.meshes.size() == 1);
  CHECK(scene.meshes[0].jointCount == 2);
  CHECK(scene.meshes[0].influences == 4);
  const Points bound = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {2, 1, 0}};
  checkNear(vertices(scene, stateAt(scene, {}, 0)), bound);
  CHECK(sameBytes(vertices(scene, stateAt(scene, {}, 0)), vertices(scene, 0)));
  // With c and s of the angle, the knee maps (x, y) to (1 + c (x - 1) - s y, s (x - 1) + c y).
  for (const double t : {0.25, 0.5, 0.999}) {
    const double c = std::cos(t * M_PI / 2), s = std::sin(t * M_PI / 2), z = 4 * t;
    checkNear(vertices(scene, t),
              {{0, 0, z}, {0, 1, z}, {1, 0, z}, {1 - s / 2, 0.5 + c / 2, z}, {1 + c, s, z}, {1 + c - s, s + c, z}});
  }
  // Scaled and y-up: (x, y, z) becomes (x, -z, y).
  const Scene turned = file.load({UpAxis::y, 100});
  const auto there = vertices(turned, 0.5);
  checkNear({there[4]}, {{100 * (1 + std::sqrt(0.5)), -200, 100 * std::sqrt(0.5)}}, 1e-4);
}

TEST_CASE("weights: normalised integers, several sets, none at all, and primitives without joints") {
  GltfFileMaker file = skinnedFile();
  Json& primitives = file.json["meshes"][0]["primitives"];
  // Set 0 has no weight; set 1 has what set 0 had, as unsigned bytes, and one vertex has none.
  const int joints = file.accessor(std::vector<uint16_t>(24, 1), "VEC4");
  const int empty = file.accessor(std::vector<uint8_t>(24, 0), "VEC4", {{"normalized", true}});
  const int weights = file.accessor(std::vector<uint8_t>{255, 0, 0, 0, 0, 0, 0, 0, 127, 127, 0, 0,  //
                                                         1,   1, 0, 0, 9, 0, 0, 0, 0,   200, 0, 0},
                                    "VEC4", {{"normalized", true}});
  primitives[0]["attributes"]["JOINTS_1"] = primitives[0]["attributes"]["JOINTS_0"];
  primitives[0]["attributes"]["WEIGHTS_1"] = weights;
  primitives[0]["attributes"]["JOINTS_0"] = joints;
  primitives[0]["attributes"]["WEIGHTS_0"] = empty;
  // A second primitive without joints: it stays at its node.
  const int rigid = file.accessor(Floats{0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  primitives.push_back({{"attributes", {{"POSITION", rigid}}}});
  addChannel(file, 2, "rotation", "LINEAR", {0, 1}, Floats{0, 0, 0, 1, 0, 0, kHalf, kHalf});
  const Scene scene = file.load();
  validate(scene);
  REQUIRE(scene.meshes.at(0).influences == 8);
  CHECK(scene.meshes[0].jointCount == 3);
  REQUIRE(scene.leftOut.size() == 1);
  CHECK_THAT(scene.leftOut[0], ContainsSubstring("1 vertices whose joint weights are all 0"));
  const double h = std::sqrt(0.5);
  checkNear(vertices(scene, 0.5),
            {{0, 0, 0},
             {0, 1, 0},
             {1, 0, 0},
             {1 - h / 2, 0.5 + h / 2, 0},
             {1 + h, h, 0},
             {1, 2 * h, 0},
             {100, 200, 300},
             {101, 200, 300},
             {100, 201, 300}},
            2e-5);
}

TEST_CASE("a skinned mesh under a mirrored node shows the same side, also after it was written") {
  GltfFileMaker file = skinnedFile();
  const Scene plain = file.load();
  std::set<size_t> roots;
  for (size_t i = 0; i < file.json["nodes"].size(); ++i) roots.insert(i);
  for (const Json& node : file.json["nodes"])
    for (const Json& child : node.value("children", Json::array())) roots.erase(child.get<size_t>());
  file.node({{"name", "mirror"}, {"scale", {1, 1, -1}}, {"children", roots}});
  file.json["scenes"] = {{{"nodes", {file.json["nodes"].size() - 1}}}};
  const Scene mirrored = file.load();
  const Folder folder;
  writeGlb(mirrored, folder / "out.glb");
  const Scene again = loadScene(folder / "out.glb", kAsStored);
  /// The normal of a triangle in the world, times its area.
  const auto normalOf = [](const Scene& scene, size_t triangle) {
    const Mesh& mesh = scene.meshes[scene.instances[0].mesh];
    const std::vector<float> positions = deformedPositions(mesh, mesh.deformation);
    const auto corner = [&](size_t k) {
      const float* p = &positions[3 * size_t{mesh.indices[3 * triangle + k]}];
      return scene.instances[0].transform * Vec3{mesh.origin.x + p[0], mesh.origin.y + p[1], mesh.origin.z + p[2]};
    };
    const Vec3 a = corner(0), u = corner(1) - a, v = corner(2) - a;
    return cross(u, v);
  };
  for (size_t t = 0; t < plain.meshes[0].triangleCount(); ++t) {
    // A mirror at z = 0 keeps x and y of an outward normal, and turns z.
    const Vec3 n = normalOf(plain, t), m = normalOf(mirrored, t);
    CHECK(std::abs(m.x - (n.x)) < 1e-6);
    CHECK(std::abs(m.y - (n.y)) < 1e-6);
    CHECK(std::abs(m.z - (-n.z)) < 1e-6);
  }
  REQUIRE(again.meshes.size() == mirrored.meshes.size());
  CHECK(again.meshes[0].indices == mirrored.meshes[0].indices);
}

TEST_CASE("nodes that skin one mesh have a mesh each, and a node without a skin places it as it is") {
  GltfFileMaker file = skinnedFile();
  file.json["skins"].push_back(file.json["skins"][0]);
  file.json["skins"][1]["joints"] = {3, 4};
  file.node({{"children", {4}}, {"translation", {0, 0, 50}}});
  file.node({{"translation", {1, 0, 0}}});
  file.node({{"name", "other"}, {"mesh", 0}, {"skin", 1}});
  file.node({{"name", "plain"}, {"mesh", 0}, {"translation", {0, 9, 0}}});
  addChannel(file, 4, "rotation", "STEP", {0}, Floats{0, 0, kHalf, kHalf});
  const Scene scene = file.load();
  validate(scene);
  REQUIRE(scene.instances.size() == 3);
  REQUIRE(scene.meshes.size() == 3);
  const SceneState state = stateAt(scene, scene.animation.clips[0], 0);
  checkNear({vertices(scene, state, 0)[5]}, {{2, 1, 0}});
  checkNear({vertices(scene, state, 1)[5]}, {{0, 1, 50}});
  checkNear({vertices(scene, state, 2)[5]}, {{2, 10, 0}});
  CHECK_FALSE(scene.meshes[scene.instances[2].mesh].deformable());
}

TEST_CASE("a skinned person 5,000 km from the origin keeps the millimetres") {
  GltfFileMaker file = skinnedFile();
  file.json["nodes"][1]["translation"] = {5206123.456, 0, 0};
  addChannel(file, 2, "rotation", "STEP", {0}, Floats{0, 0, kHalf, kHalf});
  const Scene scene = file.load();
  checkNear({vertices(scene, 0)[5]}, {{5206123.456, 1, 0}}, 1e-6);
}

TEST_CASE("what a file says about motion and is not done is counted") {
  GltfFileMaker file = animatedFile();
  Json& animation = file.json["animations"][0];
  addChannel(file, 0, "translation", "LINEAR", {0}, Floats{1, 2, 3});
  for (const char* path : {"pointer", "pointer"})
    animation["channels"].push_back({{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}});
  animation["channels"].push_back({{"sampler", 0}, {"target", {{"path", "scale"}}}});
  animation["channels"].push_back({{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}});
  file.node({{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
  animation["channels"].push_back({{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}});
  file.json["skins"] = {{{"joints", {0}}}};
  file.node({{"mesh", 0}, {"skin", 0}});
  CHECK(file.load().leftOut ==
        std::vector<std::string>{
            "1 animation channels for morph weights of a node that places no mesh with morph targets",
            "2 animation channels that move 'pointer'", "1 animation channels that move a node with a matrix",
            "1 animation channels without a node", "1 nodes that ignore their skin, because their mesh has no joints"});
}

TEST_CASE("mistakes in skins and animations are told with their place") {
  const auto refused = [](GltfFileMaker file, const std::function<void(Json&)>& change, const char* words) {
    addChannel(file, 2, "rotation", "LINEAR", {0, 1}, Floats{0, 0, 0, 1, 0, 0, 0, 1});
    change(file.json);
    CHECK_THAT(file.failure(), ContainsSubstring(words));
  };
  const GltfFileMaker file = skinnedFile();
  const auto animation = [](Json& json) -> Json& { return json["animations"][0]; };
  refused(
      file, [](Json& j) { j["nodes"][0]["skin"] = 7; }, "node 0 'strip': skin 7 does not exist");
  refused(
      file,
      [](Json& j) {
        j["skins"][0]["joints"] = {1, 77};
      },
      "skin 0: node 77 does not exist");
  refused(
      file, [](Json& j) { j["skins"][0]["joints"] = {1}; }, "a vertex of its mesh follows joint 1, its skin has 1");
  refused(
      file,
      [](Json& j) {
        j["skins"][0]["joints"] = {1, 2, 2};
      },
      "2 inverse bind matrices for 3 joints");
  refused(
      file, [](Json& j) { j["skins"][0].erase("joints"); }, "skins[0]: joints is missing");
  refused(
      file, [](Json& j) { j["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0"); },
      "has JOINTS_0 without WEIGHTS_0");
  refused(
      file, [](Json& j) { j["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = 0; }, "joints is not VEC4");
  refused(
      file, [](Json& j) { j["skins"][0]["joints"] = Json::array(); },
      "node 0 'strip': its skin has 0 joints; it must have 1 to 65535");
  refused(
      file,
      [](Json& j) {
        j["nodes"][1]["scale"] = {1e200, 1, 1}, j["nodes"][2]["scale"] = {1e200, 1, 1};
      },
      "a joint is not at a finite place");
  refused(
      file,
      [](Json& j) {
        Json& attributes = j["meshes"][0]["primitives"][0]["attributes"];
        for (const std::string set : {"1", "2", "3", "4"}) {
          attributes["JOINTS_" + set] = attributes["JOINTS_0"];
          attributes["WEIGHTS_" + set] = attributes["WEIGHTS_0"];
        }
      },
      "node 0 'strip': a vertex of its mesh follows up to 20 joints; the limit is 16");
  refused(
      file, [&](Json& j) { animation(j)["channels"][0]["target"]["node"] = 9; },
      "animation 0 'clip', channel 0: node 9 does not exist");
  refused(
      file, [&](Json& j) { animation(j)["channels"][0]["sampler"] = 1; }, "sampler 1 does not exist");
  refused(
      file, [&](Json& j) { animation(j)["samplers"][0]["interpolation"] = "CUBIC"; },
      "interpolation 'CUBIC' is not STEP, LINEAR or CUBICSPLINE");
  refused(
      file, [&](Json& j) { animation(j)["samplers"][0]["interpolation"] = "CUBICSPLINE"; },
      "2 keys of 12 numbers need 24, there are 8");
  refused(
      file, [&](Json& j) { animation(j)["channels"].push_back(animation(j)["channels"][0]); },
      "channel 1 moves what another channel of the animation moves");
  GltfFileMaker backwards = skinnedFile();
  addChannel(backwards, 1, "translation", "LINEAR", {1, 0}, Floats(6));
  CHECK_THAT(backwards.failure(), ContainsSubstring("its times do not ascend"));
  GltfFileMaker few = skinnedFile();
  few.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = few.accessor(Floats(20, 1), "VEC4");
  CHECK_THAT(few.failure(), ContainsSubstring("has weights for 5 vertices, there are 6"));
  GltfFileMaker odd = skinnedFile();
  odd.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = odd.accessor(Floats(24, 0.5f), "VEC4");
  CHECK_THAT(odd.failure(), ContainsSubstring("a joint of JOINTS_0 is 0.5"));
  GltfFileMaker bound = skinnedFile();
  bound.json["skins"][0]["inverseBindMatrices"] = bound.accessor(Floats(32, NAN), "MAT4");
  CHECK_THAT(bound.failure(), ContainsSubstring("an inverse bind matrix is not finite"));
  bound.json["skins"][0]["inverseBindMatrices"] = 0;
  CHECK_THAT(bound.failure(), ContainsSubstring("accessor 0 must have 16 components"));
  GltfFileMaker negative = skinnedFile();
  negative.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = negative.accessor(Floats(24, -1), "VEC4");
  CHECK_THAT(negative.failure(), ContainsSubstring("a weight of WEIGHTS_0 is -1"));
}

TEST_CASE("whatever loads is valid: rotations of length 0, weights without targets, a cutoff beyond the floats") {
  const GltfFileMaker plain = skinnedFile();
  const Json cutOut = {{"alphaMode", "MASK"}, {"alphaCutoff", 1e300}};
  const std::vector<std::pair<const char*, Json>> changes = {{"/nodes/2/rotation", Json::array({0, 0, 0, 0})},
                                                             {"/nodes/0/weights", Json::array({0.5})},
                                                             {"/materials", Json::array({cutOut})}};
  for (const auto& [pointer, value] : changes) {
    INFO(pointer);
    GltfFileMaker file = plain;
    file.json[Json::json_pointer(pointer)] = value;
    const Scene scene = file.load();
    CHECK_NOTHROW(validate(scene));
    checkNear(vertices(scene, stateAt(scene, {}, 0)),
              {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {2, 1, 0}});
  }
}

TEST_CASE("many nodes whose skins have many joints are more than a small file may unpack to") {
  GltfFileMaker file = skinnedFile();
  file.json["skins"] = {{{"joints", std::vector<int>(65535, 1)}}};
  file.load();
  for (int i = 0; i < 60; ++i) file.node({{"mesh", 0}, {"skin", 0}});
  CHECK_THAT(file.failure(), ContainsSubstring("65535 elements are more than a file of"));
}

TEST_CASE("clips are found by name, and a wrong name gets the nearest") {
  GltfFileMaker file = animatedFile();
  for (const char* name : {"Walk", "Run", "", "Idle"})
    file.json["animations"].push_back({{"name", name}, {"channels", Json::array()}, {"samplers", Json::array()}});
  const Scene scene = file.load();
  CHECK(&clipNamed(scene, "Run") == &scene.animation.clips[2]);
  CHECK(&clipNamed(scene, "3") == &scene.animation.clips[3]);  // without a name: its number
  CHECK_THAT(problemOf([&] { clipNamed(scene, "Wlak"); }),
             ContainsSubstring("no clip is called 'Wlak'; the nearest are Walk"));
}

TEST_CASE("a clip of another scene is refused where it moves a node that the scene does not have") {
  Scene scene;
  scene.animation.nodes.resize(2);
  Clip clip;
  clip.name = "walk";
  clip.duration = 1;
  clip.tracks = {{1, Track::Property::translation, Track::Interpolation::step, {0}, {1, 2, 3}}};
  CHECK_NOTHROW(stateAt(scene, clip, 0));
  clip.tracks[0].node = 2;
  CHECK(problemOf([&] { stateAt(scene, clip, 0); }, ErrorCode::invalidArgument) ==
        "the clip 'walk' moves node 2, and the scene has 2; take a clip of this scene");
}

TEST_CASE("a clip whose name another clip has is found by its number") {
  GltfFileMaker file = animatedFile();
  for (const char* name : {"Walk", "3", "Walk", "Idle"})
    file.json["animations"].push_back({{"name", name}, {"channels", Json::array()}, {"samplers", Json::array()}});
  const Scene scene = file.load();
  CHECK_THAT(problemOf([&] { clipNamed(scene, "Walk"); }),
             ContainsSubstring("2 clips are called 'Walk'; choose one by its number, such as 1 or 3"));
  CHECK(&clipNamed(scene, "1") == &scene.animation.clips[1]);
  CHECK(&clipNamed(scene, "3") == &scene.animation.clips[2]);  // a name goes before a number
  CHECK(&clipNamed(scene, "4") == &scene.animation.clips[4]);
  for (const char* name : {"5", "-1", "1.0", "01x"})
    CHECK_THAT(problemOf([&] { clipNamed(scene, name); }), ContainsSubstring("no clip is called"));
}

TEST_CASE("copies of a mesh that several nodes deform count for what a file may unpack to") {
  // Accessors without bytes are zeros. Of 256 MiB the mesh takes two thirds, and a copy of it more than the rest.
  GltfFileMaker file;
  for (int i = 0; i < 2; ++i) file.push("accessors", {{"componentType", 5126}, {"count", 3'600'000}, {"type", "VEC3"}});
  file.mesh({{"attributes", {{"POSITION", 0}}}, {"targets", {{{"POSITION", 1}}}}});
  file.node({{"mesh", 0}});
  CHECK(file.load().meshes.size() == 1);
  file.node({{"mesh", 0}});
  CHECK_THAT(file.failure(), ContainsSubstring("mesh 0: ") && ContainsSubstring(" elements are more than a file of "));
}

TEST_CASE("an animation that does not fit its scene is refused") {
  GltfFileMaker file = skinnedFile();
  addChannel(file, 2, "rotation", "LINEAR", {0, 1}, Floats{0, 0, 0, 1, 0, 0, 0, 1});
  const Scene good = file.load();
  validate(good);
  const auto refused = [&](const std::function<void(Scene&)>& change, const char* words) {
    Scene scene = good;
    change(scene);
    CHECK_THAT(problemOf([&] { validate(scene); }), ContainsSubstring(words));
  };
  refused([](Scene& s) { s.animation.nodes[1].parent = 2; }, "parents come before their children");
  refused([](Scene& s) { s.animation.nodes[1].scale.x = NAN; }, "are not finite");
  refused([](Scene& s) { s.animation.skins[0].joints[1] = 9; }, "node 9 does not exist, there are 3");
  refused([](Scene& s) { s.animation.skins[0].inverseBinds.pop_back(); }, "2 joints and 1 inverse bind maps");
  refused([](Scene& s) { s.animation.instances[0].instance = 4; }, "instance 4 does not exist");
  refused([](Scene& s) { s.animation.instances[0].skin = kNoSkin; }, "its skin has 0 joints, its mesh has 2");
  refused([](Scene& s) { s.animation.instances[0].offset.rows[0] = 0; }, "has no inverse");
  refused([](Scene& s) { s.animation.clips[0].tracks[0].times = {1, 0}; }, "do not ascend from 0 or later");
  refused([](Scene& s) { s.animation.clips[0].tracks[0].times = {-1, 0}; }, "do not ascend from 0 or later");
  refused([](Scene& s) { s.animation.clips[0].tracks.push_back(s.animation.clips[0].tracks[0]); },
          "track 1: another track of the clip moves the same property of node 2");
  refused([](Scene& s) { s.animation.clips[0].tracks[0].values.pop_back(); }, "2 keys of 4 numbers need 8");
  refused([](Scene& s) { s.animation.clips[0].tracks[0].node = 5; }, "node 5 does not exist");
  refused([](Scene& s) { s.animation.clips[0].tracks[0].times = s.animation.clips[0].tracks[0].values = {}; },
          "it has no keys");
  refused([](Scene& s) { s.animation.clips[0].tracks[0].values[5] = NAN; }, "a value is not finite");
  refused([](Scene& s) { s.animation.nodes[2].matrix = Transform(); }, "has a matrix, so nothing moves it");
  refused([](Scene& s) { s.animation.nodes[1].rotation = {0, 0, 0, 0}; }, "its rotation is a quaternion of length 0");
  refused([](Scene& s) { s.animation.skins[0].inverseBinds[1].rows[3] = NAN; }, "inverse bind map is not finite");
  refused([](Scene& s) { s.animation.root.rows[3] = INFINITY; }, "the transform above all nodes is not finite");
  refused([](Scene& s) { s.animation.instances[0].node = 3; }, "node 3 does not exist, there are 3");
  refused([](Scene& s) { s.animation.instances[0].skin = 1; }, "skin 1 does not exist, there are 1");
  refused([](Scene& s) { s.animation.instances.push_back(s.animation.instances[0]); },
          "another one is instance 0, too");
  refused([](Scene& s) { s.animation.nodes[s.animation.instances[0].node].morphWeights = {1}; },
          "its node has 1 morph weights, its mesh has 0 targets");
  refused([](Scene& s) { s.animation.clips[0].duration = -1; }, "its duration is not 0 or more");
  refused(
      [](Scene& s) {
        s.animation.clips[0].tracks[0] = {2, Track::Property::morphWeights, Track::Interpolation::step, {0}, {1}};
      },
      "node 2 ('knee') places no mesh with morph targets");
  refused(
      [](Scene& s) {
        s.instances.push_back(s.instances[0]);
        s.animation.instances.push_back({1, 1, 0, {}});
      },
      "already follows another node or skin");
}

TEST_CASE("an animated scene is the same after it was written and read") {
  GltfFileMaker file = skinnedFile();
  file.json["skins"][0]["name"] = "legs";
  file.json["nodes"][2]["rotation"] = {0, 0, kHalf, kHalf};
  addChannel(file, 2, "rotation", "LINEAR", {0, 1}, Floats{0, 0, 0, 1, 0, 0, kHalf, kHalf});
  addChannel(file, 1, "translation", "STEP", {0, 0.5f}, Floats{0, 0, 0, 0, 0, 4});
  const int positions = file.accessor(Floats{0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  const int offsets = file.accessor(Floats{0, 0, 1, 0, 0, 2, 0, 0, 3}, "VEC3");
  file.mesh({{"attributes", {{"POSITION", positions}}}, {"targets", {{{"POSITION", offsets}}}}});
  file.mesh({{"attributes", {{"POSITION", positions}}}});
  file.node({{"name", "soft"}, {"mesh", 1}, {"weights", {0.5}}, {"translation", {0, 0, 9}}, {"children", {4}}});
  file.node({{"name", "rigid"}, {"mesh", 2}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1}}});
  file.node({{"name", "still"}, {"mesh", 2}, {"translation", {0, 0, -9}}});
  addChannel(file, 3, "weights", "LINEAR", {0, 1}, Floats{0, 1});
  addChannel(file, 3, "scale", "CUBICSPLINE", {0, 1}, Floats{0, 0, 0, 1, 1, 1, 1, 0, 2, 0, 1, 0, 2, 3, 4, 0, 0, 0});
  Scene scene = file.load({UpAxis::y, 2});
  for (Mesh& mesh : scene.meshes) {
    mesh.origin = {3, -2, 5};
    for (size_t i = 0; i < mesh.positions.size(); i += 3) {
      mesh.positions[i] -= 3;
      mesh.positions[i + 1] += 2;
      mesh.positions[i + 2] -= 5;
    }
  }
  const Folder folder;
  writeGlb(scene, folder / "out.glb");
  const Scene again = loadScene(folder / "out.glb");
  validate(again);
  CHECK(again.leftOut.empty());
  REQUIRE(again.animation.clips.size() == 1);
  CHECK(again.animation.clips[0].name == "clip");
  REQUIRE(again.animation.skins.size() == 1);
  CHECK(again.animation.skins[0].name == "legs");
  for (const char* name : {"hip", "knee"}) CHECK(std::ranges::count(again.animation.nodes, name, &Node::name) == 1);
  REQUIRE(scene.instances.size() == 4);
  REQUIRE(again.instances.size() == 4);
  for (size_t i = 0; i < 4; ++i) {
    INFO(scene.instances[i].name);
    CHECK(again.instances[i].name == scene.instances[i].name);
    checkNear(vertices(again, stateAt(again, {}, 0), i), vertices(scene, stateAt(scene, {}, 0), i), 1e-5);
    for (const double time : {0.0, 0.3, 0.7})
      checkNear(vertices(again, time, ClipEnd::loop, i), vertices(scene, time, ClipEnd::loop, i), 1e-5);
  }
  for (const double duration : {0.6, 1.5}) {  // the last key is at 1
    Scene other = scene;
    other.animation.clips[0].duration = duration;
    writeGlb(other, folder / "other.glb");
    const Scene read = loadScene(folder / "other.glb");
    CHECK(read.animation.clips.at(0).duration == duration);
    checkNear(vertices(read, 1.7), vertices(other, 1.7), 1e-5);
  }
  // A clip that moves nothing stays, too, and the others keep their numbers.
  Scene idle = scene;
  idle.animation.clips.insert(idle.animation.clips.begin(), Clip{"idle", 2.5, {}});
  writeGlb(idle, folder / "idle.glb");
  const Scene idleAgain = loadScene(folder / "idle.glb");
  CHECK(idleAgain.leftOut.empty());
  REQUIRE(idleAgain.animation.clips.size() == 2);
  CHECK(idleAgain.animation.clips[0].name == "idle");
  CHECK(idleAgain.animation.clips[0].duration == 2.5);
  CHECK(idleAgain.animation.clips[0].tracks.empty());
  CHECK(idleAgain.animation.clips[1].name == "clip");
  // Maps of a skin are floats in a file.
  Scene huge = scene;
  for (Skin& skin : huge.animation.skins) skin.inverseBinds[0].rows[3] = 1e39;
  CHECK_THAT(problemOf([&] { writeGlb(huge, folder / "huge.glb"); }),
             ContainsSubstring(": an inverse bind map is beyond single precision, which glTF has"));
  // An instance that nothing moves, of a mesh that joints move for another one, stays as it is.
  Scene two = scene;
  two.instances.push_back({"statue", two.instances[0].mesh, {{0, -1, 0, 50, 1, 0, 0, 0, 0, 0, 1, 7}}});
  writeGlb(two, folder / "two.glb");
  const Scene bothAgain = loadScene(folder / "two.glb");
  REQUIRE(bothAgain.instances.size() == 5);
  checkNear(vertices(bothAgain, 0.7), vertices(scene, 0.7), 1e-5);
  checkNear(vertices(bothAgain, 0.7, ClipEnd::loop, 4), vertices(two, stateAt(two, {}, 0), 4), 1e-5);
  // Without what moves it, a deformed mesh is written as it is.
  const Points posed = vertices(scene, 0.7);
  const SceneState state = stateAt(scene, scene.animation.clips[0], 0.7);
  scene.meshes[scene.instances[0].mesh].deformation = state.deformations[scene.instances[0].mesh];
  scene.animation = {};
  writeGlb(scene, folder / "still.glb");
  const Scene still = loadScene(folder / "still.glb");
  CHECK(still.animation.nodes.empty());
  checkNear(vertices(still, stateAt(still, {}, 0)), posed, 1e-5);
}

TEST_CASE("animated models of GNOSPHERE_SCENES: the device sees what the reference sees", "[.][gpu][scenes]") {
  const char* folder = std::getenv("GNOSPHERE_SCENES");
  if (folder == nullptr) SKIP("GNOSPHERE_SCENES names no folder");
  needVulkan();
  size_t models = 0, hits = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".glb") continue;
    Scene scene;
    try {
      scene = loadScene(entry.path());
    } catch (const Error&) {
      continue;
    }
    if (scene.animation.clips.empty()) continue;
    ++models;
    TestOptions options = vulkanOptions(), reference;
    reference.device = DeviceChoice::Kind::reference;
    const Sensor head = gridSensor(360, 48, -40, 40, 1e4);
    Simulator device = makeSimulator(scene, head, options), truth = makeSimulator(scene, head, reference);
    const Bounds box = worldBounds(scene);
    const double size = std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
    for (size_t i = 0; i < 4; ++i) {
      const Clip& clip = scene.animation.clips[i * scene.animation.clips.size() / 4];
      const SceneState state = stateAt(scene, clip, clip.duration * (0.1 + 0.25 * static_cast<double>(i)));
      for (Simulator* simulator : {&device, &truth}) {
        for (size_t k = 0; k < state.transforms.size(); ++k) simulator->setTransform(k, state.transforms[k]);
        for (size_t k = 0; k < state.deformations.size(); ++k)
          if (scene.meshes[k].deformable()) simulator->setDeformation(k, state.deformations[k]);
      }
      const Pose pose = {{box.max.x + 0.7 * size, (box.min.y + box.max.y) / 2, (box.min.z + box.max.z) / 2}, {}};
      INFO(entry.path().filename() << ", clip " << clip.name);
      const Scan scan = device.scan(pose);
      requireSame(truth.scan(pose), scan);
      hits += scan.counters.hits;
    }
    WARN(entry.path().filename() << ": " << hits << " hits so far");
  }
  CHECK(models >= 3);
  CHECK(hits > 1000);
}
