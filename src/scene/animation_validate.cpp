// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "base/finite.hpp"
#include "base/transform.hpp"
#include "gnosphere/error.hpp"
#include "scene/validate.hpp"

namespace gnosphere {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw Error(ErrorCode::invalidArgument, what);
}

std::string label(const char* kind, size_t index, const std::string& name) {
  return std::string(kind) + " " + std::to_string(index) + (name.empty() ? "" : " ('" + name + "')");
}

std::string missing(const char* kind, uint32_t index, size_t count) {
  return std::string(kind) + " " + std::to_string(index) + " does not exist, there are " + std::to_string(count);
}

void checkNode(const Node& node, size_t index) {
  const std::string name = label("node", index, node.name);
  if (node.parent != kNoNode && node.parent >= index)
    refuse(name + ": its parent is node " + std::to_string(node.parent) + "; parents come before their children");
  const auto& [t, r, s] = std::tie(node.translation, node.rotation, node.scale);
  const double numbers[] = {t.x, t.y, t.z, r.x, r.y, r.z, r.w, s.x, s.y, s.z};
  if (!allFinite(numbers) || (node.matrix && !allFinite(node.matrix->rows)) || !allFinite(node.morphWeights))
    refuse(name + ": its transform or its morph weights are not finite");
  if (r.x == 0 && r.y == 0 && r.z == 0 && r.w == 0) refuse(name + ": its rotation is a quaternion of length 0");
}

void checkSkin(const SceneAnimation& animation, size_t index) {
  const Skin& skin = animation.skins[index];
  const std::string name = label("skin", index, skin.name);
  if (skin.joints.size() != skin.inverseBinds.size())
    refuse(name + ": it has " + std::to_string(skin.joints.size()) + " joints and " +
           std::to_string(skin.inverseBinds.size()) + " inverse bind maps");
  for (uint32_t joint : skin.joints)
    if (joint >= animation.nodes.size()) refuse(name + ": " + missing("node", joint, animation.nodes.size()));
  for (const Transform& map : skin.inverseBinds)
    if (!allFinite(map.rows)) refuse(name + ": an inverse bind map is not finite");
}

void checkTrack(const Track& track, const std::string& name, const SceneAnimation& animation,
                const std::map<uint32_t, size_t>& morphTargets) {
  if (track.node >= animation.nodes.size()) refuse(name + ": " + missing("node", track.node, animation.nodes.size()));
  if (animation.nodes[track.node].matrix && track.property != Track::Property::morphWeights)
    refuse(name + ": " + label("node", track.node, animation.nodes[track.node].name) +
           " has a matrix, so nothing moves it");
  const auto targets = morphTargets.find(track.node);
  if (track.property == Track::Property::morphWeights && targets == morphTargets.end())
    refuse(name + ": " + label("node", track.node, animation.nodes[track.node].name) +
           " places no mesh with morph targets");
  const std::string problem = problemOf(track, targets == morphTargets.end() ? 0 : targets->second);
  if (!problem.empty()) refuse(name + ": " + problem);
}

/// Returns the number of morph targets by the node that places them.
std::map<uint32_t, size_t> checkInstances(const Scene& scene) {
  const SceneAnimation& animation = scene.animation;
  std::map<uint32_t, size_t> morphTargets;
  std::map<uint32_t, const AnimatedInstance*> owners;  // by deformable mesh
  std::set<uint32_t> seen;
  for (size_t i = 0; i < animation.instances.size(); ++i) {
    const AnimatedInstance& animated = animation.instances[i];
    const std::string name = label("animated instance", i, "");
    if (animated.instance >= scene.instances.size())
      refuse(name + ": " + missing("instance", animated.instance, scene.instances.size()));
    if (!seen.insert(animated.instance).second)
      refuse(name + ": another one is instance " + std::to_string(animated.instance) + ", too");
    if (animated.node >= animation.nodes.size())
      refuse(name + ": " + missing("node", animated.node, animation.nodes.size()));
    if (animated.skin != kNoSkin && animated.skin >= animation.skins.size())
      refuse(name + ": " + missing("skin", animated.skin, animation.skins.size()));
    const auto& m = animated.offset.rows;
    if (!allFinite(m) || (animated.skin != kNoSkin && !std::isnormal(determinant(animated.offset))))
      refuse(name + ": its offset is not finite, or has no inverse");
    const uint32_t number = scene.instances[animated.instance].mesh;
    const Mesh& mesh = scene.meshes[number];
    const size_t joints = animated.skin == kNoSkin ? 0 : animation.skins[animated.skin].joints.size();
    if (mesh.jointCount != joints)
      refuse(name + ": its skin has " + std::to_string(joints) + " joints, its mesh has " +
             std::to_string(mesh.jointCount));
    if (!mesh.deformable()) continue;
    const auto [owner, isNew] = owners.emplace(number, &animated);
    if (!isNew && (owner->second->node != animated.node || owner->second->skin != animated.skin))
      refuse(name + ": mesh " + std::to_string(number) +
             " already follows another node or skin; give it a mesh of its own");
    const size_t weights = animation.nodes[animated.node].morphWeights.size();
    if (weights > mesh.morphTargets.size())
      refuse(name + ": its node has " + std::to_string(weights) + " morph weights, its mesh has " +
             std::to_string(mesh.morphTargets.size()) + " targets");
    if (!mesh.morphTargets.empty()) morphTargets[animated.node] = mesh.morphTargets.size();
  }
  return morphTargets;
}

}  // namespace

std::string problemOf(const Track& track, size_t morphTargets) {
  const size_t values = track.property == Track::Property::rotation       ? 4
                        : track.property == Track::Property::morphWeights ? morphTargets
                                                                          : 3;
  const size_t width = track.interpolation == Track::Interpolation::cubic ? 3 * values : values;
  const size_t keys = track.times.size();
  if (keys == 0) return "it has no keys";
  if (track.values.size() != width * keys)
    return std::to_string(keys) + " keys of " + std::to_string(width) + " numbers need " +
           std::to_string(width * keys) + ", there are " + std::to_string(track.values.size());
  if (!allFinite(track.times) || !std::ranges::is_sorted(track.times) || track.times[0] < 0)
    return "its times do not ascend from 0 or later";
  return allFinite(track.values) ? "" : "a value is not finite";
}

void validateAnimation(const Scene& scene) {
  const SceneAnimation& animation = scene.animation;
  if (!allFinite(animation.root.rows)) refuse("the transform above all nodes is not finite");
  for (size_t i = 0; i < animation.nodes.size(); ++i) checkNode(animation.nodes[i], i);
  for (size_t i = 0; i < animation.skins.size(); ++i) checkSkin(animation, i);
  const std::map<uint32_t, size_t> morphTargets = checkInstances(scene);
  for (size_t i = 0; i < animation.clips.size(); ++i) {
    const Clip& clip = animation.clips[i];
    const std::string name = label("clip", i, clip.name);
    if (!(clip.duration >= 0) || !std::isfinite(clip.duration)) refuse(name + ": its duration is not 0 or more");
    std::set<std::pair<uint32_t, Track::Property>> moved;
    for (size_t k = 0; k < clip.tracks.size(); ++k) {
      const Track& track = clip.tracks[k];
      const std::string trackName = name + ", track " + std::to_string(k);
      checkTrack(track, trackName, animation, morphTargets);
      if (!moved.emplace(track.node, track.property).second)
        refuse(trackName + ": another track of the clip moves the same property of node " + std::to_string(track.node));
    }
  }
}

}  // namespace gnosphere
