// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <utility>

#include "town/plan.hpp"
#include "town/town.hpp"

using namespace gnosphere;
using town::Surface;

namespace {

// FNV-1a over all content that is written to a file.
class Hash {
 public:
  template <typename T>
  void add(const std::vector<T>& values) {
    addBytes(values.data(), values.size() * sizeof(T));
  }
  void addBytes(const void* data, size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < size; ++i) value = (value ^ bytes[i]) * 0x100000001b3u;
  }
  uint64_t value = 0xcbf29ce484222325u;
};

uint64_t hashOf(const Scene& scene) {
  Hash hash;
  for (const Mesh& mesh : scene.meshes) {
    hash.add(mesh.positions);
    hash.add(mesh.indices);
  }
  for (const Instance& instance : scene.instances) {
    hash.addBytes(&instance.mesh, sizeof instance.mesh);
    hash.addBytes(instance.transform.rows.data(), sizeof instance.transform.rows);
  }
  return hash.value;
}

Vec3 corner(const Mesh& mesh, size_t triangle, size_t k) {
  const float* p = &mesh.positions[3 * mesh.indices[3 * triangle + k]];
  return {p[0], p[1], p[2]};
}

Vec3 normalTimesTwiceArea(const Mesh& mesh, size_t triangle) {
  const Vec3 a = corner(mesh, triangle, 0);
  return cross(corner(mesh, triangle, 1) - a, corner(mesh, triangle, 2) - a);
}

/// The bodies of a mesh: triangles of single-sided materials that are connected by shared vertices. Bodies that only
/// touch may count as one, which does not affect the sums below.
struct Body {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;  ///< number of forward minus backward uses of each edge
  double volume = 0;
};

std::vector<Body> bodiesOf(const Mesh& mesh, const std::vector<Material>& materials) {
  std::vector<uint32_t> parent(mesh.vertexCount());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<size_t> solid;
  for (const MeshPart& part : mesh.parts)
    for (size_t t = part.firstTriangle;
         !materials[part.material].doubleSided && t < part.firstTriangle + part.triangleCount; ++t)
      solid.push_back(t);
  for (size_t t : solid)
    for (size_t k = 1; k < 3; ++k) parent[root(mesh.indices[3 * t + k])] = root(mesh.indices[3 * t]);
  std::map<uint32_t, Body> bodies;
  for (size_t t : solid) {
    Body& body = bodies[root(mesh.indices[3 * t])];
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = mesh.indices[3 * t + k], b = mesh.indices[3 * t + (k + 1) % 3];
      body.edges[std::minmax(a, b)] += a < b ? 1 : -1;
    }
    body.volume += dot(corner(mesh, t, 0), normalTimesTwiceArea(mesh, t)) / 6;
  }
  std::vector<Body> list;
  for (auto& [vertex, body] : bodies) list.push_back(std::move(body));
  return list;
}

/// One of every object that has an inside.
std::vector<town::Thing> solidThings() {
  using namespace town;
  std::vector<Thing> things;
  for (BuildingKind kind : {BuildingKind::rowHouse, BuildingKind::apartments, BuildingKind::office,
                            BuildingKind::shopHouse, BuildingKind::house, BuildingKind::hall, BuildingKind::church})
    for (RoofKind roof : {RoofKind::flat, RoofKind::gable, RoofKind::hip})
      for (int style = 0; style < 6; ++style) {
        Building building;
        building.kind = kind;
        building.roof = roof;
        building.style = style;
        building.openSides = style % 2 == 0;
        building.width = 8 + 2 * style;
        building.depth = 8 + style;
        building.floors = 1 + style;
        things.push_back(building);
      }
  for (VehicleKind kind :
       {VehicleKind::hatchback, VehicleKind::saloon, VehicleKind::estate, VehicleKind::van, VehicleKind::bus})
    for (bool fine : {false, true}) things.push_back(Vehicle{kind, Surface::paintRed, fine});
  for (TreeKind kind : {TreeKind::broadleaf, TreeKind::poplar, TreeKind::conifer, TreeKind::bush})
    for (int variant = 0; variant < 6; ++variant) things.push_back(Tree{kind, 300, variant});
  for (int kind = 0; kind <= static_cast<int>(PropKind::bicycle); ++kind)
    for (bool fine : {false, true}) things.push_back(Prop{static_cast<PropKind>(kind), kind, 6, fine});
  return things;
}

}  // namespace

TEST_CASE("a town has the requested number of triangles within ten percent") {
  const uint64_t triangles = GENERATE(10'000u, 30'000u, 100'000u, 300'000u, 1'000'000u, 3'000'000u, 10'000'000u);
  const uint32_t seed = GENERATE(1u, 2u, 77u);
  const double placed = static_cast<double>(makeTown({triangles, seed}).placedTriangleCount());
  CAPTURE(triangles, seed, placed);
  CHECK(std::abs(placed - static_cast<double>(triangles)) <= 0.1 * static_cast<double>(triangles));
}

TEST_CASE("a town is valid: indices are in range, every number is finite, no triangle is degenerate") {
  const uint64_t triangles = GENERATE(10'000u, 300'000u, 1'000'000u);
  const Scene scene = makeTown({triangles, 3});
  CHECK_NOTHROW(validate(scene));
  size_t notFinite = 0, degenerate = 0;
  for (const Mesh& mesh : scene.meshes) {
    INFO(mesh.name);
    for (float value : mesh.positions) notFinite += std::isfinite(value) ? 0 : 1;
    size_t here = 0;
    for (size_t t = 0; t < mesh.triangleCount(); ++t) {
      const Vec3 n = normalTimesTwiceArea(mesh, t);
      here += dot(n, n) > 1e-14 ? 0 : 1;
    }
    CHECK(here == 0);
    degenerate += here;
  }
  CHECK(notFinite == 0);
  CHECK(degenerate == 0);
}

TEST_CASE("the same seed gives the same town, another seed another one") {
  const uint64_t first = hashOf(makeTown({300'000, 1}));
  CHECK(first == hashOf(makeTown({300'000, 1})));
  CHECK(first == 0xe05653182e3a47ddu);  // the same on every machine; changes only with an intended change of the town
  CHECK(first != hashOf(makeTown({300'000, 2})));
}

TEST_CASE("the origin is on a street with room for a sensor, with the town around it") {
  const Scene scene = makeTown();
  const Bounds bounds = worldBounds(scene);
  CHECK(bounds.min.x < -90);
  CHECK(bounds.max.x > 90);
  CHECK(bounds.min.y < -90);
  CHECK(bounds.max.y > 90);
  CHECK(bounds.min.z > -0.2);
  CHECK(bounds.max.z > 10);
  bool isStreet = false;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (size_t v = 0; v < mesh.vertexCount(); ++v) {
      const float* q = &mesh.positions[3 * v];
      const Vec3 p = instance.transform * Vec3{q[0], q[1], q[2]};
      if (p.x == 0 && p.y == 0 && p.z == 0) isStreet = true;
      REQUIRE_FALSE((std::hypot(p.x, p.y) < 3 && p.z > 0.01));  // room for the sensor
    }
  }
  CHECK(isStreet);
}

TEST_CASE("solid objects are closed and face outwards") {
  const std::vector<Material> materials = town::townMaterials();
  for (const town::Thing& thing : solidThings()) {
    const Mesh mesh = town::meshOf(thing);
    INFO(mesh.name << ", kind " << thing.index());
    for (const Body& body : bodiesOf(mesh, materials)) {
      size_t open = 0;
      for (const auto& [edge, balance] : body.edges) open += balance == 0 ? 0 : 1;
      CHECK(open == 0);
      CHECK(body.volume > 0);
    }
  }
}

TEST_CASE("ground faces upwards") {
  using namespace town;
  const Thing thing = GENERATE(Thing{Road{4000, 520, false}}, Thing{Road{5000, 660, true}}, Thing{Crossing{520, 660}},
                               Thing{Crossing{520, 520}}, Thing{Block{6000, 7000, 350, Surface::grass}});
  const Mesh mesh = meshOf(thing);
  INFO(mesh.name);
  for (size_t t = 0; t < mesh.triangleCount(); ++t) {
    const Vec3 n = normalTimesTwiceArea(mesh, t);
    const bool isKerb = std::abs(n.z) < 1e-9;
    REQUIRE((isKerb || n.z > 0));
  }
}

TEST_CASE("glass is transparent, and thin sheets are double-sided") {
  const std::vector<Material> materials = town::townMaterials();
  CHECK(materials[static_cast<size_t>(Surface::windowGlass)].transmission > 0.5f);
  CHECK(materials[static_cast<size_t>(Surface::carGlass)].transmission > 0.5f);
  CHECK(materials[static_cast<size_t>(Surface::leaf)].doubleSided);
  CHECK_FALSE(materials[static_cast<size_t>(Surface::brick)].doubleSided);
}

TEST_CASE("sine and cosine are exact at quarter turns and close elsewhere") {
  CHECK(town::sine(0.25) == 1);
  CHECK(town::sine(-0.25) == -1);
  CHECK(town::cosine(0.5) == -1);
  CHECK(town::cosine(0.75) == 0);
  for (int i = -100; i < 100; ++i)
    CHECK(std::abs(town::sine(i / 37.0) - std::sin(6.283185307179586 * i / 37.0)) < 1e-11);
}
