// SPDX-License-Identifier: Apache-2.0
#include "scene/gltf_animation.hpp"

#include <algorithm>

#include "base/finite.hpp"
#include "base/limits.hpp"
#include "base/quaternion.hpp"
#include "base/transform.hpp"
#include "gnosphere/animation.hpp"
#include "scene/gltf_clips.hpp"

namespace gnosphere {
namespace {

constexpr size_t kNumberedJoints = 65536;  // what Mesh::joints can number

class AnimationReader {
 public:
  AnimationReader(const GltfFile& file, GltfArrays& arrays, const Source& source, const std::vector<int>& parents,
                  const std::vector<GltfPlacement>& placements, Scene& scene, LeftOut& leftOut)
      : file_(file),
        model_(file.model),
        arrays_(arrays),
        source_(source),
        parents_(parents),
        placements_(placements),
        scene_(scene),
        animation_(scene.animation),
        leftOut_(leftOut) {}

  void read() {
    countIgnoredSkins();
    bool deforms = false;
    for (size_t i = 0; i < placements_.size(); ++i) deforms = deforms || isDeformed(i);
    if (!deforms && file_.animations.empty()) return;
    nodes();
    skins();
    meshes();
    animation_.clips = readGltfClips(file_, arrays_, source_, newIndex_, scene_, leftOut_);
    movedInstances();
    rest();
  }

 private:
  void nodes();
  Node node(size_t index) const;
  void skins();
  void meshes();
  bool isSkinned(size_t instance) const;
  bool isDeformed(size_t instance) const {
    return isSkinned(instance) || !scene_.meshes[scene_.instances[instance].mesh].morphTargets.empty();
  }
  void countIgnoredSkins();
  void follow(size_t instance);
  void bind(Mesh& mesh, AnimatedInstance& animated);
  uint32_t skinWith(uint32_t skin, uint32_t node);
  void movedInstances();
  void rest();
  std::string label(size_t node) const { return gltfLabel("node", node, model_.nodes[node].name); }

  const GltfFile& file_;
  const tinygltf::Model& model_;
  GltfArrays& arrays_;
  const Source& source_;
  const std::vector<int>& parents_;
  const std::vector<GltfPlacement>& placements_;
  Scene& scene_;
  SceneAnimation& animation_;
  LeftOut& leftOut_;
  std::vector<uint32_t> newIndex_;  // by node of the file: index into animation_.nodes
  std::vector<Transform> atRest_;   // by node of animation_: its map to the frame above all nodes
};

/// Sorts the nodes so that parents come before their children.
void AnimationReader::nodes() {
  newIndex_.resize(model_.nodes.size());
  std::vector<int> stack;
  for (size_t i = parents_.size(); i-- > 0;)
    if (parents_[i] < 0) stack.push_back(static_cast<int>(i));
  while (!stack.empty()) {
    const auto index = static_cast<size_t>(stack.back());
    stack.pop_back();
    newIndex_[index] = static_cast<uint32_t>(animation_.nodes.size());
    const Node& added = animation_.nodes.emplace_back(node(index));
    const Transform local = added.matrix ? *added.matrix : composed(added.translation, added.rotation, added.scale);
    atRest_.push_back(added.parent == kNoNode ? local : atRest_[added.parent] * local);
    const std::vector<int>& children = model_.nodes[index].children;
    stack.insert(stack.end(), children.rbegin(), children.rend());
  }
}

Node AnimationReader::node(size_t index) const {
  const tinygltf::Node& from = model_.nodes[index];
  Node node;
  node.name = from.name;
  if (parents_[index] >= 0) node.parent = newIndex_[static_cast<size_t>(parents_[index])];
  if (!from.matrix.empty()) node.matrix = gltfMatrix(from.matrix.data());
  if (!from.translation.empty()) node.translation = {from.translation[0], from.translation[1], from.translation[2]};
  if (!from.rotation.empty()) node.rotation = {from.rotation[0], from.rotation[1], from.rotation[2], from.rotation[3]};
  if (isZero(node.rotation)) node.rotation = {};
  if (!from.scale.empty()) node.scale = {from.scale[0], from.scale[1], from.scale[2]};
  if (from.mesh < 0 || static_cast<size_t>(from.mesh) >= model_.meshes.size()) return node;
  const tinygltf::Mesh& mesh = model_.meshes[static_cast<size_t>(from.mesh)];
  const std::vector<double>& weights = from.weights.empty() ? mesh.weights : from.weights;
  node.morphWeights.assign(weights.begin(), weights.end());
  if (!allFinite(node.morphWeights)) source_.fail(label(index) + ": a morph weight is not finite");
  return node;
}

void AnimationReader::skins() {
  for (size_t i = 0; i < file_.skins.size(); ++i) {
    const auto& from = file_.skins[i];
    Skin& skin = animation_.skins.emplace_back();
    skin.name = from.value("name", std::string());
    const std::string who = gltfLabel("skin", i, skin.name);
    for (const auto& joint : from["joints"]) {
      const auto node = joint.get<size_t>();
      if (node >= model_.nodes.size()) source_.fail(who + ": node " + std::to_string(node) + " does not exist");
      skin.joints.push_back(newIndex_[node]);
    }
    skin.inverseBinds.resize(skin.joints.size());
    if (!from.contains("inverseBindMatrices")) continue;
    const std::vector<double> values = arrays_.vectors(from["inverseBindMatrices"].get<int>(), 16, who);
    if (values.size() < 16 * skin.joints.size())
      source_.fail(who + ": " + std::to_string(values.size() / 16) + " inverse bind matrices for " +
                   std::to_string(skin.joints.size()) + " joints");
    if (!allFinite(values)) source_.fail(who + ": an inverse bind matrix is not finite");
    for (size_t joint = 0; joint < skin.joints.size(); ++joint)
      skin.inverseBinds[joint] = gltfMatrix(&values[16 * joint]);
  }
}

bool AnimationReader::isSkinned(size_t instance) const {
  const GltfPlacement& placement = placements_[instance];
  return model_.nodes[placement.node].skin >= 0 && !placement.instanced &&
         scene_.meshes[scene_.instances[instance].mesh].influences > 0;
}

void AnimationReader::countIgnoredSkins() {
  for (size_t i = 0; i < placements_.size(); ++i) {
    if (model_.nodes[placements_[i].node].skin < 0 || isSkinned(i)) continue;
    leftOut_.add(placements_[i].instanced
                     ? "instances that ignore their skin, because EXT_mesh_gpu_instancing places them"
                     : "nodes that ignore their skin, because their mesh has no joints");
  }
}

/// Replaces the meshes that the file has by those that the scene needs: one for all nodes that place a mesh as it is,
/// and one for each node that deforms it.
void AnimationReader::meshes() {
  constexpr uint32_t kAsItIs = kNoNode;
  using Use = std::pair<uint32_t, uint32_t>;  // mesh as read, and the node that deforms it
  std::vector<Use> uses;
  for (size_t i = 0; i < placements_.size(); ++i) {
    const uint32_t mesh = scene_.instances[i].mesh;
    const bool deformed = isDeformed(i);
    uses.emplace_back(mesh, deformed ? newIndex_[placements_[i].node] : kAsItIs);
    if (deformed) follow(i);
  }
  std::vector<Use> kept = uses;
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  std::vector<Mesh> read = std::move(scene_.meshes);
  scene_.meshes.clear();
  for (size_t i = 0; i < kept.size(); ++i) {
    Mesh& from = read[kept[i].first];
    const bool last = i + 1 == kept.size() || kept[i + 1].first != kept[i].first;
    if (!last)
      arrays_.charge(from.positions.size() * (2 + from.morphTargets.size()) + from.joints.size() + from.indices.size(),
                     4, gltfLabel("mesh", kept[i].first, from.name));
    scene_.meshes.push_back(last ? std::move(from) : from);
  }
  const auto newMesh = [&](const Use& use) {
    return static_cast<uint32_t>(std::lower_bound(kept.begin(), kept.end(), use) - kept.begin());
  };
  for (size_t i = 0; i < uses.size(); ++i) scene_.instances[i].mesh = newMesh(uses[i]);
  std::vector<bool> skinned(kept.size());
  for (AnimatedInstance& animated : animation_.instances) {
    if (animated.skin == kNoSkin) continue;
    bind(scene_.meshes[scene_.instances[animated.instance].mesh], animated);
    skinned[scene_.instances[animated.instance].mesh] = true;
  }
  for (size_t i = 0; i < kept.size(); ++i) {
    if (skinned[i]) continue;
    scene_.meshes[i].influences = 0;
    scene_.meshes[i].joints = {};
    scene_.meshes[i].jointWeights = {};
  }
}

void AnimationReader::follow(size_t instance) {
  const GltfPlacement& placement = placements_[instance];
  AnimatedInstance& animated = animation_.instances.emplace_back();
  animated.instance = static_cast<uint32_t>(instance);
  animated.node = newIndex_[placement.node];
  animated.offset = placement.offset;
  if (!isSkinned(instance)) return;
  const auto skin = static_cast<size_t>(model_.nodes[placement.node].skin);
  if (skin >= animation_.skins.size())
    source_.fail(label(placement.node) + ": skin " + std::to_string(skin) + " does not exist");
  animated.skin = static_cast<uint32_t>(skin);
}

/// Connects a mesh with its skin. Vertices of primitives without joints follow the node of the mesh, as a last joint.
void AnimationReader::bind(Mesh& mesh, AnimatedInstance& animated) {
  const std::string who = label(placements_[animated.instance].node);
  const size_t joints = animation_.skins[animated.skin].joints.size();
  if (joints == 0 || joints >= kNumberedJoints)
    source_.fail(who + ": its skin has " + std::to_string(joints) + " joints; it must have 1 to " +
                 std::to_string(kNumberedJoints - 1));
  if (mesh.influences > limits::kInfluences.most)
    source_.fail(who + ": a vertex of its mesh follows up to " + std::to_string(mesh.influences) +
                 " joints; the limit is " + std::to_string(limits::kInfluences.most));
  bool rigid = false;
  for (size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex) {
    const size_t first = vertex * mesh.influences, end = first + mesh.influences;
    const bool follows = std::any_of(&mesh.jointWeights[first], &mesh.jointWeights[first] + mesh.influences,
                                     [](float weight) { return weight > 0; });
    if (!follows) {
      rigid = true;
      mesh.joints[first] = static_cast<uint16_t>(joints);
      mesh.jointWeights[first] = 1;
      continue;
    }
    for (size_t k = first; k < end; ++k)
      if (mesh.joints[k] >= joints)
        source_.fail(who + ": a vertex of its mesh follows joint " + std::to_string(mesh.joints[k]) +
                     ", its skin has " + std::to_string(joints));
  }
  if (rigid) animated.skin = skinWith(animated.skin, animated.node);
  mesh.jointCount = static_cast<uint32_t>(animation_.skins[animated.skin].joints.size());
  arrays_.charge(mesh.jointCount, sizeof(Transform), who);  // of Mesh::deformation
  // The mesh frame is that of the nodes, moved to the first joint, so that floats hold vertices far from the origin.
  const Transform& place = atRest_[animation_.skins[animated.skin].joints[0]];
  for (size_t row = 0; row < 3; ++row) animated.offset.rows[4 * row + 3] = place.rows[4 * row + 3];
  if (!allFinite(animated.offset.rows)) source_.fail(who + ": the first joint of its skin is not at a finite place");
  if (determinant(place * animation_.skins[animated.skin].inverseBinds[0]) < 0) turnAround(mesh.indices);
  scene_.instances[animated.instance].transform = animated.offset;
}

/// Adds a skin that has this node as a last joint.
uint32_t AnimationReader::skinWith(uint32_t skin, uint32_t node) {
  arrays_.charge(animation_.skins[skin].joints.size() + 1, sizeof(Transform) + sizeof(uint32_t), "a skin");
  Skin extended = animation_.skins[skin];
  extended.joints.push_back(node);
  extended.inverseBinds.emplace_back();
  animation_.skins.push_back(std::move(extended));
  return static_cast<uint32_t>(animation_.skins.size() - 1);
}

/// Adds the instances whose nodes are moved by clips, directly or with their parents.
void AnimationReader::movedInstances() {
  std::vector<bool> moved(animation_.nodes.size());
  for (const Clip& clip : animation_.clips)
    for (const Track& track : clip.tracks)
      if (track.property != Track::Property::morphWeights) moved[track.node] = true;
  for (size_t i = 0; i < moved.size(); ++i)
    if (animation_.nodes[i].parent != kNoNode && moved[animation_.nodes[i].parent]) moved[i] = true;
  std::vector<bool> listed(scene_.instances.size());
  for (const AnimatedInstance& animated : animation_.instances) listed[animated.instance] = true;
  for (size_t i = 0; i < placements_.size(); ++i) {
    const uint32_t node = newIndex_[placements_[i].node];
    if (moved[node] && !listed[i])
      animation_.instances.push_back({static_cast<uint32_t>(i), node, kNoSkin, placements_[i].offset});
  }
}

/// Puts the deformable meshes into the state that the nodes of the file have.
void AnimationReader::rest() {
  for (const AnimatedInstance& animated : animation_.instances) {
    Node& node = animation_.nodes[animated.node];
    const Mesh& mesh = scene_.meshes[scene_.instances[animated.instance].mesh];
    if (mesh.morphTargets.empty()) node.morphWeights.clear();
    if (node.morphWeights.size() <= mesh.morphTargets.size()) continue;
    source_.fail(gltfLabel("node", placements_[animated.instance].node, node.name) + ": " +
                 std::to_string(node.morphWeights.size()) + " weights for " + std::to_string(mesh.morphTargets.size()) +
                 " morph targets");
  }
  SceneState state = stateAt(scene_, {}, 0);
  for (size_t i = 0; i < scene_.meshes.size(); ++i) {
    for (const Transform& joint : state.deformations[i].joints)
      if (!allFinite(joint.rows))
        source_.fail(gltfLabel("mesh", i, scene_.meshes[i].name) + ": a joint is not at a finite place");
    scene_.meshes[i].deformation = std::move(state.deformations[i]);
  }
}

}  // namespace

Transform gltfMatrix(const double* columns) {
  Transform transform;
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 4; ++column) transform.rows[4 * row + column] = columns[4 * column + row];
  return transform;
}

void readGltfAnimation(const GltfFile& file, GltfArrays& arrays, const Source& source, const std::vector<int>& parents,
                       const std::vector<GltfPlacement>& placements, Scene& scene, LeftOut& leftOut) {
  AnimationReader(file, arrays, source, parents, placements, scene, leftOut).read();
}

}  // namespace gnosphere
