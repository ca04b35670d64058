// SPDX-License-Identifier: Apache-2.0
// `exact` compared with exact arithmetic: every owner and every bit of every range, including ties, with every binning,
// and with and without double precision on the device.
#include <algorithm>

#include "hardcases/hardcases.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

struct Way {
  const char* name;
  Binning binning;
  bool float64;
};
constexpr Way kWays[] = {{"nearest", Binning::nearest, true},
                         {"lists", Binning::lists, true},
                         {"slabs", Binning::slabs, true},
                         {"nearest without doubles", Binning::nearest, false},
                         {"lists without doubles", Binning::lists, false}};

/// Checks every world of the family with every binning, and on CUDA. Unless `all`, two of the five ways are left out.
/// Returns the clouds of the exact oracle.
std::vector<Scan> requireExactEveryWay(const Family& family, bool all = everyCombination()) {
  needVulkan();
  std::vector<Scan> oracles;
  for (const Family::Visit& visit : family.visits)
    oracles.push_back(exactScan(family.scene, family.sensors[visit.sensor], visit.pose));
  for (const Way& way : kWays) {
    if (!all && (&way == &kWays[1] || &way == &kWays[3])) continue;
    TestOptions options = vulkanOptions();
    options.accuracy = Accuracy::exact;
    options.tuning.binning = way.binning;
    options.tuning.float64 = way.float64;
    Simulator simulator = makeSimulator(family.scene, family.sensors, options);
    for (size_t i = 0; i < family.visits.size(); ++i) {
      INFO(family.name << ", world " << i << ", " << way.name);
      requireExact(oracles[i], simulator.scan(family.visits[i].pose, family.visits[i].sensor));
    }
    if (!way.float64) continue;
    CudaOnHost onHost(family.scene, family.sensors, options);
    for (size_t i = 0; i < family.visits.size(); ++i) {
      INFO(family.name << ", world " << i << ", CUDA, " << way.name);
      requireExact(oracles[i], onHost.scan(family.visits[i].pose, family.visits[i].sensor));
    }
  }
  return oracles;
}

/// A sensor with columns and channels along the axes and the diagonals between them.
Sensor axisSensor() {
  Sensor sensor{"axes", 24, {}, 0, 500};
  for (int elevation = -90; elevation <= 90; elevation += 15) sensor.channels.push_back({double(elevation), 0});
  return sensor;
}

/// Grids on the faces of a box around the sensor, cut along beams: at multiples of its half size.
Mesh alignedBox(uint32_t cuts, double half, Random& random, bool turnSome) {
  MeshBuilder builder;
  builder.box({-half, -half, -half}, {half, half, half}, cuts);
  Mesh mesh = builder.take();
  for (size_t t = 0; turnSome && t < mesh.triangleCount(); ++t)
    if (random() < 0) std::swap(mesh.indices[3 * t], mesh.indices[3 * t + 1]);
  return mesh;
}

/// Triangles with corners on a small integer grid: many are coplanar with the sensor, have no area, or touch.
Mesh wholeSoup(Random& random, int count, int reach) {
  MeshBuilder builder;
  const auto whole = [&] { return double(int(random.bits() % (2 * reach + 1)) - reach); };
  for (int i = 0; i < count; ++i) {
    const auto corner = [&] { return Vec3{whole(), whole(), whole()}; };
    builder.triangle(corner(), corner(), corner());
  }
  return builder.take();
}

}  // namespace

TEST_CASE("exact: corners at integer metres, on the axes, at equal places, and triangles through the sensor") {
  Family family("whole soups", {axisSensor()});
  Random random(31);
  for (int i = 0; i < rounds(300); ++i) {
    const int reach = 1 + int(random.bits() % 6);
    family.add(sceneOf(wholeSoup(random, 30, reach), i % 3 != 0));
  }
  requireExactEveryWay(family);
}

TEST_CASE("exact: a closed mesh with corners and edges on beams has one hit per beam, with any winding") {
  const Sensor sensor = axisSensor();
  Family family("aligned boxes and balls", {sensor});
  Random random(32);
  for (int i = 0; i < rounds(200); ++i) {
    const double half = std::ldexp(1 + random.bits() % 3, -int(random.bits() % 5));
    Mesh mesh = i % 2 ? alignedBox(2 * (1 + random.bits() % 4), half, random, i % 4 == 3)
                      : aimedMesh(sensor, 1 + random.bits() % 2, [&](const Vec3&) {
                          return i % 4 ? half : half * std::ldexp(1.0, int(random.bits() % 3));
                        });
    family.add(sceneOf(std::move(mesh)));
  }
  requireExactEveryWay(family);
  for (const Family::Visit& visit : family.visits) {
    std::vector<uint32_t> layers;
    exactScan(family.scene, sensor, visit.pose, ReflectingFaces::material, &layers);
    for (uint32_t count : layers) REQUIRE(count == 1);
  }
}

TEST_CASE("exact: beams hit a closed mesh in front of the sensor twice or not at all, also at its outline") {
  needVulkan();
  const Sensor sensor = axisSensor();
  Family family("boxes in front", {sensor});
  Random random(33);
  for (int i = 0; i < rounds(150); ++i) {
    const auto whole = [&](int reach) { return double(int(random.bits() % (2 * reach + 1)) - reach); };
    const Vec3 low = {i % 2 ? 1 + double(random.bits() % 4) : whole(6), whole(4), whole(4)};
    MeshBuilder builder;
    builder.box(low, {low.x + 1 + double(random.bits() % 3), low.y + 2, low.z + 1}, 1 + random.bits() % 3);
    Scene world = sceneOf(builder.take(), false);
    if (low.x <= 0 && low.y <= 0 && low.z <= 0 && low.x + 3 >= 0 && low.y + 2 >= 0 && low.z + 1 >= 0) continue;
    family.add(world);
  }
  // Front faces alone and, with the mesh turned inside out, back faces alone: a beam hits both or neither, the back
  // face behind the front face.
  Family turned = family;
  for (Mesh& mesh : turned.scene.meshes)
    for (size_t t = 0; t < mesh.triangleCount(); ++t) std::swap(mesh.indices[3 * t], mesh.indices[3 * t + 1]);
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  Simulator fronts = makeSimulator(family.scene, family.sensors, options);
  Simulator backs = makeSimulator(turned.scene, turned.sensors, options);
  for (const Family::Visit& visit : family.visits) {
    const Scan front = fronts.scan(visit.pose), back = backs.scan(visit.pose);
    requireExact(exactScan(family.scene, sensor, visit.pose), front);
    requireExact(exactScan(turned.scene, sensor, visit.pose), back);
    std::vector<uint32_t> layers;
    exactScan(family.scene, sensor, visit.pose, ReflectingFaces::both, &layers);
    for (size_t b = 0; b < front.beamCount(); ++b) {
      REQUIRE(front.hit(b) == back.hit(b));
      REQUIRE(layers[b] == (front.hit(b) ? 2 : 0));
      if (front.hit(b)) REQUIRE(front.ranges[b] <= back.ranges[b]);
    }
  }
}

TEST_CASE("exact: a range window beyond the first hit finds the next layer, and each layer once") {
  needVulkan();
  // Shells around the sensor have corners on the beams: each beam hits each shell once, and the range window selects
  // one.
  Sensor sensor = axisSensor();
  Scene scene = sceneOf(aimedMesh(sensor, 1, [](const Vec3&) { return 1.0; }));
  scene.instances.clear();
  for (double size : {1.0, 2.0, 2.5, 8.0}) scene.instances.push_back({"", 0, scaling(size, size, size)});
  std::vector<Sensor> windows;
  std::vector<Scan> expected;
  for (double from : {0.0, 1.01, 2.01, 2.51, 8.1}) {
    sensor.rangeMin = from;
    windows.push_back(sensor);
  }
  TestOptions options = vulkanOptions();
  options.accuracy = Accuracy::exact;
  Simulator simulator = makeSimulator(scene, windows, options);
  for (uint32_t shell = 0; shell < 5; ++shell) {
    const Scan scan = simulator.scan({}, shell);
    CHECK(scan.counters.hits == (shell < 4 ? sensor.beamCount() : 0));
    for (size_t b = 0; shell < 4 && b < scan.beamCount(); ++b) REQUIRE(scan.instances[b] == shell);
  }
}

TEST_CASE("exact: random triangles, slivers and duplicates from any pose, with any kind of instance") {
  Sensor uneven = gridSensor(61, 17, -60, 80);
  for (size_t j = 0; j < uneven.channels.size(); j += 2) uneven.channels[j].azimuthOffsetDeg = 1.7 * double(j) - 9;
  Family family("soups from any pose", {axisSensor(), gridSensor(77, 16, -25, 25), uneven});
  Random random(34);
  for (int i = 0; i < rounds(200); ++i) {
    const double size = logUniform(random, 0.02, 30);
    Mesh mesh = soup(random.bits(), 50, size, size * logUniform(random, 0.01, 2));
    for (size_t v = 2; v + 3 < mesh.vertexCount(); v += 9)  // slivers: the third corner nearly on an edge
      for (size_t k = 0; k < 3; ++k)
        mesh.positions[3 * v + k] = 0.5f * (mesh.positions[3 * (v - 1) + k] + mesh.positions[3 * (v - 2) + k]);
    Scene world = sceneOf(std::move(mesh), i % 4 != 0);
    world.instances.push_back({"", 0, translation(size, 0, 0) * rotationZ(random()) * scaling(1, -1, 0.5)});
    if (i % 5 == 0) world.instances.push_back(world.instances[0]);
    family.add(world, {anywhere(random, size), anyTurn(random)}, random.bits() % 3);
  }
  requireExactEveryWay(family);
}

TEST_CASE("exact: ranges down to the last bit of the lattice") {
  // Planes that pass the sensor by less than a femtometre: only integer arithmetic decides on which side.
  Family family("planes through almost nothing", {axisSensor()});
  Random random(35);
  for (int i = 0; i < rounds(300); ++i) {
    MeshBuilder builder;
    for (int k = 0; k < 6; ++k) {
      const Vec3 a = coarse(anywhere(random, 0.1)), b = coarse(anywhere(random, 0.1));
      const double step = std::ldexp(1.0, -30 + int(random.bits() % 4));
      const Vec3 c = {-a.x - b.x + step * double(random.bits() % 3), -a.y - b.y, -a.z - b.z + step};
      builder.triangle(a, b, c);
    }
    family.add(sceneOf(builder.take()));
  }
  requireExactEveryWay(family);
}

TEST_CASE("exact: edges that nearly pass through the sensor") {
  // Such an edge spans half a great circle: rounding a corner moves its highest point all the way around.
  Family family("edges through almost the sensor", {axisSensor(), gridSensor(77, 48, -80, 80)});
  Random random(36);
  for (int i = 0; i < rounds(300); ++i) {
    MeshBuilder builder;
    for (int k = 0; k < 4; ++k) {
      const Vec3 a = coarse(anywhere(random, 5)), c = coarse(anywhere(random, 5));
      const double s = coarse(-logUniform(random, 0.1, 10)), off = logUniform(random, 1e-8, 0.1);
      builder.triangle(a, {s * a.x + off * random(), s * a.y + off * random(), s * a.z + off * random()}, c);
    }
    family.add(sceneOf(builder.take()), {}, random.bits() % 2);
  }
  requireExactEveryWay(family);
}

TEST_CASE("exact: the highest point of an edge that spans almost half a turn") {
  // Found by a search over a billion beams: in each case one beam lies between the exact and the rounded plane of an
  // edge.
  struct Found {
    uint32_t seed;
    int world;
    double offMin, offMax;
    size_t sensor;
  };
  Family family("almost half a turn", {gridSensor(48, 1500, -89, 89), gridSensor(180, 2000, -89, 89)});
  for (const Found& found : {Found{1, 238, 1e-6, 1e-2, 0}, Found{4, 43, 3e-4, 5e-3, 1}, Found{6, 135, 3e-4, 5e-3, 1}}) {
    Random random(found.seed);
    Vec3 a, b, c;
    for (int i = 0; i <= found.world; ++i) {
      a = coarse(anywhere(random, 5)), c = coarse(anywhere(random, 5));
      const double s = coarse(-logUniform(random, 0.1, 10)), off = logUniform(random, found.offMin, found.offMax);
      b = {s * a.x + off * random(), s * a.y + off * random(), s * a.z + off * random()};
    }
    MeshBuilder builder;
    builder.triangle(a, b, c);
    family.add(sceneOf(builder.take()), {}, found.sensor);
  }
  requireExactEveryWay(family);
}

TEST_CASE("exact: a plane that passes the sensor by less than a femtometre is hit, with and without double precision") {
  Family family("a femtometre", {axisSensor()});
  for (int i = 0; i < 8; ++i) {
    const double n = 16777215 - 1000 * i, half = std::floor(n / 2) + i, unit = 0x1p-30;
    MeshBuilder builder;
    builder.triangle({n * unit, 0, unit}, {0, n * unit, unit}, {-half * unit, (half - n - 1 - i % 2) * unit, -unit});
    family.add(sceneOf(builder.take()));
  }
  uint64_t hits = 0;
  for (const Scan& scan : requireExactEveryWay(family, true)) hits += scan.counters.hits;
  CHECK(hits > 0);
}

TEST_CASE("exact: a range halfway between two floats is rounded to even") {
  // The walls are slightly tilted, so that the beam along the x axis hits them halfway between two floats.
  Family family("halfway", {axisSensor()});
  std::vector<float> evens;
  for (int i = 0; i < 40; ++i) {
    const float near = std::ldexp(1 + static_cast<float>(i) * 0x1p-23f, i % 7 - 3);
    const float far = std::nextafter(near, 1000.0f);
    evens.push_back(i % 2 ? far : near);
    MeshBuilder builder;
    builder.triangle({near, -1, -1}, {far, 1, -1}, {near, -1, 3});
    family.add(sceneOf(builder.take()));
  }
  const std::vector<Scan> scans = requireExactEveryWay(family);
  constexpr size_t kForward = 6 * 24 + 12;  // elevation 0, azimuth 0
  for (size_t i = 0; i < scans.size(); ++i) REQUIRE(scans[i].ranges[kForward] == evens[i]);
}
