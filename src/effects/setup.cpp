// SPDX-License-Identifier: Apache-2.0
#include "effects/setup.hpp"

#include <algorithm>
#include <bit>

namespace gnosphere {
namespace {

// What the device has of each material.
std::vector<gpu::Optics4> packedOptics(const Scene& scene, const SimulatorOptions& options) {
  std::vector<gpu::Optics4> result;
  for (const Optics& optics : opticsOf(scene, options.materials, options.effects.intensity.wavelength)) {
    const Material& material = scene.materials[result.size()];
    const bool mask = material.alphaMode == AlphaMode::mask;
    gpu::Optics4 packed = {};
    packed.reflection = {optics.reflectance, optics.gloss, optics.roughness, optics.retro};
    packed.passage = {optics.transmission, mask ? material.alphaCutoff : 0, material.baseColor[3],
                      std::bit_cast<float>(mask ? material.alphaImage : gpu::kNone)};
    result.push_back(packed);
  }
  return result;
}

}  // namespace

std::vector<EffectsSetup> setUpEffects(const Scene& scene, const std::vector<Sensor>& sensors,
                                       const SimulatorOptions& options) {
  const std::vector<gpu::Optics4> optics = packedOptics(scene, options);
  std::vector<EffectsSetup> result;
  for (const Sensor& sensor : sensors) {
    const PlannedEffects planned = planEffects(options, sensor, scene);
    result.push_back({planned, options.effects, optics, {}, sensor, static_cast<uint32_t>(result.size())});
    if (planned.has(gpu::kCutOuts)) result.back().alphaImages = scene.alphaImages;
  }
  return result;
}

bool anyPlans(const std::vector<EffectsSetup>& setups, bool (PlannedEffects::*asks)() const) {
  return std::any_of(setups.begin(), setups.end(), [&](const EffectsSetup& setup) { return (setup.planned.*asks)(); });
}

}  // namespace gnosphere
