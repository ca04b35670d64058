// SPDX-License-Identifier: Apache-2.0
// Hard cases of a triangle's position around the sensor. Every family has dozens of seeded worlds; `standard` and
// `exact` must compute every beam of every world right, and `paper` must fail, which shows that the family is hard.
#include "hardcases/hardcases.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

const int kShapeWorlds = rounds(120);

Scene oneTriangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  MeshBuilder builder;
  builder.triangle(a, b, c);
  return sceneOf(builder.take());
}

/// Sensors whose columns hit the axes and diagonals, miss them, or do not divide a turn.
std::vector<Sensor> sensorsAround() {
  return {allAround(96, 25), allAround(77, 24), gridSensor(131, 16, -30, 30)};
}

}  // namespace

TEST_CASE("hard: a triangle across the azimuth seam") {
  Family family("azimuth seam", sensorsAround());
  Random random(1);
  for (int i = 0; i < kShapeWorlds; ++i) {
    const double range = logUniform(random, 0.5, 100), width = logUniform(random, 1e-3, 1.5);
    const auto corner = [&](double side) {
      return along(directionAt(std::numbers::pi + side * width, random()), range * (1.2 + random()));
    };
    family.add(oneTriangle(corner(-1), corner(1), corner(random())), {}, random.bits() % 3);
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: a triangle with the pole inside") {
  Family family("pole inside a triangle", sensorsAround());
  Random random(2);
  for (int i = 0; i < kShapeWorlds; ++i) {
    const double height = (i % 2 ? 1 : -1) * logUniform(random, 0.01, 50), start = 3 * random();
    const auto corner = [&](int k) {
      const double azimuth = start + 2.0943951 * k + 0.4 * random(), out = logUniform(random, 1e-4, 100);
      return Vec3{out * std::cos(azimuth), out * std::sin(azimuth), height * (1.2 + random())};
    };
    family.add(oneTriangle(corner(0), corner(1), corner(2)), {}, random.bits() % 2);
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: a triangle around the sensor's axis, its edge or corner on the axis") {
  Family family("triangle around the axis", sensorsAround());
  Random random(3);
  for (int i = 0; i < kShapeWorlds; ++i) {
    const Vec3 onAxis = {0, 0, coarse(4 * random())};
    const double nudge = i % 4 == 3 ? std::ldexp(1.0, -8 - int(random.bits() % 22)) : 0;
    Vec3 a = coarse(anywhere(random, 5)), b = coarse(anywhere(random, 5)), c = coarse(anywhere(random, 5));
    if (i % 4 == 0) a = onAxis;                                      // a corner on the axis
    if (i % 4 != 0) b = {-a.x + nudge, -a.y, coarse(onAxis.z)};      // an edge through the axis
    if (i % 4 == 2) c = {-2 * a.x, -2 * a.y, coarse(3 * random())};  // a wall that contains the axis
    family.add(oneTriangle(a, b, c), {}, random.bits() % 2);
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: the sensor on a triangle's plane, edge or corner") {
  Family family("sensor on plane, edge, corner", sensorsAround());
  family.everyHitTies = true;  // a triangle through the sensor may be hit at any range
  Random random(4);
  for (int i = 0; i < kShapeWorlds; ++i) {
    Vec3 a = coarse(anywhere(random, 3)), b = coarse(anywhere(random, 3));
    if (i % 5 == 4) a.z = b.z = 0;
    const double s = 1 + random.bits() % 3, t = 1 + random.bits() % 3;
    MeshBuilder builder;
    if (i % 3 == 0) builder.triangle(a, b, {-s * a.x - t * b.x, -s * a.y - t * b.y, -s * a.z - t * b.z});  // its plane
    if (i % 3 == 1) builder.triangle(a, b, {-s * a.x, -s * a.y, -s * a.z});  // on its edge
    if (i % 3 == 2) builder.triangle(a, b, {});                              // on its corner
    builder.box({-7, -4, -2}, {9, 6, 5}, 2);
    family.add(sceneOf(builder.take()), {}, random.bits() % 3);
  }
  const Verdict verdict = requireRight(family);
  CHECK(verdict.misses == 0);
  CHECK(verdict.paperWrong > 0);
}

TEST_CASE("hard: the sensor inside a closed mesh") {
  Family family("sensor inside a closed mesh", sensorsAround());
  Random random(5);
  for (int i = 0; i < kShapeWorlds; ++i) {
    const double size = logUniform(random, 0.2, 60);
    const Vec3 inside = anywhere(random, 0.3 * size);
    Scene world;
    if (i % 2) {
      world = sceneOf(ball(6 + random.bits() % 6, 7 + random.bits() % 9, size));
    } else {
      MeshBuilder builder;
      builder.box({-size, -size, -size}, {size, size, size}, 1 + random.bits() % 4);
      world = sceneOf(builder.take());
    }
    const size_t sensor = random.bits() % 3;
    family.add(world, {inside, anyTurn(random)}, sensor);
  }
  const Verdict verdict = requireRight(family);
  CHECK(verdict.misses == 0);
  CHECK(verdict.paperWrong > 0);
}

TEST_CASE("hard: beams through shared edges and corners") {
  const Sensor sensor = allAround(48, 25, 500);
  Family family("shared edges and corners", {sensor});
  Random random(6);
  for (int i = 0; i < kShapeWorlds; ++i) {
    const uint32_t step = 1 + random.bits() % 3;
    const double size = std::ldexp(1.0, int(random.bits() % 7));
    const Mesh mesh = aimedMesh(sensor, step == 3 ? 4 : step, [&](const Vec3&) {
      return i % 4 == 0 ? size : i % 4 == 1 ? size * std::ldexp(1.0, int(random.bits() % 3)) : size * (1.5 + random());
    });
    Scene world = sceneOf(mesh);
    if (i % 8 >= 4)  // seen from the front in half of the worlds, from the back in the others
      for (size_t t = 0; t < mesh.triangleCount(); ++t)
        std::swap(world.meshes[0].indices[3 * t], world.meshes[0].indices[3 * t + 1]);
    Pose pose;
    if (i % 4 == 3) {  // mesh and sensor rotated in single precision, so that corners are off the beams by rounding
      const double angle = 3 * random();
      Mesh& turned = world.meshes[0];
      for (size_t v = 0; v < turned.vertexCount(); ++v) {
        float* p = &turned.positions[3 * v];
        const Vec3 q = rotationZ(angle) * Vec3{p[0], p[1], p[2]};
        p[0] = static_cast<float>(q.x), p[1] = static_cast<float>(q.y);
      }
      pose.orientation = {0, 0, std::sin(angle / 2), std::cos(angle / 2)};
    }
    family.add(world, pose);
  }
  const Verdict verdict = requireRight(family);
  CHECK(verdict.misses == 0);
  CHECK(verdict.paperWrong > 0);
}

TEST_CASE("hard: slivers, down to zero area") {
  Family family("slivers to zero area", sensorsAround());
  Random random(7);
  for (int i = 0; i < kShapeWorlds; ++i) {
    MeshBuilder builder;
    for (int k = 0; k < 20; ++k) {
      const Vec3 a = anywhere(random, 10), b = anywhere(random, 10);
      const double s = 0.5 * (random() + 1), width = k % 5 == 0 ? 0 : logUniform(random, 1e-9, 1);
      builder.triangle(a, b,
                       {a.x + s * (b.x - a.x) + width * random(), a.y + s * (b.y - a.y) + width * random(),
                        a.z + s * (b.z - a.z) + width * random()});
    }
    family.add(sceneOf(builder.take()), {}, random.bits() % 3);
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: grazing below 0.1 degrees") {
  Family family("grazing below 0.1 degrees",
                {gridSensor(180, 31, -0.1, 0.05, 4000), gridSensor(97, 21, -12, 12, 4000)});
  Random random(8);
  for (int i = 0; i < kShapeWorlds; ++i) {
    const double tilt = logUniform(random, 1e-6, 1.7e-3), azimuth = 3 * random();
    MeshBuilder builder;
    builder.quad({-30, -30, 0}, {90, 0, 0}, {0, 70, 0}, 1 + random.bits() % 3);
    Scene world = sceneOf(builder.take());
    // Either ground just below the sensor, or a wall seen nearly edge-on.
    if (i % 2)
      family.add(world, {{0, 0, 40 * tilt}, {std::sin(tilt / 2), 0, 0, std::cos(tilt / 2)}}, 0);
    else {
      world.instances[0].transform = Transform{{1, 0, 0, 5, 0, 0, -1, 0, 0, 1, 0, 0}};
      family.add(world, {{0, 20 * tilt, 0}, {0, 0, std::sin(azimuth / 2), std::cos(azimuth / 2)}}, 1);
    }
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: triangles nearer than 0.1 m") {
  Family family("range below 0.1 m", sensorsAround());
  Random random(9);
  for (int i = 0; i < kShapeWorlds; ++i) {
    const double range = logUniform(random, 1e-5, 0.1);
    Scene world = i % 2 ? sceneOf(ball(7, 9, range)) : sceneOf(soup(random.bits(), 60, 2 * range, range));
    family.add(world, {anywhere(random, 0.3 * range), anyTurn(random)}, random.bits() % 3);
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: one ground triangle several kilometres wide") {
  Family family("one ground triangle of kilometres",
                {gridSensor(90, 24, -25, 2, 5000), gridSensor(77, 24, -80, -0.05, 5000)}, 0x1p19);
  Random random(10);
  for (int i = 0; i < kShapeWorlds; ++i) {
    const double size = logUniform(random, 1e3, 1e5), turn = 3 * random();
    const auto corner = [&](int k) {
      return Vec3{size * std::cos(turn + 2.1 * k), size * std::sin(turn + 2.1 * k), 1e-3 * size * random()};
    };
    Vec3 c[3] = {corner(0), corner(1), corner(2)};
    family.add(oneTriangle(c[0], c[1], c[2]),
               {{0, 0, (c[0].z + c[1].z + c[2].z) / 3 + logUniform(random, 0.1, 20)}, {0, 0, 0, 1}}, random.bits() % 2);
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: triangles much smaller than a beam") {
  Family family("triangles smaller than a beam", {allAround(96, 25), gridSensor(300, 16, -15, 15)});
  Random random(11);
  for (int i = 0; i < kShapeWorlds; ++i) {
    const size_t sensor = random.bits() % 2;
    const Sensor& beams = family.sensors[sensor];
    MeshBuilder builder;
    for (int k = 0; k < 150; ++k) {  // on and next to some beams
      const Vec3 d = along(beams.direction(random.bits() % beams.beamCount()), 20 * (1.5 + random()));
      const double size = logUniform(random, 1e-5, 0.05);
      const auto corner = [&] { return Vec3{d.x + size * random(), d.y + size * random(), d.z + size * random()}; };
      builder.triangle(corner(), corner(), corner());
    }
    family.add(sceneOf(builder.take()), {}, sensor);
  }
  CHECK(requireRight(family).paperWrong > 0);
}

TEST_CASE("hard: coplanar duplicates") {
  Family family("coplanar duplicates", sensorsAround());
  family.everyHitTies = true;
  Random random(12);
  for (int i = 0; i < kShapeWorlds; ++i) {
    MeshBuilder builder;
    for (int k = 0; k < 8; ++k) {
      const Vec3 a = anywhere(random, 12), b = anywhere(random, 12), c = anywhere(random, 12);
      builder.triangle(a, b, c);
      builder.triangle(b, c, a);
      if (k % 2) builder.triangle(c, b, a);  // its other face
    }
    Scene world = sceneOf(builder.take(), i % 3 != 0);
    world.instances.push_back(world.instances[0]);
    family.add(world, {{}, i % 2 ? anyTurn(random) : Quaternion{}}, random.bits() % 3);
  }
  CHECK(requireRight(family).paperWrong > 0);
}
