// SPDX-License-Identifier: Apache-2.0
// gno_scene: nodes, skins and clips, and the state of the scene at a time.
#include <algorithm>
#include <array>
#include <gnosphere/animation.hpp>

#include "c/handles.hpp"

namespace gnosphere::c {
namespace {

GNO_SAME_ENUM(Track::Property, {GNO_TRACK_TRANSLATION, translation}, {GNO_TRACK_ROTATION, rotation},
              {GNO_TRACK_SCALE, scale}, {GNO_TRACK_MORPH_WEIGHTS, morphWeights});
GNO_SAME_ENUM(Track::Interpolation, {GNO_INTERPOLATION_STEP, step}, {GNO_INTERPOLATION_LINEAR, linear},
              {GNO_INTERPOLATION_CUBIC, cubic});
GNO_SAME_ENUM(ClipEnd, {GNO_CLIP_LOOP, loop}, {GNO_CLIP_HOLD, hold});

Node nodeOf(const gno_node* node) {
  const gno_node& from = sized(node, GNO_TYPE(gno_node));
  const auto& q = from.rotation;
  Node result;
  result.name = orEmpty(from.name);
  result.parent = from.parent;
  result.translation = vec3(from.translation);
  result.rotation = {q[0], q[1], q[2], q[3]};
  result.scale = vec3(from.scale);
  if (from.matrix) result.matrix = transformOf(*from.matrix);
  const auto weights = array(from.morph_weights, from.morph_weight_count, "gno_node::morph_weights");
  result.morphWeights.assign(weights.begin(), weights.end());
  return result;
}

Skin skinOf(const gno_skin* skin) {
  const gno_skin& from = sized(skin, GNO_TYPE(gno_skin));
  const auto joints = array(from.joints, from.joint_count, "gno_skin::joints");
  Skin result;
  result.name = orEmpty(from.name);
  result.joints.assign(joints.begin(), joints.end());
  for (const gno_transform& bind : array(from.inverse_binds, from.joint_count, "gno_skin::inverse_binds"))
    result.inverseBinds.push_back(transformOf(bind));
  return result;
}

Clip clipOf(const gno_clip* clip) {
  const gno_clip& from = sized(clip, GNO_TYPE(gno_clip));
  Clip result;
  result.name = orEmpty(from.name);
  result.duration = from.duration;
  for (const gno_track& track : array(from.tracks, from.track_count, "gno_clip::tracks")) {
    const auto times = array(track.times, track.key_count, "gno_track::times");
    const auto values = array(track.values, track.value_count, "gno_track::values");
    result.tracks.push_back({track.node,
                             enumOf(track.property, Track::Property::morphWeights, "gno_track::property"),
                             enumOf(track.interpolation, Track::Interpolation::cubic, "gno_track::interpolation"),
                             {times.begin(), times.end()},
                             {values.begin(), values.end()}});
  }
  return result;
}

AnimatedInstance animatedOf(const gno_animated_instance* animated) {
  const gno_animated_instance& from = sized(animated, GNO_TYPE(gno_animated_instance));
  return {from.instance, from.node, from.skin, transformOf(from.offset)};
}

// Returns the function from a scene to a list of its animation.
template <class List>
auto inAnimation(List list) {
  return [list](Scene & scene) -> auto& {
    return scene.animation.*list;
  };
}

}  // namespace
}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

extern "C" {

gno_status gno_scene_add_node(gno_scene scene, const gno_node* node, uint32_t* index) {
  return addTo(scene, inAnimation(&SceneAnimation::nodes), nodeOf, node, index);
}

gno_status gno_scene_add_skin(gno_scene scene, const gno_skin* skin, uint32_t* index) {
  return addTo(scene, inAnimation(&SceneAnimation::skins), skinOf, skin, index);
}

gno_status gno_scene_add_clip(gno_scene scene, const gno_clip* clip, uint32_t* index) {
  return addTo(scene, inAnimation(&SceneAnimation::clips), clipOf, clip, index);
}

gno_status gno_scene_add_animated_instance(gno_scene scene, const gno_animated_instance* animated, uint32_t* index) {
  return addTo(scene, inAnimation(&SceneAnimation::instances), animatedOf, animated, index);
}

gno_status gno_scene_set_animation_root(gno_scene scene, const gno_transform* root) {
  return guard([&] {
    Changing to(scene);
    to->animation.root = transformOf(the(root, "root"));
    to->valid = false;
  });
}

gno_status gno_scene_get_node(gno_scene scene, size_t index, gno_node* node) {
  return guard([&] {
    Locked locked(scene);
    const Node& from = at(locked->animation.nodes, index, "node");
    const Out to(node, GNO_TYPE(gno_node));
    to->name = from.name.c_str();
    to->parent = from.parent;
    set(to->translation, from.translation);
    const auto& [x, y, z, w] = from.rotation;
    std::copy_n(std::array{x, y, z, w}.begin(), 4, to->rotation);
    set(to->scale, from.scale);
    to->matrix = from.matrix ? reinterpret_cast<const gno_transform*>(&*from.matrix) : nullptr;
    to->morph_weights = orNull(from.morphWeights);
    to->morph_weight_count = from.morphWeights.size();
  });
}

gno_status gno_scene_get_skin(gno_scene scene, size_t index, gno_skin* skin) {
  return guard([&] {
    Locked locked(scene);
    const Skin& from = at(locked->animation.skins, index, "skin");
    const Out to(skin, GNO_TYPE(gno_skin));
    to->name = from.name.c_str();
    to->joints = orNull(from.joints);
    to->inverse_binds = transformsOf(from.inverseBinds);
    to->joint_count = from.joints.size();
  });
}

gno_status gno_scene_get_clip(gno_scene scene, size_t index, gno_clip* clip) {
  return guard([&] {
    Locked locked(scene);
    const Clip& from = at(locked->animation.clips, index, "clip");
    const Out to(clip, GNO_TYPE(gno_clip));
    thread_local std::vector<gno_track> tracks;
    tracks.clear();
    for (const Track& track : from.tracks)
      tracks.push_back({track.node, static_cast<gno_track_property>(track.property),
                        static_cast<gno_interpolation>(track.interpolation), orNull(track.times), track.times.size(),
                        orNull(track.values), track.values.size()});
    to->name = from.name.c_str();
    to->duration = from.duration;
    to->tracks = orNull(tracks);
    to->track_count = tracks.size();
  });
}

gno_status gno_scene_get_animated_instance(gno_scene scene, size_t index, gno_animated_instance* animated) {
  return guard([&] {
    Locked locked(scene);
    const AnimatedInstance& from = at(locked->animation.instances, index, "animated instance");
    const Out to(animated, GNO_TYPE(gno_animated_instance));
    to->instance = from.instance;
    to->node = from.node;
    to->skin = from.skin;
    std::copy_n(from.offset.rows.begin(), 12, to->offset.rows);
  });
}

gno_status gno_scene_get_animation_root(gno_scene scene, gno_transform* root) {
  return guard([&] { std::copy_n(Locked(scene)->animation.root.rows.begin(), 12, the(root, "root").rows); });
}

gno_status gno_scene_find_clip(gno_scene scene, const char* name, uint32_t* index) {
  return guard([&] {
    Locked from(scene);
    const std::string wanted = &the(name, "name");
    const Clip& clip = clipNamed(*from, wanted);
    the(index, "index") = static_cast<uint32_t>(&clip - from->animation.clips.data());
  });
}

gno_status gno_scene_get_state(gno_scene scene, uint32_t clip, double seconds, gno_clip_end end,
                               gno_scene_state* state) {
  return guard([&] {
    Locked locked(scene);
    const Out to(state, GNO_TYPE(gno_scene_state));
    thread_local SceneState from;
    thread_local std::vector<gno_deformation> deformations;
    const Scene& whole = valid(*locked);
    const Clip rest;
    from = stateAt(whole, clip == GNO_NONE ? rest : at(whole.animation.clips, clip, "clip"), seconds,
                   enumOf(end, ClipEnd::hold, "the end of the clip"));
    deformations.clear();
    for (const Deformation& deformation : from.deformations) deformations.push_back(deformationOf(deformation));
    to->transforms = transformsOf(from.transforms);
    to->transform_count = from.transforms.size();
    to->deformations = orNull(deformations);
    to->deformation_count = deformations.size();
  });
}

}  // extern "C"
