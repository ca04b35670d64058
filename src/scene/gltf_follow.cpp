// SPDX-License-Identifier: Apache-2.0
#include "scene/gltf_follow.hpp"

#include <cmath>

#include "base/text.hpp"

namespace gnosphere {
namespace {

constexpr size_t kSet = 4;  // joints of a set
constexpr float kHighestJoint = 65535;

std::string nameOf(const char* kind, size_t set) {
  return std::string(kind) + "_" + std::to_string(set);
}

}  // namespace

GltfFollow GltfFollowReader::follow(const tinygltf::Primitive& primitive, bool skinned, const std::string& who) {
  GltfFollow follow;
  for (size_t set = 0; skinned; ++set) {
    const auto joints = primitive.attributes.find(nameOf("JOINTS", set)),
               weights = primitive.attributes.find(nameOf("WEIGHTS", set));
    const bool hasJoints = joints != primitive.attributes.end(), hasWeights = weights != primitive.attributes.end();
    if (hasJoints != hasWeights)
      source_.fail(who + " has " + nameOf(hasJoints ? "JOINTS" : "WEIGHTS", set) + " without " +
                   nameOf(hasJoints ? "WEIGHTS" : "JOINTS", set));
    if (!hasJoints) break;
    follow.joints.push_back(joints->second);
    follow.weights.push_back(weights->second);
  }
  for (const auto& target : primitive.targets) {
    const auto position = target.find("POSITION");
    follow.targets.push_back(position == target.end() ? -1 : position->second);
  }
  return follow;
}

void GltfFollowReader::addDracoIds(const tinygltf::Value& attributes, const GltfFollow& follow, const std::string& who,
                                   DracoIds& ids) const {
  if (follow.joints.empty() || !attributes.Has("JOINTS_0")) return;
  for (size_t set = 0; set < follow.joints.size(); ++set)
    for (const auto& [kind, list] : {std::pair("JOINTS", &ids.joints), std::pair("WEIGHTS", &ids.weights)}) {
      const std::string name = nameOf(kind, set);
      if (!attributes.Has(name)) source_.fail(who + ": its Draco data has no " + name);
      list->push_back(attributes.Get(name).GetNumberAsInt());
    }
}

const std::vector<float>& GltfFollowReader::values(int accessor, size_t components, const char* what, size_t count,
                                                   const std::string& who) {
  const std::vector<float>& values = arrays_.keptFloats(accessor, components, what, who);
  if (values.size() != components * count)
    source_.fail(who + ": accessor " + std::to_string(accessor) + " has " + what + " for " +
                 std::to_string(values.size() / components) + " vertices, there are " + std::to_string(count));
  return values;
}

void GltfFollowReader::append(Mesh& mesh, const GltfFollow& follow, const DracoMesh* draco,
                              const std::vector<uint32_t>* used, size_t count, const std::string& who) {
  if (mesh.influences == 0 && mesh.morphTargets.empty()) return;
  const size_t added = used ? used->size() : count, first = mesh.vertexCount() - added;
  arrays_.charge(added, 6 * mesh.influences + 12 * mesh.morphTargets.size(), who);
  mesh.joints.resize(mesh.vertexCount() * mesh.influences);
  mesh.jointWeights.resize(mesh.joints.size());
  for (size_t set = 0; set < follow.joints.size(); ++set) {
    if (draco && !draco->joints.empty())
      appendSet(mesh, set, draco->joints[set], draco->weights[set], used, first, who);
    else
      appendSet(mesh, set, values(follow.joints[set], kSet, "joints", count, who),
                values(follow.weights[set], kSet, "weights", count, who), used, first, who);
  }
  if (!follow.joints.empty()) normalizeWeights(mesh, first);
  for (size_t target = 0; target < mesh.morphTargets.size(); ++target) {
    std::vector<float>& offsets = mesh.morphTargets[target];
    offsets.resize(mesh.positions.size());
    if (target >= follow.targets.size() || follow.targets[target] < 0) continue;
    const std::vector<float>& all = values(follow.targets[target], 3, "offsets of a morph target", count, who);
    for (size_t i = 0; i < added; ++i)
      for (size_t c = 0; c < 3; ++c) offsets[3 * (first + i) + c] = all[3 * (used ? (*used)[i] : i) + c];
  }
}

void GltfFollowReader::appendSet(Mesh& mesh, size_t set, const std::vector<float>& joints,
                                 const std::vector<float>& weights, const std::vector<uint32_t>* used, size_t first,
                                 const std::string& who) const {
  for (size_t vertex = first; vertex < mesh.vertexCount(); ++vertex) {
    const size_t from = kSet * (used ? (*used)[vertex - first] : vertex - first);
    const size_t to = vertex * mesh.influences + kSet * set;
    for (size_t c = 0; c < kSet; ++c) {
      const float joint = joints[from + c], weight = weights[from + c];
      if (!(weight >= 0) || std::isinf(weight))
        source_.fail(who + ": a weight of " + nameOf("WEIGHTS", set) + " is " + numberText(double{weight}) +
                     "; weights are 0 or more");
      if (weight == 0) continue;  // its joint may be anything
      if (!(joint >= 0 && joint <= kHighestJoint && joint == std::floor(joint)))
        source_.fail(who + ": a joint of " + nameOf("JOINTS", set) + " is " + std::to_string(joint) +
                     "; joints are whole numbers up to 65535");
      mesh.joints[to + c] = static_cast<uint16_t>(joint);
      mesh.jointWeights[to + c] = weight;
    }
  }
}

/// Makes the weights of every vertex sum to 1.
void GltfFollowReader::normalizeWeights(Mesh& mesh, size_t first) {
  for (size_t vertex = first; vertex < mesh.vertexCount(); ++vertex) {
    const std::span<float> weights(&mesh.jointWeights[vertex * mesh.influences], mesh.influences);
    double sum = 0;
    for (float weight : weights) sum += weight;
    if (sum == 0) {
      weights[0] = 1;
      leftOut_.add("vertices whose joint weights are all 0; they follow the first joint of their skin");
      continue;
    }
    for (float& weight : weights) weight = static_cast<float>(weight / sum);
  }
}

}  // namespace gnosphere
