// SPDX-License-Identifier: Apache-2.0
// Deformable meshes and animations in the C interface, against those of C++.
#include <gnosphere.h>

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cstring>
#include <gnosphere/animation.hpp>
#include <gnosphere/gnosphere.hpp>

#include "c/fails.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

Transform moved(double x, double y, double z) {
  return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}

/// An upright strip 5 m before the sensor, whose upper half follows a second joint, with a morph target that widens it;
/// and a wall behind it. The clip bends the strip, widens it and lifts it.
Scene stripScene() {
  Mesh strip, wall;
  strip.name = "strip";
  strip.positions = {0, -1, 0, 0, 1, 0, 0, -1, 1, 0, 1, 1, 0, -1, 2, 0, 1, 2};
  strip.indices = {0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5};
  strip.parts = {{0, 4, 0}};
  strip.jointCount = strip.influences = 2;
  strip.joints = {0, 1, 0, 1, 0, 1, 0, 1, 1, 0, 1, 0};
  strip.jointWeights = {1, 0, 1, 0, 0.5f, 0.5f, 0.5f, 0.5f, 1, 0, 1, 0};
  strip.morphTargets = {{0, -1, 0, 0, 1, 0, 0, -1, 0, 0, 1, 0, 0, -1, 0, 0, 1, 0}};
  strip.deformation = {{{}, moved(0.5, 0, 0)}, {0.25f}};
  wall.positions = {9, -9, -3, 9, 9, -3, 9, 9, 6, 9, -9, 6};
  wall.indices = {0, 1, 2, 0, 2, 3};
  wall.parts = {{0, 2, 0}};
  Scene scene;
  scene.materials = {{}};
  scene.meshes = {strip, wall};
  scene.instances = {{"strip", 0, moved(5, 0, 0), 3}, {"wall", 1, {}, 4}};
  Node place, hip, knee, fixed;
  place.name = "place";
  place.morphWeights = {0.5f};
  hip.translation = {0, 0, 0.1};
  knee.parent = 1;
  knee.translation = {0, 0, 1};
  knee.rotation = {0, 0.3, 0, 1};
  fixed.matrix = moved(1, 2, 3);
  const Skin skin = {"skin", {1, 2}, {{}, moved(0, 0, -1)}};
  Track bend = {2, Track::Property::rotation, Track::Interpolation::linear, {0, 1}, {0, 0, 0, 1, 0, 0.4f, 0, 1}};
  Track widen = {0, Track::Property::morphWeights, Track::Interpolation::step, {0, 0.5f}, {0, 1}};
  Track lift = {1, Track::Property::translation, Track::Interpolation::cubic, {0, 1}, {}};
  lift.values = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0};
  scene.animation = {moved(5, 0, 0), {place, hip, knee, fixed}, {skin}, {{"wave", 1, {bend, widen, lift}}}, {}};
  scene.animation.instances = {{0, 0, 0, {}}};
  return scene;
}

gno_transform inC(const Transform& transform) {
  gno_transform result;
  std::copy_n(transform.rows.begin(), 12, result.rows);
  return result;
}

bool same(const gno_transform& c, const Transform& transform) {
  return std::memcmp(c.rows, transform.rows.data(), sizeof c.rows) == 0;
}

template <class T>
bool same(const T* c, size_t count, const std::vector<T>& values) {
  return count == values.size() && std::equal(values.begin(), values.end(), c);
}

/// A deformation for C; it points into this and into the C++ one.
struct DeformationInC {
  explicit DeformationInC(const Deformation& from) {
    for (const Transform& joint : from.joints) joints.push_back(inC(joint));
    deformation = {joints.data(), joints.size(), from.morphWeights.data(), from.morphWeights.size()};
  }
  std::vector<gno_transform> joints;
  gno_deformation deformation;
};

bool same(const gno_deformation& c, const Deformation& deformation) {
  bool equal = c.joint_count == deformation.joints.size() &&
               same(c.morph_weights, c.morph_weight_count, deformation.morphWeights);
  for (size_t i = 0; equal && i < c.joint_count; ++i) equal = same(c.joints[i], deformation.joints[i]);
  return equal;
}

void addMesh(gno_scene scene, const Mesh& from) {
  const DeformationInC deformation(from.deformation);
  std::vector<const float*> targets;
  for (const auto& target : from.morphTargets) targets.push_back(target.data());
  gno_mesh mesh = gno_mesh_init();
  mesh.name = from.name.c_str();
  mesh.positions = from.positions.data();
  mesh.vertex_count = from.vertexCount();
  mesh.indices = from.indices.data();
  mesh.triangle_count = from.triangleCount();
  mesh.joint_count = from.jointCount;
  mesh.influences = from.influences;
  mesh.joints = from.joints.data();
  mesh.joint_weights = from.jointWeights.data();
  mesh.morph_targets = targets.data();
  mesh.morph_target_count = targets.size();
  mesh.deformation = deformation.deformation;
  REQUIRE(gno_scene_add_mesh(scene, &mesh, nullptr) == GNO_OK);
}

void addAnimation(gno_scene scene, const SceneAnimation& from) {
  const gno_transform root = inC(from.root);
  REQUIRE(gno_scene_set_animation_root(scene, &root) == GNO_OK);
  for (const Node& each : from.nodes) {
    gno_node node = gno_node_init();
    gno_transform matrix = {};
    node.name = each.name.c_str();
    node.parent = each.parent;
    node.translation[2] = each.translation.z;
    node.rotation[1] = each.rotation.y;
    if (each.matrix) {
      matrix = inC(*each.matrix);
      node.matrix = &matrix;
    }
    node.morph_weights = each.morphWeights.data();
    node.morph_weight_count = each.morphWeights.size();
    REQUIRE(gno_scene_add_node(scene, &node, nullptr) == GNO_OK);
  }
  const gno_transform binds[] = {inC(from.skins[0].inverseBinds[0]), inC(from.skins[0].inverseBinds[1])};
  gno_skin skin = gno_skin_init();
  skin.name = from.skins[0].name.c_str();
  skin.joints = from.skins[0].joints.data();
  skin.inverse_binds = binds;
  skin.joint_count = 2;
  REQUIRE(gno_scene_add_skin(scene, &skin, nullptr) == GNO_OK);
  std::vector<gno_track> tracks;
  for (const Track& track : from.clips[0].tracks)
    tracks.push_back({track.node, static_cast<gno_track_property>(track.property),
                      static_cast<gno_interpolation>(track.interpolation), track.times.data(), track.times.size(),
                      track.values.data(), track.values.size()});
  gno_clip clip = gno_clip_init();
  clip.name = from.clips[0].name.c_str();
  clip.duration = from.clips[0].duration;
  clip.tracks = tracks.data();
  clip.track_count = tracks.size();
  uint32_t index = 7;
  REQUIRE(gno_scene_add_clip(scene, &clip, &index) == GNO_OK);
  CHECK(index == 0);
  gno_animated_instance animated = gno_animated_instance_init();
  animated.skin = 0;
  REQUIRE(gno_scene_add_animated_instance(scene, &animated, nullptr) == GNO_OK);
}

gno_scene sceneInC(const Scene& from) {
  gno_scene scene = nullptr;
  REQUIRE(gno_scene_create(&scene) == GNO_OK);
  const gno_material material = gno_material_init();
  REQUIRE(gno_scene_add_material(scene, &material, nullptr) == GNO_OK);
  for (const Mesh& mesh : from.meshes) addMesh(scene, mesh);
  for (const Instance& each : from.instances) {
    gno_instance instance = gno_instance_init();
    instance.mesh = each.mesh;
    instance.class_id = each.classId;
    instance.transform = inC(each.transform);
    REQUIRE(gno_scene_add_instance(scene, &instance, nullptr) == GNO_OK);
  }
  addAnimation(scene, from.animation);
  return scene;
}

}  // namespace

TEST_CASE("C: what goes into a scene's meshes, nodes, skins and clips comes out again") {
  const Scene expected = stripScene();
  const gno_scene scene = sceneInC(expected);
  gno_scene_counts counts = gno_scene_counts_init();
  REQUIRE(gno_scene_get_counts(scene, &counts) == GNO_OK);
  CHECK((counts.nodes == 4 && counts.skins == 1 && counts.clips == 1 && counts.animated_instances == 1));
  gno_mesh mesh = gno_mesh_init();
  REQUIRE(gno_scene_get_mesh(scene, 0, &mesh) == GNO_OK);
  const Mesh& strip = expected.meshes[0];
  CHECK((mesh.joint_count == 2 && mesh.influences == 2 && mesh.morph_target_count == 1));
  CHECK(same(mesh.joints, 12, strip.joints));
  CHECK(same(mesh.joint_weights, 12, strip.jointWeights));
  CHECK(same(mesh.morph_targets[0], 18, strip.morphTargets[0]));
  CHECK(same(mesh.deformation, strip.deformation));

  for (size_t i = 0; i < 4; ++i) {
    gno_node node = gno_node_init();
    REQUIRE(gno_scene_get_node(scene, i, &node) == GNO_OK);
    const Node& from = expected.animation.nodes[i];
    CHECK((node.name == from.name && node.parent == from.parent));
    CHECK((node.translation[2] == from.translation.z && node.rotation[1] == from.rotation.y && node.scale[0] == 1));
    CHECK((node.matrix != nullptr) == from.matrix.has_value());
    if (node.matrix) CHECK(same(*node.matrix, *from.matrix));
    CHECK(same(node.morph_weights, node.morph_weight_count, from.morphWeights));
  }
  gno_skin skin = gno_skin_init();
  REQUIRE(gno_scene_get_skin(scene, 0, &skin) == GNO_OK);
  CHECK(same(skin.joints, skin.joint_count, expected.animation.skins[0].joints));
  CHECK(same(skin.inverse_binds[1], expected.animation.skins[0].inverseBinds[1]));
  gno_clip clip = gno_clip_init();
  REQUIRE(gno_scene_get_clip(scene, 0, &clip) == GNO_OK);
  REQUIRE((clip.track_count == 3 && clip.duration == 1));
  for (size_t i = 0; i < 3; ++i) {
    const Track& from = expected.animation.clips[0].tracks[i];
    CHECK((clip.tracks[i].node == from.node && clip.tracks[i].property == static_cast<int32_t>(from.property)));
    CHECK(clip.tracks[i].interpolation == static_cast<int32_t>(from.interpolation));
    CHECK(same(clip.tracks[i].times, clip.tracks[i].key_count, from.times));
    CHECK(same(clip.tracks[i].values, clip.tracks[i].value_count, from.values));
  }
  gno_animated_instance animated = gno_animated_instance_init();
  REQUIRE(gno_scene_get_animated_instance(scene, 0, &animated) == GNO_OK);
  CHECK((animated.instance == 0 && animated.node == 0 && animated.skin == 0 && same(animated.offset, {})));
  gno_transform root = {};
  REQUIRE(gno_scene_get_animation_root(scene, &root) == GNO_OK);
  CHECK(same(root, expected.animation.root));
  const char* lines = nullptr;
  REQUIRE(gno_scene_get_left_out(scene, &lines) == GNO_OK);
  CHECK(std::string(lines).empty());
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}

TEST_CASE("C: an animated scene scans as it does in C++, between scans and during one") {
  const Scene from = stripScene();
  const gno_scene scene = sceneInC(from);
  uint32_t clip = 7;
  REQUIRE(gno_scene_find_clip(scene, "wave", &clip) == GNO_OK);
  gno_request request = gno_request_init();
  REQUIRE(gno_sensor_builtin("VLP-16", &request.sensor) == GNO_OK);
  gno_sensor_settings settings = gno_sensor_settings_init();
  REQUIRE(gno_sensor_get_settings(request.sensor, &settings) == GNO_OK);
  settings.rotation_period = 0.1;
  REQUIRE(gno_sensor_set_settings(request.sensor, &settings) == GNO_OK);
  REQUIRE(gno_effects_preset("clean", &request.effects) == GNO_OK);
  REQUIRE(gno_effects_assign(request.effects, "object-motion=on") == GNO_OK);
  gno_options options = gno_options_init();
  options.device = "reference";
  gno_simulator simulator = nullptr;
  REQUIRE(gno_simulator_create(scene, &request, 1, &options, &simulator) == GNO_OK);
  SensorRequest wanted(builtinSensor("VLP-16"), Effects::none());
  wanted.sensor.rotationPeriod = 0.1;
  wanted.effects.objectMotion.use = EffectUse::on;
  SimulatorOptions reference;
  reference.device = DeviceChoice::Kind::reference;
  Simulator expected(from, wanted, reference);

  gno_scan scan = nullptr;
  std::vector<std::vector<float>> clouds;
  for (const double seconds : {-1.0, 0.0, 0.3, 0.8}) {
    INFO("at " << seconds << " s");
    const bool rest = seconds < 0;
    const SceneState at = stateAt(from, rest ? Clip() : clipNamed(from, "wave"), seconds);
    gno_scene_state state = gno_scene_state_init();
    REQUIRE(gno_scene_get_state(scene, rest ? GNO_NONE : clip, seconds, GNO_CLIP_LOOP, &state) == GNO_OK);
    REQUIRE((state.transform_count == 2 && state.deformation_count == 2));
    for (size_t i = 0; i < 2; ++i) {
      CHECK(same(state.transforms[i], at.transforms[i]));
      CHECK(same(state.deformations[i], at.deformations[i]));
    }
    std::vector<float> positions(18);
    REQUIRE(gno_scene_get_deformed_positions(scene, 0, &state.deformations[0], positions.data(), 6) == GNO_OK);
    CHECK(positions == deformedPositions(from.meshes[0], at.deformations[0]));
    REQUIRE(gno_simulator_set_deformation(simulator, 0, &state.deformations[0]) == GNO_OK);
    expected.setDeformation(0, at.deformations[0]);

    const DeformationInC end(from.meshes[0].deformation);
    const gno_mesh_motion motion = {0, end.deformation};
    gno_shot shot = gno_shot_init();
    Shot same;
    if (!rest) {
      shot.mesh_motions = &motion;
      shot.mesh_motion_count = 1;
      same.meshMotions = {{0, from.meshes[0].deformation}};
    }
    shot.pose.position[2] = same.pose.position.z = 1;
    REQUIRE(gno_simulator_scan(simulator, &shot, &scan) == GNO_OK);
    Scan cloud;
    expected.scanInto(same, cloud);
    gno_column ranges = gno_column_init();
    REQUIRE(gno_scan_get_column(scan, GNO_FIELD_RANGE, &ranges) == GNO_OK);
    REQUIRE(ranges.entries == cloud.ranges.size());
    CHECK(std::memcmp(ranges.values, cloud.ranges.data(), 4 * ranges.entries) == 0);
    for (const auto& other : clouds) CHECK(std::memcmp(other.data(), cloud.ranges.data(), 4 * other.size()) != 0);
    clouds.push_back(cloud.ranges);
  }
  REQUIRE(gno_simulator_set_deformation(simulator, 0, nullptr) == GNO_OK);
  std::vector<float> positions(18);
  REQUIRE(gno_scene_get_deformed_positions(scene, 0, nullptr, positions.data(), 6) == GNO_OK);
  CHECK(positions == deformedPositions(from.meshes[0], from.meshes[0].deformation));
  for (gno_status status :
       {gno_scan_destroy(scan), gno_simulator_destroy(simulator), gno_effects_destroy(request.effects),
        gno_sensor_destroy(request.sensor), gno_scene_destroy(scene)})
    CHECK(status == GNO_OK);
}

TEST_CASE("C: animations and deformations that do not fit are errors that say so") {
  const gno_scene scene = sceneInC(stripScene());
  gno_scene_state state = gno_scene_state_init();
  uint32_t index = 0;
  const gno_deformation none = {}, morph = {nullptr, 0, nullptr, 1};
  std::vector<float> positions(18);
  CHECK(fails(gno_scene_find_clip(scene, "wav", &index), "no clip is called 'wav'"));
  CHECK(fails(gno_scene_find_clip(scene, nullptr, &index), "name is null"));
  CHECK(fails(gno_scene_get_state(scene, 1, 0, GNO_CLIP_LOOP, &state), "clip 1 does not exist"));
  CHECK(fails(gno_scene_get_state(scene, 0, 0, 2, &state), "the end of the clip is 2"));
  CHECK(fails(gno_scene_get_state(scene, 0, 0.0 / 0.0, GNO_CLIP_HOLD, &state), "must be finite"));
  CHECK(fails(gno_scene_get_deformed_positions(scene, 0, &morph, positions.data(), 6), "morph_weights is null"));
  CHECK(fails(gno_scene_get_deformed_positions(scene, 0, nullptr, positions.data(), 5), "has 6 vertices, not 5"));
  CHECK(fails(gno_scene_get_deformed_positions(scene, 2, &none, positions.data(), 6), "mesh 2 does not exist"));
  REQUIRE(gno_scene_get_state(scene, 0, 0, GNO_CLIP_LOOP, &state) == GNO_OK);
  gno_deformation lost = state.deformations[0];
  REQUIRE(lost.joint_count > 0);
  std::vector<gno_transform> joints(lost.joints, lost.joints + lost.joint_count);
  joints[0].rows[3] = 0.0 / 0.0;
  lost.joints = joints.data();
  CHECK(fails(gno_scene_get_deformed_positions(scene, 0, &lost, positions.data(), 6), "is not finite"));
  const float weight = 1;
  const gno_deformation half = {nullptr, 0, &weight, 1};
  CHECK(fails(gno_scene_get_deformed_positions(scene, 0, &half, positions.data(), 6), "0 joints and 1 morph weights"));
  gno_clip clip = gno_clip_init();
  const gno_track track = {9, 4, GNO_INTERPOLATION_LINEAR, nullptr, 0, nullptr, 0};
  clip.tracks = &track;
  clip.track_count = 1;
  CHECK(fails(gno_scene_add_clip(scene, &clip, nullptr), "gno_track::property is 4"));
  gno_mesh mesh = gno_mesh_init();
  const float* target = nullptr;
  mesh.positions = positions.data();
  mesh.vertex_count = 6;
  mesh.morph_targets = &target;
  mesh.morph_target_count = 1;
  CHECK(fails(gno_scene_add_mesh(scene, &mesh, nullptr), "a target of gno_mesh::morph_targets is null"));

  // A scene that is not valid is never looked at.
  gno_animated_instance animated = gno_animated_instance_init();
  animated.instance = 77;
  REQUIRE(gno_scene_get_state(scene, 0, 0, GNO_CLIP_LOOP, &state) == GNO_OK);
  REQUIRE(gno_scene_add_animated_instance(scene, &animated, nullptr) == GNO_OK);
  CHECK(fails(gno_scene_get_state(scene, 0, 0, GNO_CLIP_LOOP, &state), "77"));
  double low[3], high[3];
  CHECK(fails(gno_scene_get_bounds(scene, low, high), "77"));
  CHECK(gno_scene_destroy(scene) == GNO_OK);
}
