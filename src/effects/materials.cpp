// SPDX-License-Identifier: Apache-2.0
// Optical properties of the scene's materials, with the rows of a material table applied.
#include <algorithm>
#include <map>

#include "base/text.hpp"
#include "effects/material_table.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {
namespace {

/// Sets `value` if the row states it (a negative number means not stated).
void take(float& value, float stated) {
  if (stated >= 0) value = stated;
}

}  // namespace

// glTF's metallic-roughness model (specification 2.0, appendix B): a dielectric reflects 4 % at its surface and its
// base colour diffusely, a metal has no diffuse part and lets no light through (KHR_materials_transmission mixes the
// transmitted light into the dielectric alone). Alpha is coverage: light passes through the uncovered share, and of the
// covered share of the dielectric `transmission` passes, which is then not reflected diffusely.
Optics opticsOf(const Material& material) {
  constexpr float kDielectric = 0.04f;
  const float red = std::clamp(material.baseColor[0], 0.0f, 1.0f);
  const float covered = material.alphaMode == AlphaMode::blend ? std::clamp(material.baseColor[3], 0.0f, 1.0f) : 1.0f;
  Optics optics;
  const float dielectric = 1 - material.metallic;
  optics.transmission = 1 - covered * (1 - dielectric * material.transmission);
  optics.reflectance = red * dielectric * covered * (1 - material.transmission);
  optics.gloss = covered * (kDielectric * dielectric + red * material.metallic);
  optics.roughness = material.roughness;
  optics.retro = material.retro;
  return optics;
}

std::vector<Optics> opticsOf(const Scene& scene, const MaterialTable& table, double wavelength,
                             std::vector<std::string>* unused) {
  validate(table);
  if (wavelength != 905 && wavelength != 1550)
    throw Error(ErrorCode::invalidArgument,
                "opticsOf: the wavelength must be 905 or 1550 nm, is " + numberText(wavelength));
  std::multimap<std::string, size_t> materials;
  for (size_t i = 0; i < scene.materials.size(); ++i) materials.emplace(lower(scene.materials[i].name), i);
  std::vector<Optics> optics;
  for (const Material& material : scene.materials) optics.push_back(opticsOf(material));
  std::vector<bool> measured(optics.size()), rough(optics.size());  // by material: what the table states
  for (const MaterialTable::Row& row : table.rows) {
    const auto [first, last] = materials.equal_range(lower(row.name));
    if (first == last && unused) unused->push_back(row.name);
    for (auto at = first; at != last; ++at) {
      Optics& one = optics[at->second];
      const float reflectance = wavelength == 1550 ? row.reflectance1550 : row.reflectance905;
      take(one.reflectance, reflectance);
      measured[at->second] = measured[at->second] || reflectance >= 0;
      rough[at->second] = rough[at->second] || row.roughness >= 0;
      take(one.roughness, row.roughness);
      take(one.retro, row.retro);
      take(one.transmission, row.transmission);
    }
  }
  // A measured reflectance has the light of the glossy lobe in it, unless the table says how rough the surface is.
  for (size_t i = 0; i < optics.size(); ++i)
    if (measured[i] && !rough[i]) optics[i].gloss = 0;
  return optics;
}

}  // namespace gnosphere
