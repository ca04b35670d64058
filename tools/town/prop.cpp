// SPDX-License-Identifier: Apache-2.0
#include "town/prop.hpp"

namespace gnosphere::town {
namespace {

/// Adds a thin plate that faces +x; its surface is double-sided.
void addPlate(MeshBuilder& builder, Surface surface, const Vec3& centre, double radius, int corners, double turns) {
  Loop loop;
  for (const Vec3& p : circle({}, radius, corners, turns)) loop.push_back(centre + Vec3{0, p.x, p.y});
  builder.fan(surface, loop, centre);
}

void addLamp(MeshBuilder& builder) {
  builder.rod(Surface::metal, {0, 0, -0.05}, {0, 0, 0.9}, 0.11, 0.10, 10);
  builder.rod(Surface::metal, {0, 0, 0.88}, {0, 0, 6.9}, 0.075, 0.045, 10);
  builder.rod(Surface::metal, {0, 0, 6.8}, {1.5, 0, 7.25}, 0.04, 0.035, 8);
  builder.box(Surface::metalDark, {1.3, -0.14, 7.2}, {2.1, 0.14, 7.32});
  builder.box(Surface::lampGlass, {1.38, -0.11, 7.15}, {2.02, 0.11, 7.21});
}

void addTrafficLight(MeshBuilder& builder) {
  builder.rod(Surface::metalDark, {0, 0, -0.05}, {0, 0, 3.4}, 0.07, 0.06, 10);
  builder.box(Surface::plastic, {0.06, -0.16, 2.4}, {0.30, 0.16, 3.35});
  const Surface lenses[] = {Surface::paintBlack, Surface::paintYellow, Surface::paintRed};
  for (int i = 0; i < 3; ++i) {
    const double z = 2.56 + 0.31 * i;
    builder.rod(lenses[i], {0.29, 0, z}, {0.32, 0, z}, 0.11, 0.11, 12);
    builder.box(Surface::plastic, {0.29, -0.13, z + 0.115}, {0.46, 0.13, z + 0.135});
  }
}

void addSign(MeshBuilder& builder, PropKind kind) {
  builder.rod(Surface::metal, {0, 0, -0.05}, {0, 0, 2.75}, 0.032, 0.032, 8);
  const Vec3 centre = {0.045, 0, 2.4}, front = {0.052, 0, 2.4};
  if (kind == PropKind::signStop) {
    addPlate(builder, Surface::signWhite, centre, 0.40, 8, 1.0 / 16);
    addPlate(builder, Surface::signRed, front, 0.36, 8, 1.0 / 16);
  } else if (kind == PropKind::signDisc) {
    addPlate(builder, Surface::signRed, centre, 0.34, 20, 0);
    addPlate(builder, Surface::signWhite, front, 0.25, 20, 0);
  } else {
    addPlate(builder, Surface::signWhite, centre, 0.42, 4, 0.125);
    addPlate(builder, Surface::signBlue, front, 0.37, 4, 0.125);
  }
}

void addBench(MeshBuilder& builder) {
  for (double y : {-0.7, 0.7}) {
    builder.box(Surface::metalDark, {-0.2, y - 0.03, -0.02}, {0.2, y + 0.03, 0.4});
    builder.box(Surface::metalDark, {-0.27, y - 0.03, 0.38}, {-0.21, y + 0.03, 0.84});
  }
  for (int i = 0; i < 3; ++i) {
    const double x = -0.19 + 0.14 * i, z = 0.5 + 0.13 * i;
    builder.box(Surface::wood, {x, -0.85, 0.41}, {x + 0.11, 0.85, 0.445});
    builder.box(Surface::wood, {-0.21, -0.85, z}, {-0.175, 0.85, z + 0.1});
  }
}

void addSmall(MeshBuilder& builder, PropKind kind) {
  if (kind == PropKind::bin) {
    builder.rod(Surface::metalDark, {0, 0, -0.02}, {0, 0, 0.85}, 0.22, 0.25, 12);
    builder.rod(Surface::metal, {0, 0, 0.84}, {0, 0, 0.92}, 0.27, 0.18, 12);
  } else if (kind == PropKind::bollard) {
    builder.rod(Surface::metalDark, {0, 0, -0.02}, {0, 0, 0.92}, 0.07, 0.06, 8);
  } else {
    builder.rod(Surface::paintRed, {0, 0, -0.02}, {0, 0, 0.66}, 0.11, 0.10, 8);
    builder.ellipsoid(Surface::paintRed, {0, 0, 0.66}, {0.12, 0.12, 0.13}, 8, 4);
    builder.rod(Surface::paintRed, {0, -0.2, 0.48}, {0, 0.2, 0.48}, 0.06, 0.06, 6);
  }
}

/// Adds a shelter, 4 m along y, open towards +x.
void addBusStop(MeshBuilder& builder) {
  for (double y : {-2.0, 0.0, 2.0}) builder.box(Surface::metalDark, {-0.75, y - 0.04, -0.02}, {-0.67, y + 0.04, 2.4});
  for (double y : {-2.0, 2.0}) builder.box(Surface::metalDark, {0.55, y - 0.04, -0.02}, {0.63, y + 0.04, 2.4});
  for (double y : {-1.94, 0.06}) builder.box(Surface::windowGlass, {-0.72, y, 0.25}, {-0.70, y + 1.88, 2.1});
  for (double y : {-2.0, 2.0}) builder.box(Surface::windowGlass, {-0.65, y - 0.01, 0.25}, {0.5, y + 0.01, 2.1});
  builder.box(Surface::metal, {-0.9, -2.2, 2.38}, {0.95, 2.2, 2.5});
  builder.box(Surface::wood, {-0.6, -1.6, 0.44}, {-0.2, 0.9, 0.5});
  for (double y : {-1.4, 0.7}) builder.box(Surface::metalDark, {-0.45, y - 0.03, -0.02}, {-0.35, y + 0.03, 0.45});
  builder.rod(Surface::metal, {0.7, 2.9, -0.05}, {0.7, 2.9, 2.9}, 0.04, 0.04, 8);
  builder.box(Surface::paintYellow, {0.68, 2.65, 2.3}, {0.72, 3.15, 2.85});
}

void addKiosk(MeshBuilder& builder) {
  builder.box(Surface::metalDark, {-1.2, -1.6, -0.02}, {1.2, 1.6, 2.5});
  builder.box(Surface::windowGlass, {1.18, -1.2, 1.05}, {1.23, 1.2, 2.1});
  builder.box(Surface::wood, {1.2, -1.3, 0.95}, {1.6, 1.3, 1.02});
  builder.box(Surface::paintYellow, {-1.4, -1.8, 2.48}, {1.7, 1.8, 2.66});
}

/// Adds a fence of pickets between two rails, as loose sheets.
void addFence(MeshBuilder& builder, int length) {
  const double end = length;
  for (int i = 0; i <= length / 2; ++i) {
    const double x = length < 2 ? 0 : end * i / (length / 2);
    builder.box(Surface::wood, {x - 0.045, -0.045, -0.05}, {x + 0.045, 0.045, 1.15});
  }
  for (double z : {0.25, 0.85})
    builder.quad(Surface::fence, {0, -0.015, z}, {end, -0.015, z}, {end, -0.015, z + 0.08}, {0, -0.015, z + 0.08});
  for (int i = 0; i < 6 * length; ++i) {
    const double x = (i + 0.5) / 6, top = 1.08;
    builder.quad(Surface::fence, {x - 0.045, 0.012, 0.06}, {x + 0.045, 0.012, 0.06}, {x + 0.045, 0.012, top - 0.07},
                 {x - 0.045, 0.012, top - 0.07});
    builder.triangle(Surface::fence, {x - 0.045, 0.012, top - 0.07}, {x + 0.045, 0.012, top - 0.07}, {x, 0.012, top});
  }
}

/// Adds a clipped hedge: loose leaves around a box, which is a darker core.
void addHedge(MeshBuilder& builder, int length) {
  Dice dice(length, 17);
  builder.box(Surface::bark, {0.1, -0.2, -0.05}, {length - 0.1, 0.2, 0.95});
  for (int i = 0; i < 60 * length; ++i) {
    const double x = dice.between(0, length), s = dice.between(-0.35, 0.35), z = dice.between(0.05, 1.25);
    const int face = dice.below(5);
    const Vec3 at = face < 2 ? Vec3{x, -0.35, z} : face < 4 ? Vec3{x, 0.35, z} : Vec3{x, s, 1.2};
    const Vec3 a = 0.13 * dice.direction();
    const Vec3 b = 0.13 * normalized(cross(a, {0.3, 0.5, 0.8124}));
    builder.triangle(Surface::hedge, at - 0.5 * b, at + 0.5 * b, at + a);
  }
}

void addBicycle(MeshBuilder& builder) {
  for (double x : {-0.52, 0.52}) {  // wheels: rings of ten sides
    constexpr int kSides = 10;
    const Loop ring = circle({}, 0.34, kSides);
    for (int i = 0; i < kSides; ++i) {
      const Vec3 a = ring[i], b = ring[(i + 1) % kSides];
      builder.rod(Surface::rubber, {x + a.x, 0, 0.35 + a.y}, {x + b.x, 0, 0.35 + b.y}, 0.02, 0.02, 3);
    }
  }
  const Vec3 rear = {-0.52, 0, 0.35}, front = {0.52, 0, 0.35}, pedal = {-0.05, 0, 0.3}, seat = {-0.2, 0, 0.85};
  const Vec3 head = {0.36, 0, 0.85};
  const Vec3 rods[][2] = {{rear, pedal}, {rear, seat}, {pedal, seat}, {pedal, head}, {seat, head}, {front, head}};
  for (const auto& r : rods) builder.rod(Surface::paintBlue, r[0], r[1], 0.02, 0.02, 4);
  builder.box(Surface::plastic, {-0.34, -0.07, 0.88}, {-0.06, 0.07, 0.94});
  builder.rod(Surface::metal, {0.33, -0.28, 0.98}, {0.33, 0.28, 0.98}, 0.015, 0.015, 6);
  builder.rod(Surface::metal, head, {0.33, 0, 0.98}, 0.018, 0.018, 6);
}

}  // namespace

Mesh propMesh(const Prop& prop) {
  MeshBuilder builder;
  switch (prop.kind) {
    case PropKind::lamp: addLamp(builder); return builder.finish("street lamp");
    case PropKind::trafficLight: addTrafficLight(builder); return builder.finish("traffic light");
    case PropKind::signStop:
    case PropKind::signDisc:
    case PropKind::signBlue: addSign(builder, prop.kind); return builder.finish("sign");
    case PropKind::bench: addBench(builder); return builder.finish("bench");
    case PropKind::bin: addSmall(builder, prop.kind); return builder.finish("litter bin");
    case PropKind::bollard: addSmall(builder, prop.kind); return builder.finish("bollard");
    case PropKind::hydrant: addSmall(builder, prop.kind); return builder.finish("hydrant");
    case PropKind::busStop: addBusStop(builder); return builder.finish("bus stop");
    case PropKind::kiosk: addKiosk(builder); return builder.finish("kiosk");
    case PropKind::fence: addFence(builder, prop.length); return builder.finish("fence");
    case PropKind::hedge: addHedge(builder, prop.length); return builder.finish("hedge");
    case PropKind::bicycle: addBicycle(builder); return builder.finish("bicycle");
    case PropKind::person: return personMesh(prop.variant, prop.fine);
  }
  return {};
}

}  // namespace gnosphere::town
