// SPDX-License-Identifier: Apache-2.0
#include "drive/drive.hpp"

#include <algorithm>
#include <cmath>

#include "base/hash.hpp"
#include "drive/fingerprint.hpp"
#include "drive/pose_math.hpp"

namespace gnosphere::drive {
namespace {

void add(Hasher& hasher, const Deformation& deformation) {
  hasher.add(deformation.joints);
  hasher.add(deformation.morphWeights);
}

void add(Hasher& hasher, const SceneAnimation& animation) {
  hasher.add(animation.root.rows.data(), sizeof(animation.root.rows));
  for (const Node& node : animation.nodes) {
    const Vec3 &t = node.translation, &s = node.scale;
    const Quaternion& r = node.rotation;
    const double numbers[] = {t.x, t.y, t.z, r.x, r.y, r.z, r.w, s.x, s.y, s.z};
    hasher.add(&node.parent, sizeof(node.parent));
    hasher.add(numbers, sizeof(numbers));
    if (node.matrix) hasher.add(node.matrix->rows.data(), sizeof(node.matrix->rows));
    hasher.add(node.morphWeights);
  }
  for (const Skin& skin : animation.skins) {
    hasher.add(skin.joints);
    hasher.add(skin.inverseBinds);
  }
  for (const Clip& clip : animation.clips) {
    hasher.add(clip.name);
    hasher.add(&clip.duration, sizeof(clip.duration));
    for (const Track& track : clip.tracks) {
      const uint32_t words[] = {track.node, static_cast<uint32_t>(track.property),
                                static_cast<uint32_t>(track.interpolation)};
      hasher.add(words, sizeof(words));
      hasher.add(track.times);
      hasher.add(track.values);
    }
  }
  for (const AnimatedInstance& animated : animation.instances) {
    const uint32_t words[] = {animated.instance, animated.node, animated.skin};
    hasher.add(words, sizeof(words));
    hasher.add(animated.offset.rows.data(), sizeof(animated.offset.rows));
  }
}

void add(Hasher& hasher, const Scene& scene) {
  add(hasher, scene.animation);
  for (const Mesh& mesh : scene.meshes) {
    hasher.add(&mesh.origin, sizeof(mesh.origin));
    hasher.add(mesh.positions);
    hasher.add(mesh.indices);
    hasher.add(mesh.uvs);
    hasher.add(mesh.parts);
    hasher.add(mesh.joints);
    hasher.add(mesh.jointWeights);
    for (const std::vector<float>& target : mesh.morphTargets) hasher.add(target);
    add(hasher, mesh.deformation);
  }
  for (const Material& material : scene.materials) {
    hasher.add(material.name);
    hasher.add(material.baseColor.data(), sizeof(material.baseColor));
    const float numbers[] = {material.metallic,
                             material.roughness,
                             material.transmission,
                             material.alphaCutoff,
                             material.retro,
                             material.doubleSided ? 1.0f : 0.0f,
                             static_cast<float>(material.alphaMode)};
    hasher.add(numbers, sizeof(numbers));
    hasher.add(&material.alphaImage, sizeof(material.alphaImage));
    hasher.add(&material.classId, sizeof(material.classId));
  }
  for (const AlphaImage& image : scene.alphaImages) {
    const uint32_t numbers[] = {image.width, image.height, static_cast<uint32_t>(image.wrapU),
                                static_cast<uint32_t>(image.wrapV)};
    hasher.add(numbers, sizeof(numbers));
    hasher.add(image.alpha);
  }
  for (const Instance& instance : scene.instances) {
    hasher.add(instance.name);
    hasher.add(&instance.mesh, sizeof(instance.mesh));
    hasher.add(instance.transform.rows.data(), sizeof(instance.transform.rows));
    hasher.add(&instance.classId, sizeof(instance.classId));
  }
}

/// Another number whenever the same drive makes other frames than before.
constexpr std::string_view kFrames = "frames 4";

}  // namespace

std::string fingerprintOf(const Drive& drive, std::string_view driveFile) {
  Hasher hasher;
  hasher.add(kFrames);
  hasher.add(driveFile);
  hasher.add(drive.name);
  for (const Scene& scene : drive.scenes) add(hasher, scene);
  for (const Scene& model : drive.models) add(hasher, model);
  for (const MaterialTable::Row& row : drive.materials.rows) {
    hasher.add(row.name);
    const float numbers[] = {row.reflectance905, row.reflectance1550, row.roughness, row.retro, row.transmission};
    hasher.add(numbers, sizeof(numbers));
  }
  hasher.add(drive.ego.stamps());
  for (const Actor& actor : drive.actors) hasher.add(actor.trajectory.stamps());
  for (const RigSensor& sensor : drive.sensors) {
    hasher.add(toJson(sensor.sensor));
    hasher.add(toJson(sensor.effects));
  }
  return hasher.hex();
}

uint64_t Drive::frameCount() const {
  return static_cast<uint64_t>(std::max(1.0, std::ceil(duration * rate - 1e-6)));
}

Pose Drive::sensorPose(size_t sensor, double time) const {
  return ego.at(time) * sensors[sensor].mount;
}

std::optional<Weather> Drive::weatherAt(double time) const {
  if (weather.empty()) return {};
  const auto later = [](double t, const WeatherStamp& stamp) { return t < stamp.time; };
  const auto next = std::upper_bound(weather.begin(), weather.end(), time - start, later);
  const WeatherStamp& b = next == weather.end() ? weather.back() : *next;
  const WeatherStamp& a = next == weather.begin() ? b : *(next - 1);
  const double share = b.time > a.time ? std::clamp((time - start - a.time) / (b.time - a.time), 0.0, 1.0) : 0;
  const auto between = [&](double WeatherStamp::*value) { return a.*value + share * (b.*value - a.*value); };
  const double fog = between(&WeatherStamp::fog);
  Weather result;
  result.visibility = fog > 0 ? 1 / fog : 0;
  result.rainRate = between(&WeatherStamp::rain);
  result.snowRate = between(&WeatherStamp::snow);
  return result;
}

}  // namespace gnosphere::drive
