// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "gnosphere/scene.hpp"

namespace gnosphere::town {

/// Materials of the town's objects: the value is the index in the town's Scene::materials.
enum class Surface : uint8_t {
  asphalt,
  roadPaint,
  kerb,
  paving,
  grass,
  gravel,
  brick,
  brickDark,
  plasterWhite,
  plasterSand,
  plasterRose,
  concrete,
  roofTile,
  roofSlate,
  roofFelt,
  windowGlass,
  shutter,
  wood,
  metal,
  metalDark,
  railing,
  awning,
  bark,
  leaf,
  leafDark,
  leafAutumn,
  needle,
  hedge,
  fence,
  paintWhite,
  paintSilver,
  paintBlack,
  paintRed,
  paintBlue,
  paintYellow,
  carGlass,
  rubber,
  rim,
  lampGlass,
  plastic,
  signRed,
  signBlue,
  signWhite,
  skin,
  hair,
  clothDark,
  clothLight,
  clothRed,
  clothBlue,
  count,
};

std::vector<Material> townMaterials();

}  // namespace gnosphere::town
