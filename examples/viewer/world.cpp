// SPDX-License-Identifier: Apache-2.0
#include "world.hpp"

#include <array>
#include <cmath>

namespace viewer {
namespace {

using gnosphere::Mesh;

enum Paint : uint32_t { asphalt, pavement, ochre, brick, white, roof, glass, bark, leaf, red, blue, rubber, sign };

std::vector<gnosphere::Material> paints() {
  constexpr std::array<std::array<float, 3>, 13> kColours = {{{0.09f, 0.09f, 0.10f},
                                                              {0.35f, 0.34f, 0.33f},
                                                              {0.62f, 0.50f, 0.30f},
                                                              {0.42f, 0.18f, 0.13f},
                                                              {0.70f, 0.70f, 0.66f},
                                                              {0.22f, 0.12f, 0.10f},
                                                              {0.05f, 0.07f, 0.10f},
                                                              {0.16f, 0.10f, 0.06f},
                                                              {0.13f, 0.25f, 0.08f},
                                                              {0.50f, 0.05f, 0.05f},
                                                              {0.07f, 0.13f, 0.40f},
                                                              {0.03f, 0.03f, 0.03f},
                                                              {0.80f, 0.80f, 0.80f}}};
  std::vector<gnosphere::Material> result(kColours.size());
  for (size_t i = 0; i < result.size(); ++i)
    for (size_t k = 0; k < 3; ++k) result[i].baseColor[k] = kColours[i][k];
  result[sign].retro = 30;
  return result;
}

struct Box {
  float x0, x1, y0, y1, z0, z1;
};

// Adds a box whose upper face is narrower by `taper` metres on every side, as a part of the mesh.
void add(Mesh& mesh, Paint paint, const Box& box, float taperX = 0, float taperY = 0) {
  const auto first = static_cast<uint32_t>(mesh.vertexCount());
  const auto triangles = static_cast<uint32_t>(mesh.triangleCount());
  for (uint32_t corner = 0; corner < 8; ++corner) {
    const bool top = corner & 4;
    const float dx = top ? taperX : 0, dy = top ? taperY : 0;
    mesh.positions.insert(mesh.positions.end(), {corner & 1 ? box.x1 - dx : box.x0 + dx,
                                                 corner & 2 ? box.y1 - dy : box.y0 + dy, top ? box.z1 : box.z0});
  }
  for (const uint32_t corner : {0u, 2u, 1u, 1u, 2u, 3u, 4u, 5u, 6u, 5u, 7u, 6u, 0u, 1u, 4u, 1u, 5u, 4u,
                                2u, 6u, 3u, 3u, 6u, 7u, 0u, 4u, 2u, 2u, 4u, 6u, 1u, 3u, 5u, 3u, 7u, 5u})
    mesh.indices.push_back(first + corner);
  mesh.parts.push_back({triangles, 12, paint});
}

// Its front is at y = 0 and faces -y.
Mesh house(Paint paint, float width, float height, int floors, int windows) {
  Mesh mesh;
  add(mesh, paint, {0, width, 0, 9, 0, height});
  add(mesh, roof, {-0.4f, width + 0.4f, -0.4f, 9.4f, height, height + 3}, 1.5f, 4.7f);
  const float step = width / static_cast<float>(windows), floor = height / static_cast<float>(floors);
  for (int row = 0; row < floors; ++row)
    for (int column = 0; column < windows; ++column) {
      const float x = (static_cast<float>(column) + 0.5f) * step, z = (static_cast<float>(row) + 0.35f) * floor;
      add(mesh, white, {x - 0.65f, x + 0.65f, -0.12f, 0, z - 0.15f, z});
      add(mesh, glass, {x - 0.5f, x + 0.5f, -0.04f, 0, z, z + 0.5f * floor});
    }
  return mesh;
}

Mesh tree() {
  Mesh mesh;
  add(mesh, bark, {-0.15f, 0.15f, -0.15f, 0.15f, 0, 2.2f});
  add(mesh, leaf, {-1.5f, 1.5f, -1.5f, 1.5f, 2, 3.4f}, 0.3f, 0.3f);
  add(mesh, leaf, {-1.2f, 1.2f, -1.2f, 1.2f, 3.4f, 5.2f}, 0.7f, 0.7f);
  return mesh;
}

Mesh car(Paint paint) {
  Mesh mesh;
  add(mesh, paint, {-2.2f, 2.2f, -0.9f, 0.9f, 0.3f, 0.85f}, 0.08f, 0.05f);
  add(mesh, glass, {-1.7f, 1.1f, -0.82f, 0.82f, 0.85f, 1.4f}, 0.45f, 0.15f);
  add(mesh, paint, {-1.25f, 0.65f, -0.68f, 0.68f, 1.4f, 1.46f}, 0.1f, 0.1f);
  for (const float x : {-1.4f, 1.4f})
    for (const float y : {-0.95f, 0.75f}) add(mesh, rubber, {x - 0.32f, x + 0.32f, y, y + 0.2f, 0, 0.64f}, 0.1f, 0);
  return mesh;
}

Mesh post() {
  Mesh mesh;
  add(mesh, rubber, {-0.05f, 0.05f, -0.05f, 0.05f, 0, 2.6f});
  add(mesh, sign, {-0.06f, -0.05f, -0.4f, 0.4f, 1.9f, 2.7f});
  return mesh;
}

Mesh ground() {
  Mesh mesh;
  add(mesh, asphalt, {-60, 60, -5, 5, -0.2f, 0});
  for (const float y : {-40.0f, 5.0f}) add(mesh, pavement, {-60, 60, y, y + 35, -0.2f, 0.12f});
  return mesh;
}

// A place on the street, turned by half a turn about the z axis or not at all.
gnosphere::Transform at(double x, double y, bool turned = false) {
  gnosphere::Transform result;
  if (turned) result.rows[0] = result.rows[5] = -1;
  result.rows[3] = x;
  result.rows[7] = y;
  return result;
}

// The place on a way that is gone to and fro.
double along(double way, double distance) {
  const double place = std::fmod(distance, 2 * way);
  return place < way ? place : 2 * way - place;
}

}  // namespace

gnosphere::Pose World::sensorAt(double time) const {
  gnosphere::Pose pose;
  pose.position = {start.x + along(way, speed * time), start.y, start.z};
  return pose;
}

gnosphere::Transform World::Mover::at(double time) const {
  gnosphere::Transform result = start;
  result.rows[3] += std::copysign(along(way, std::abs(speed) * time), speed);
  return result;
}

World street() {
  World world;
  gnosphere::Scene& scene = world.scene;
  scene.materials = paints();
  scene.meshes = {ground(),
                  house(ochre, 12, 7, 2, 5),
                  house(brick, 9, 10, 3, 3),
                  house(white, 14, 8.5f, 3, 6),
                  tree(),
                  car(red),
                  car(blue),
                  car(white),
                  post()};
  const auto put = [&](const char* name, uint32_t mesh, const gnosphere::Transform& place) {
    scene.instances.push_back({name, mesh, place});
  };
  put("ground", 0, {});
  const auto anyCar = [&] { return 5 + static_cast<uint32_t>(scene.instances.size() % 3); };
  constexpr double kWidths[] = {12, 9, 14};
  double left = -52, right = 52;
  for (uint32_t i = 0; i < 8; ++i) {
    put("house", 1 + i % 3, at(left, 8.5));
    left += kWidths[i % 3] + 1.5;
    put("house", 1 + (i + 1) % 3, at(right, -8.5, true));
    right -= kWidths[(i + 1) % 3] + 1.5;
  }
  for (const double x : {-34.0, -21.0, -9.0, 3.0, 15.0, 27.0, 39.0}) {
    put("tree", 4, at(x, 6.3));
    put("tree", 4, at(x + 6, -6.3));
  }
  for (const double x : {-27.0, -12.5, 0.5, 13.0, 19.0, 33.0}) put("parked car", anyCar(), at(x, 4));
  for (const double x : {-18.0, -4.0, 8.5, 24.0}) put("parked car", anyCar(), at(x, -4, true));
  for (const double x : {-15.0, 10.0, 35.0}) put("sign", 8, at(x, -5.4));
  put("moving car", 5, at(10, 1.6, true));
  world.movers = {{scene.instances.size() - 1, scene.instances.back().transform, -8, 40}};
  world.start = {-12, -1.4, 1.9};
  return world;
}

}  // namespace viewer
