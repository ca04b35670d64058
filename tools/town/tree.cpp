// SPDX-License-Identifier: Apache-2.0
#include "town/tree.hpp"

#include <cmath>

namespace gnosphere::town {
namespace {

/// Adds a triangle about 15 cm long with random orientation. Crowns with fewer leaves have larger ones, so that they
/// are equally dense.
void addLeaf(MeshBuilder& builder, Dice& dice, Surface surface, const Vec3& at, double size) {
  const Vec3 along = dice.direction();
  Vec3 across = cross(along, dice.direction());
  while (dot(across, across) < 0.05) across = cross(along, dice.direction());
  const double length = size * dice.between(0.8, 1.3), width = 0.45 * size;
  across = normalized(across);
  builder.triangle(surface, at - 0.4 * length * along + width * across, at - 0.4 * length * along - width * across,
                   at + 0.6 * length * along);
}

void addTrunk(MeshBuilder& builder, Dice& dice, double height, double radius) {
  std::vector<Loop> rings;
  Vec3 at = {0, 0, -0.05};
  constexpr int kRings = 5;
  for (int i = 0; i < kRings; ++i) {
    const double share = static_cast<double>(i) / (kRings - 1);
    const double flare = i == 0 ? 1.5 : 1.0 - 0.6 * share;
    rings.push_back(circle(at, radius * flare, 8));
    at = at + Vec3{dice.between(-0.08, 0.08), dice.between(-0.08, 0.08), height / (kRings - 1)};
  }
  builder.loft(Surface::bark, Surface::bark, rings);
}

double leafSize(int leaves, int full) {
  return 0.17 * std::sqrt(static_cast<double>(full) / leaves);
}

void addBroadleaf(MeshBuilder& builder, const Tree& tree, Dice& dice) {
  const double crown = dice.between(1.7, 2.3), middle = dice.between(4.0, 4.8), tall = crown * dice.between(1.0, 1.25);
  const Surface leaf = tree.variant % 4 == 3   ? Surface::leafAutumn
                       : tree.variant % 2 == 0 ? Surface::leaf
                                               : Surface::leafDark;
  addTrunk(builder, dice, middle, 0.19);
  constexpr int kTufts = 16;
  Vec3 tufts[kTufts];
  for (int i = 0; i < kTufts; ++i) {
    const Vec3 d = dice.direction();
    const double far = dice.between(0.4, 0.75);
    tufts[i] = {far * crown * d.x, far * crown * d.y, middle + far * tall * d.z};
    const Vec3 fork = {0, 0, middle * dice.between(0.55, 0.9)};
    if (i % 2 == 0) builder.rod(Surface::bark, fork, tufts[i], 0.07, 0.02, 5);
  }
  const double size = leafSize(tree.leaves, 1000);
  for (int i = 0; i < tree.leaves; ++i) {
    const Vec3 d = dice.direction();
    const double far = 0.85 * std::sqrt(dice.uniform());
    addLeaf(builder, dice, leaf, tufts[i % kTufts] + far * d, size);
  }
}

void addPoplar(MeshBuilder& builder, const Tree& tree, Dice& dice) {
  const double height = dice.between(6.5, 9);
  addTrunk(builder, dice, height - 1.5, 0.17);
  const double size = leafSize(tree.leaves, 1000);
  for (int i = 0; i < tree.leaves; ++i) {
    const double up = dice.uniform(), bulge = 4 * up * (1 - up);
    const double turn = dice.uniform(), far = (0.2 + 0.75 * bulge) * std::sqrt(dice.uniform());
    addLeaf(builder, dice, Surface::leafDark, {far * cosine(turn), far * sine(turn), 1.6 + up * (height - 1.6)}, size);
  }
}

void addConifer(MeshBuilder& builder, const Tree& tree, Dice& dice) {
  const double height = dice.between(7, 10), reach = dice.between(1.7, 2.3);
  addTrunk(builder, dice, height - 0.4, 0.17);
  const int boughs = 40, perBough = tree.leaves / boughs;
  const double size = leafSize(tree.leaves, 900);
  for (int i = 0; i < boughs; ++i) {
    const double up = (i + dice.uniform()) / boughs, turn = dice.uniform();
    const double length = 0.25 + reach * (1 - up);
    const Vec3 root = {0, 0, 0.9 + up * (height - 1.0)};
    const Vec3 tip = root + Vec3{length * cosine(turn), length * sine(turn), -0.3 * length};
    for (int k = 0; k < perBough; ++k) {
      const double along = std::sqrt(dice.uniform());
      const Vec3 spread = 0.3 * (1.2 - along) * dice.direction();
      addLeaf(builder, dice, Surface::needle, root + along * (tip - root) + spread, size);
    }
  }
}

void addBush(MeshBuilder& builder, const Tree& tree, Dice& dice) {
  const double size = leafSize(tree.leaves, 250), radius = dice.between(0.5, 0.8);
  for (int i = 0; i < 4; ++i) {
    const Vec3 d = dice.direction();
    builder.rod(Surface::bark, {0, 0, -0.05}, {0.6 * radius * d.x, 0.6 * radius * d.y, radius}, 0.025, 0.01, 4);
  }
  for (int i = 0; i < tree.leaves; ++i) {
    const Vec3 d = dice.direction();
    const double far = 0.6 + 0.4 * dice.uniform();
    addLeaf(builder, dice, tree.variant % 2 == 0 ? Surface::leaf : Surface::hedge,
            {far * radius * d.x, far * radius * d.y, radius * (1.0 + 0.9 * far * d.z)}, size);
  }
}

}  // namespace

Mesh treeMesh(const Tree& tree) {
  MeshBuilder builder;
  Dice dice(7919, static_cast<uint64_t>(tree.kind), static_cast<uint64_t>(tree.variant));
  switch (tree.kind) {
    case TreeKind::broadleaf: addBroadleaf(builder, tree, dice); return builder.finish("broadleaf tree");
    case TreeKind::poplar: addPoplar(builder, tree, dice); return builder.finish("poplar");
    case TreeKind::conifer: addConifer(builder, tree, dice); return builder.finish("conifer");
    case TreeKind::bush: addBush(builder, tree, dice); return builder.finish("bush");
  }
  return {};
}

}  // namespace gnosphere::town
