// SPDX-License-Identifier: Apache-2.0
#include "town/surfaces.hpp"

namespace gnosphere::town {
namespace {

struct Row {
  Surface surface;
  const char* name;
  float red, green, blue;
  float metallic, roughness, transmission;
  bool doubleSided;
};

// Colours of surfaces are linear. Surfaces without thickness are double-sided, solids are not.
constexpr Row kRows[] = {
    {Surface::asphalt, "asphalt", 0.06f, 0.06f, 0.065f, 0, 0.95f, 0, false},
    {Surface::roadPaint, "road paint", 0.80f, 0.80f, 0.78f, 0, 0.70f, 0, false},
    {Surface::kerb, "kerb stone", 0.42f, 0.41f, 0.39f, 0, 0.90f, 0, false},
    {Surface::paving, "paving", 0.30f, 0.29f, 0.27f, 0, 0.90f, 0, false},
    {Surface::grass, "grass", 0.09f, 0.19f, 0.05f, 0, 1.00f, 0, false},
    {Surface::gravel, "gravel", 0.33f, 0.29f, 0.23f, 0, 1.00f, 0, false},
    {Surface::brick, "brick", 0.36f, 0.12f, 0.08f, 0, 0.90f, 0, false},
    {Surface::brickDark, "dark brick", 0.19f, 0.09f, 0.07f, 0, 0.90f, 0, false},
    {Surface::plasterWhite, "white plaster", 0.74f, 0.72f, 0.67f, 0, 0.90f, 0, false},
    {Surface::plasterSand, "sand plaster", 0.60f, 0.47f, 0.28f, 0, 0.90f, 0, false},
    {Surface::plasterRose, "rose plaster", 0.56f, 0.33f, 0.26f, 0, 0.90f, 0, false},
    {Surface::concrete, "concrete", 0.38f, 0.37f, 0.36f, 0, 0.90f, 0, false},
    {Surface::roofTile, "roof tile", 0.34f, 0.10f, 0.05f, 0, 0.80f, 0, false},
    {Surface::roofSlate, "roof slate", 0.08f, 0.09f, 0.11f, 0, 0.70f, 0, false},
    {Surface::roofFelt, "roof felt", 0.16f, 0.15f, 0.15f, 0, 0.95f, 0, false},
    {Surface::windowGlass, "window glass", 0.55f, 0.65f, 0.70f, 0, 0.05f, 0.85f, false},
    {Surface::shutter, "shutter", 0.50f, 0.52f, 0.48f, 0, 0.60f, 0, false},
    {Surface::wood, "wood", 0.22f, 0.12f, 0.06f, 0, 0.80f, 0, false},
    {Surface::metal, "metal", 0.56f, 0.57f, 0.58f, 1, 0.45f, 0, false},
    {Surface::metalDark, "dark metal", 0.10f, 0.11f, 0.11f, 1, 0.55f, 0, false},
    {Surface::railing, "railing", 0.14f, 0.14f, 0.15f, 1, 0.50f, 0, true},
    {Surface::awning, "awning", 0.45f, 0.08f, 0.07f, 0, 0.85f, 0, true},
    {Surface::bark, "bark", 0.14f, 0.09f, 0.06f, 0, 1.00f, 0, false},
    {Surface::leaf, "leaf", 0.10f, 0.27f, 0.05f, 0, 0.75f, 0, true},
    {Surface::leafDark, "dark leaf", 0.05f, 0.16f, 0.04f, 0, 0.75f, 0, true},
    {Surface::leafAutumn, "autumn leaf", 0.48f, 0.24f, 0.04f, 0, 0.75f, 0, true},
    {Surface::needle, "needle", 0.03f, 0.12f, 0.05f, 0, 0.85f, 0, true},
    {Surface::hedge, "hedge", 0.06f, 0.18f, 0.05f, 0, 0.90f, 0, true},
    {Surface::fence, "fence", 0.34f, 0.24f, 0.15f, 0, 0.85f, 0, true},
    {Surface::paintWhite, "white car paint", 0.80f, 0.80f, 0.80f, 0.2f, 0.25f, 0, false},
    {Surface::paintSilver, "silver car paint", 0.46f, 0.48f, 0.50f, 0.7f, 0.25f, 0, false},
    {Surface::paintBlack, "black car paint", 0.02f, 0.02f, 0.025f, 0.3f, 0.20f, 0, false},
    {Surface::paintRed, "red car paint", 0.50f, 0.02f, 0.02f, 0.3f, 0.25f, 0, false},
    {Surface::paintBlue, "blue car paint", 0.03f, 0.09f, 0.36f, 0.3f, 0.25f, 0, false},
    {Surface::paintYellow, "yellow car paint", 0.80f, 0.50f, 0.03f, 0.1f, 0.30f, 0, false},
    {Surface::carGlass, "car glass", 0.25f, 0.30f, 0.32f, 0, 0.03f, 0.70f, false},
    {Surface::rubber, "rubber", 0.02f, 0.02f, 0.02f, 0, 0.95f, 0, false},
    {Surface::rim, "wheel rim", 0.60f, 0.60f, 0.62f, 1, 0.35f, 0, false},
    {Surface::lampGlass, "lamp glass", 0.85f, 0.82f, 0.70f, 0, 0.20f, 0.50f, false},
    {Surface::plastic, "plastic", 0.05f, 0.05f, 0.055f, 0, 0.60f, 0, false},
    {Surface::signRed, "red sign", 0.60f, 0.02f, 0.02f, 0, 0.35f, 0, true},
    {Surface::signBlue, "blue sign", 0.02f, 0.10f, 0.50f, 0, 0.35f, 0, true},
    {Surface::signWhite, "white sign", 0.85f, 0.85f, 0.85f, 0, 0.35f, 0, true},
    {Surface::skin, "skin", 0.55f, 0.33f, 0.23f, 0, 0.60f, 0, false},
    {Surface::hair, "hair", 0.06f, 0.04f, 0.03f, 0, 0.80f, 0, false},
    {Surface::clothDark, "dark cloth", 0.05f, 0.06f, 0.09f, 0, 0.95f, 0, false},
    {Surface::clothLight, "light cloth", 0.58f, 0.54f, 0.46f, 0, 0.95f, 0, false},
    {Surface::clothRed, "red cloth", 0.46f, 0.06f, 0.06f, 0, 0.95f, 0, false},
    {Surface::clothBlue, "blue cloth", 0.08f, 0.16f, 0.40f, 0, 0.95f, 0, false},
};

constexpr bool inOrder() {
  for (size_t i = 0; i < std::size(kRows); ++i)
    if (static_cast<size_t>(kRows[i].surface) != i) return false;
  return std::size(kRows) == static_cast<size_t>(Surface::count);
}
static_assert(inOrder(), "one row per surface, in the order of the enum");

}  // namespace

std::vector<Material> townMaterials() {
  std::vector<Material> materials;
  for (const Row& row : kRows) {
    Material material;
    material.name = row.name;
    material.baseColor = {row.red, row.green, row.blue, 1};
    material.metallic = row.metallic;
    material.roughness = row.roughness;
    material.transmission = row.transmission;
    material.doubleSided = row.doubleSided;
    materials.push_back(material);
  }
  return materials;
}

}  // namespace gnosphere::town
