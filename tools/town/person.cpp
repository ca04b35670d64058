// SPDX-License-Identifier: Apache-2.0
#include "town/prop.hpp"

namespace gnosphere::town {
namespace {

/// Adds a limb of two rods that meet in a knee or an elbow.
void addLimb(MeshBuilder& builder, Surface surface, const Vec3& joint, const Vec3& knee, const Vec3& end, double radius,
             int sides) {
  builder.rod(surface, joint, knee, radius, 0.78 * radius, sides);
  builder.rod(surface, knee, end, 0.8 * radius, 0.6 * radius, sides);
}

Loop ellipse(double z, double forward, double side, int sides) {
  Loop loop = circle({0, 0, z}, 1, sides);
  for (Vec3& p : loop) p = {forward * p.x, side * p.y, z};
  return loop;
}

}  // namespace

// A person 1.75 m tall that faces +x; even variants walk, odd ones stand.
Mesh personMesh(int variant, bool fine) {
  const int sides = fine ? 10 : 5;
  MeshBuilder builder;
  constexpr Surface kShirts[] = {Surface::clothRed, Surface::clothLight, Surface::clothBlue, Surface::clothDark};
  constexpr Surface kTrousers[] = {Surface::clothDark, Surface::clothBlue, Surface::clothLight};
  const Surface shirt = kShirts[variant % 4], trousers = kTrousers[variant % 3];
  const double step = variant % 2 == 0 ? 0.30 : 0.03;
  for (double side : {-1.0, 1.0}) {
    const double swing = side * step, y = 0.095 * side;
    const double lift = swing < -0.1 ? 0.06 : 0;
    addLimb(builder, trousers, {0, y, 0.92}, {0.55 * swing + 0.03, y, 0.50}, {swing, y, 0.09 + lift}, 0.085, sides);
    builder.box(Surface::rubber, {swing - 0.09, y - 0.045, lift}, {swing + 0.17, y + 0.045, 0.10 + lift});
    const double arm = -0.7 * swing;
    addLimb(builder, shirt, {0, 0.21 * side, 1.40}, {0.5 * arm - 0.02, 0.25 * side, 1.14},
            {arm + 0.06, 0.25 * side, 0.92}, 0.052, sides);
    builder.ellipsoid(Surface::skin, {arm + 0.07, 0.25 * side, 0.87}, {0.045, 0.035, 0.07}, 5, 3);
  }
  builder.loft(shirt, shirt,
               {ellipse(0.86, 0.11, 0.17, sides + 2), ellipse(1.02, 0.10, 0.155, sides + 2),
                ellipse(1.25, 0.12, 0.19, sides + 2), ellipse(1.42, 0.10, 0.19, sides + 2),
                ellipse(1.48, 0.06, 0.08, sides + 2)});
  builder.rod(Surface::skin, {0, 0, 1.45}, {0.01, 0, 1.56}, 0.055, 0.05, sides);
  builder.ellipsoid(Surface::skin, {0.02, 0, 1.63}, {0.095, 0.075, 0.12}, sides + 2, sides);
  builder.ellipsoid(Surface::hair, {0.0, 0, 1.665}, {0.095, 0.083, 0.10}, sides + 2, sides);
  if (variant % 3 == 1) builder.box(Surface::clothDark, {-0.26, -0.14, 1.02}, {-0.09, 0.14, 1.42});  // a rucksack
  return builder.finish("person");
}

}  // namespace gnosphere::town
