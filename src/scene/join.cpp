// SPDX-License-Identifier: Apache-2.0
// Makes one scene of two.
#include "scene/join.hpp"

#include <string>
#include <utility>
#include <vector>

#include "base/finite.hpp"
#include "base/transform.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

template <typename T>
void append(std::vector<T>& all, const std::vector<T>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

/// Throws the error of validate(), which begins with the name of the scene then.
void check(const Scene& scene, const std::string& name) {
  try {
    validate(scene);
  } catch (const Error& error) {
    throw Error(error.code(), "joined: `" + name + "`: " + error.what());
  }
}

uint32_t countOf(const auto& list) {
  return static_cast<uint32_t>(list.size());
}

/// Appends an animation whose root is `root`. Its instances count from `firstInstance` on.
void appendAnimation(SceneAnimation& animation, const SceneAnimation& other, const Transform& root,
                     uint32_t firstInstance) {
  if (other.nodes.empty()) return;
  if (animation.nodes.empty()) {
    animation = other;
    animation.root = root;
    for (AnimatedInstance& follower : animation.instances) follower.instance += firstInstance;
    return;
  }
  if (determinant(animation.root) == 0)
    throw Error(ErrorCode::invalidArgument, "joined: the root of the scene's animation has no inverse");
  // The map from the other root to this one becomes a node, above all other nodes.
  const Transform between = inverse(animation.root) * root;
  const uint32_t top = countOf(animation.nodes), firstNode = top + 1, firstSkin = countOf(animation.skins);
  animation.nodes.emplace_back().matrix = between;
  for (Node node : other.nodes) {
    node.parent = node.parent == kNoNode ? top : node.parent + firstNode;
    animation.nodes.push_back(std::move(node));
  }
  for (Skin skin : other.skins) {
    for (uint32_t& joint : skin.joints) joint += firstNode;
    animation.skins.push_back(std::move(skin));
  }
  for (Clip clip : other.clips) {
    for (Track& track : clip.tracks) track.node += firstNode;
    animation.clips.push_back(std::move(clip));
  }
  for (AnimatedInstance follower : other.instances) {
    follower.instance += firstInstance;
    follower.node += firstNode;
    if (follower.skin != kNoSkin) {  // its transform is root * offset, without a node
      follower.skin += firstSkin;
      follower.offset = between * follower.offset;
    }
    animation.instances.push_back(follower);
  }
}

}  // namespace

uint32_t appendMeshes(Scene& scene, const Scene& other) {
  const uint32_t firstMaterial = countOf(scene.materials), firstImage = countOf(scene.alphaImages),
                 firstMesh = countOf(scene.meshes);
  append(scene.alphaImages, other.alphaImages);
  for (Material material : other.materials) {
    if (material.alphaImage != kNoImage) material.alphaImage += firstImage;
    scene.materials.push_back(std::move(material));
  }
  for (Mesh mesh : other.meshes) {
    for (MeshPart& part : mesh.parts) part.material += firstMaterial;
    scene.meshes.push_back(std::move(mesh));
  }
  return firstMesh;
}

Scene joined(Scene scene, const Scene& other, const Transform& transform) {
  check(scene, "scene");
  check(other, "other");
  if (!allFinite(transform.rows)) throw Error(ErrorCode::invalidArgument, "joined: the transform is not finite");
  const uint32_t firstInstance = countOf(scene.instances), firstMesh = appendMeshes(scene, other);
  for (Instance instance : other.instances) {
    instance.mesh += firstMesh;
    instance.transform = transform * instance.transform;
    scene.instances.push_back(std::move(instance));
  }
  appendAnimation(scene.animation, other.animation, transform * other.animation.root, firstInstance);
  append(scene.leftOut, other.leftOut);
  scene.unreadImages += other.unreadImages;
  return scene;
}

}  // namespace gnosphere
