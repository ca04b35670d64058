// SPDX-License-Identifier: Apache-2.0
// The state of a scene at a time of a clip. (glTF 2.0, section 3.11 and appendix C.)
#include "gnosphere/animation.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "base/nearest_text.hpp"
#include "base/quaternion.hpp"
#include "base/transform.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

using Values = std::vector<double>;

double length(const Values& q) {
  return std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

void normalize(Values& q) {
  const Quaternion usable = withUsableLength({q[0], q[1], q[2], q[3]});
  q = {usable.x, usable.y, usable.z, usable.w};
  const double l = length(q);
  for (double& value : q) value = l > 0 ? value / l : 0;
  if (l == 0) q[3] = 1;
}

/// The rotation at a share of the shorter way from `a` to `b`.
Values slerp(Values a, Values b, double share) {
  normalize(a);
  normalize(b);
  double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const double sign = cosine < 0 ? -1 : 1;
  cosine = std::min(sign * cosine, 1.0);
  const double angle = std::acos(cosine), sine = std::sin(angle);
  // Up to this angle the chord and the arc differ by less than the rounding.
  const bool straight = angle < 1e-6;
  const double wa = straight ? 1 - share : std::sin((1 - share) * angle) / sine;
  const double wb = sign * (straight ? share : std::sin(share * angle) / sine);
  for (size_t i = 0; i < 4; ++i) a[i] = wa * a[i] + wb * b[i];
  return a;
}

/// The values of a track at a time, which are constant before the first key and after the last one.
Values valuesAt(const Track& track, double time) {
  const bool cubic = track.interpolation == Track::Interpolation::cubic;
  const size_t keys = track.times.size(), width = track.values.size() / keys, count = cubic ? width / 3 : width;
  const auto part = [&](size_t key, size_t which) {
    const auto from = track.values.begin() + static_cast<ptrdiff_t>(key * width + which * count);
    return Values(from, from + static_cast<ptrdiff_t>(count));
  };
  const auto value = [&](size_t key) { return part(key, cubic ? 1 : 0); };
  const auto later = std::upper_bound(track.times.begin(), track.times.end(), time,
                                      [](double t, float key) { return t < double{key}; });
  if (later == track.times.begin()) return value(0);
  const auto b = static_cast<size_t>(later - track.times.begin()), a = b - 1;
  if (b == keys || track.interpolation == Track::Interpolation::step) return value(a);
  const double span = double{track.times[b]} - track.times[a], s = (time - track.times[a]) / span;
  if (!cubic && track.property == Track::Property::rotation) return slerp(value(a), value(b), s);
  Values result = value(a);
  const Values end = value(b);
  if (!cubic) {
    for (size_t i = 0; i < count; ++i) result[i] += s * (end[i] - result[i]);
    return result;
  }
  const Values out = part(a, 2), in = part(b, 0);
  const double s2 = s * s, s3 = s2 * s;
  for (size_t i = 0; i < count; ++i)
    result[i] = (2 * s3 - 3 * s2 + 1) * result[i] + span * (s3 - 2 * s2 + s) * out[i] + (3 * s2 - 2 * s3) * end[i] +
                span * (s3 - s2) * in[i];
  return result;
}

/// The properties of a node that a clip can change.
struct Local {
  Vec3 translation;
  Quaternion rotation;
  Vec3 scale;
  Values morphWeights;
};

void apply(const Track& track, double time, Local& local) {
  Values v = valuesAt(track, time);
  switch (track.property) {
    case Track::Property::translation: local.translation = {v[0], v[1], v[2]}; return;
    case Track::Property::rotation: local.rotation = {v[0], v[1], v[2], v[3]}; return;
    case Track::Property::scale: local.scale = {v[0], v[1], v[2]}; return;
    case Track::Property::morphWeights: local.morphWeights = std::move(v); return;
  }
}

double timeWithin(const Clip& clip, double seconds, ClipEnd end) {
  if (end == ClipEnd::hold) return std::clamp(seconds, 0.0, clip.duration);
  if (!(clip.duration > 0)) return 0;
  const double time = std::fmod(seconds, clip.duration);
  return time < 0 ? time + clip.duration : time;
}

Deformation deformationOf(const Mesh& mesh, const AnimatedInstance& animated, const SceneAnimation& animation,
                          const std::vector<Transform>& nodes, const Values& morphWeights) {
  Deformation deformation;
  if (mesh.jointCount > 0) {
    const Skin& skin = animation.skins[animated.skin];
    const Transform toMesh = inverse(animated.offset);
    for (size_t joint = 0; joint < skin.joints.size(); ++joint)
      deformation.joints.push_back(toMesh * nodes[skin.joints[joint]] * skin.inverseBinds[joint]);
  }
  deformation.morphWeights.assign(morphWeights.begin(), morphWeights.end());
  deformation.morphWeights.resize(mesh.morphTargets.size());
  return deformation;
}

}  // namespace

SceneState stateAt(const Scene& scene, const Clip& clip, double seconds, ClipEnd end) {
  if (!std::isfinite(seconds)) throw Error(ErrorCode::invalidArgument, "the time of a clip must be finite");
  const SceneAnimation& animation = scene.animation;
  std::vector<Local> locals;
  locals.reserve(animation.nodes.size());
  for (const Node& node : animation.nodes)
    locals.push_back(
        {node.translation, node.rotation, node.scale, {node.morphWeights.begin(), node.morphWeights.end()}});
  const double time = timeWithin(clip, seconds, end);
  for (const Track& track : clip.tracks) {
    if (track.node >= locals.size())
      throw Error(ErrorCode::invalidArgument, "the clip '" + clip.name + "' moves node " + std::to_string(track.node) +
                                                  ", and the scene has " + std::to_string(locals.size()) +
                                                  "; take a clip of this scene");
    apply(track, time, locals[track.node]);
  }

  std::vector<Transform> nodes;
  nodes.reserve(locals.size());
  for (size_t i = 0; i < locals.size(); ++i) {
    const Node& node = animation.nodes[i];
    const Transform local =
        node.matrix ? *node.matrix : composed(locals[i].translation, locals[i].rotation, locals[i].scale);
    nodes.push_back(node.parent == kNoNode ? local : nodes[node.parent] * local);
  }

  SceneState state;
  for (const Instance& instance : scene.instances) state.transforms.push_back(instance.transform);
  for (const Mesh& mesh : scene.meshes) state.deformations.push_back(mesh.deformation);
  for (const AnimatedInstance& animated : animation.instances) {
    const uint32_t mesh = scene.instances[animated.instance].mesh;
    state.transforms[animated.instance] =
        animation.root * (animated.skin == kNoSkin ? nodes[animated.node] * animated.offset : animated.offset);
    if (mesh == kNoMesh || !scene.meshes[mesh].deformable()) continue;
    state.deformations[mesh] =
        deformationOf(scene.meshes[mesh], animated, animation, nodes, locals[animated.node].morphWeights);
  }
  return state;
}

const Clip& clipNamed(const Scene& scene, const std::string& name) {
  const std::vector<Clip>& clips = scene.animation.clips;
  std::vector<std::string> names;
  std::vector<size_t> found;
  for (size_t i = 0; i < clips.size(); ++i) {
    names.push_back(clips[i].name);
    if (clips[i].name == name) found.push_back(i);
  }
  if (found.size() == 1) return clips[found[0]];
  if (found.size() > 1)
    throw Error(ErrorCode::invalidArgument, std::to_string(found.size()) + " clips are called '" + name +
                                                "'; choose one by its number, such as " + std::to_string(found[0]) +
                                                " or " + std::to_string(found[1]));
  size_t number = 0;
  const char* end = name.data() + name.size();
  const std::from_chars_result parsed = std::from_chars(name.data(), end, number);
  if (parsed.ec == std::errc() && parsed.ptr == end && number < clips.size()) return clips[number];
  throw Error(ErrorCode::invalidArgument,
              "no clip is called '" + name + "'; " +
                  (names.empty() ? "the scene has none" : nearestText(name, std::move(names))));
}

}  // namespace gnosphere
