// SPDX-License-Identifier: Apache-2.0
#include "scene/gltf_clips.hpp"

#include <algorithm>
#include <set>

#include "scene/validate.hpp"

namespace gnosphere {
namespace {

using Json = nlohmann::json;

class ClipReader {
 public:
  ClipReader(const GltfFile& file, GltfArrays& arrays, const Source& source, const std::vector<uint32_t>& nodes,
             const Scene& scene, LeftOut& leftOut)
      : file_(file), arrays_(arrays), source_(source), nodes_(nodes), animation_(scene.animation), leftOut_(leftOut) {
    for (const AnimatedInstance& animated : animation_.instances)
      morphTargets_[animated.node] = scene.meshes[scene.instances[animated.instance].mesh].morphTargets.size();
  }

  std::vector<Clip> read() {
    std::vector<Clip> clips;
    for (size_t i = 0; i < file_.animations.size(); ++i) clips.push_back(clip(i));
    return clips;
  }

 private:
  Clip clip(size_t index);
  bool target(const Json& channel, const std::string& who, Track& track);
  void keys(const Json& sampler, const std::string& who, Track& track);

  const GltfFile& file_;
  GltfArrays& arrays_;
  const Source& source_;
  const std::vector<uint32_t>& nodes_;
  const SceneAnimation& animation_;
  LeftOut& leftOut_;
  std::map<uint32_t, size_t> morphTargets_;  // by node that places a mesh with some
};

Clip ClipReader::clip(size_t index) {
  const Json& from = file_.animations[index];
  Clip clip;
  clip.name = from.value("name", std::string());
  const std::string who = gltfLabel("animation", index, clip.name);
  if (clip.name.empty()) clip.name = std::to_string(index);
  std::set<std::pair<uint32_t, Track::Property>> seen;
  const Json &channels = from["channels"], &samplers = from["samplers"];
  for (size_t i = 0; i < channels.size(); ++i) {
    const std::string channel = who + ", channel " + std::to_string(i);
    Track track;
    // writeGlb() gives a clip that moves nothing such a channel, and its duration.
    if (from.contains(kDurationExtra) && !channels[i]["target"].contains("node")) continue;
    if (!target(channels[i], channel, track)) continue;
    if (!seen.emplace(track.node, track.property).second)
      source_.fail(channel + " moves what another channel of the animation moves");
    const auto sampler = channels[i]["sampler"].get<size_t>();
    if (sampler >= samplers.size()) source_.fail(channel + ": sampler " + std::to_string(sampler) + " does not exist");
    keys(samplers[sampler], channel, track);
    clip.duration = std::max(clip.duration, double{track.times.back()});
    clip.tracks.push_back(std::move(track));
  }
  clip.duration = from.value(kDurationExtra, clip.duration);
  return clip;
}

/// Sets what the track moves. Returns false if it is nothing that a scene has.
bool ClipReader::target(const Json& channel, const std::string& who, Track& track) {
  const Json& target = channel["target"];
  const std::string_view path = target["path"].get_ref<const std::string&>();
  const auto property = std::ranges::find(kTrackPaths, path);
  if (property == kTrackPaths.end()) {
    leftOut_.add("animation channels that move " + inQuotes(path));
    return false;
  }
  track.property = static_cast<Track::Property>(property - kTrackPaths.begin());
  if (!target.contains("node")) {
    leftOut_.add("animation channels without a node");
    return false;
  }
  const auto node = target["node"].get<size_t>();
  if (node >= nodes_.size()) source_.fail(who + ": node " + std::to_string(node) + " does not exist");
  track.node = nodes_[node];
  if (animation_.nodes[track.node].matrix && track.property != Track::Property::morphWeights) {
    leftOut_.add("animation channels that move a node with a matrix");
    return false;
  }
  const auto targets = morphTargets_.find(track.node);
  if (track.property == Track::Property::morphWeights && (targets == morphTargets_.end() || targets->second == 0)) {
    leftOut_.add("animation channels for morph weights of a node that places no mesh with morph targets");
    return false;
  }
  return true;
}

void ClipReader::keys(const Json& sampler, const std::string& who, Track& track) {
  const std::string name = sampler.value("interpolation", std::string("LINEAR"));
  const auto interpolation = std::ranges::find(kInterpolations, std::string_view(name));
  if (interpolation == kInterpolations.end())
    source_.fail(who + ": interpolation " + inQuotes(name) + " is not STEP, LINEAR or CUBICSPLINE");
  track.interpolation = static_cast<Track::Interpolation>(interpolation - kInterpolations.begin());
  const auto floats = [&](const char* accessor, int components) {
    const std::vector<double> values = arrays_.vectors(sampler[accessor].get<int>(), components, who);
    return std::vector<float>(values.begin(), values.end());
  };
  track.times = floats("input", 1);
  const bool weights = track.property == Track::Property::morphWeights;
  track.values = floats("output", weights ? 1 : track.property == Track::Property::rotation ? 4 : 3);
  const std::string problem = problemOf(track, weights ? morphTargets_.at(track.node) : 0);
  if (!problem.empty()) source_.fail(who + ": " + problem);
}

}  // namespace

std::vector<Clip> readGltfClips(const GltfFile& file, GltfArrays& arrays, const Source& source,
                                const std::vector<uint32_t>& nodes, const Scene& scene, LeftOut& leftOut) {
  return ClipReader(file, arrays, source, nodes, scene, leftOut).read();
}

}  // namespace gnosphere
