// SPDX-License-Identifier: Apache-2.0
// Scans of diffuse plates that tests compare with closed formulas of physics.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "effects/scan_support.hpp"

namespace gnosphere::test {

/// Bound on what the 4 % gloss of the roughest glTF surface adds to the diffuse part, at any angle.
inline constexpr double kGloss = 0.01;

struct Setup {
  std::string device;
  Scene scene;
  Sensor sensor;
  Effects effects = Effects::none();
  std::vector<Field> fields = {Field::intensity};

  Setup(std::string name, Scene what, Sensor with)
      : device(std::move(name)), scene(std::move(what)), sensor(std::move(with)) {
    effects.intensity.use = effects.radialSpeed.use = EffectUse::automatic;
  }
  TestOptions options() const {
    TestOptions result = optionsOn(device);
    result.effects = effects;
    result.fields = fields;
    return result;
  }
  Scan scan() const { return scanOn(scene, sensor, Pose{}, options()); }
};

/// A plate perpendicular to the x axis, with one (diffuse) reflectance.
struct Plate {
  double distance, half;
  float reflectance;
};

inline Scene platesOf(const std::vector<Plate>& plates) {
  Scene scene;
  for (const Plate& one : plates) {
    const auto index = static_cast<uint32_t>(scene.meshes.size());
    scene.materials.push_back(lambertian(one.reflectance));
    scene.meshes.push_back(plate(one.distance, one.half, index));
    scene.instances.push_back({"", index, {}});
  }
  return scene;
}

}  // namespace gnosphere::test
