// SPDX-License-Identifier: Apache-2.0
#include "rgl/scene.hpp"

#include <algorithm>
#include <cstdlib>
#include <gnosphere/error.hpp>

#include "base/room.hpp"
#include "rgl/fields.hpp"

namespace gnosphere::rgl {
namespace {

Transform transformOf(const Mat& from) {
  Transform to;
  for (int i = 0; i < 12; ++i) to.rows[i] = from.m[i / 4][i % 4];
  return to;
}

/// The mesh of the simulator. All meshes have the same material.
Mesh meshOf(const MeshObject& from, const std::vector<Vec>& vertices) {
  Mesh mesh;
  mesh.positions.resize(3 * vertices.size());
  for (size_t i = 0; i < vertices.size(); ++i) {
    mesh.positions[3 * i] = vertices[i].x;
    mesh.positions[3 * i + 1] = vertices[i].y;
    mesh.positions[3 * i + 2] = vertices[i].z;
  }
  for (const auto& triangle : from.triangles) mesh.indices.insert(mesh.indices.end(), triangle.begin(), triangle.end());
  mesh.parts = {{0, static_cast<uint32_t>(from.triangles.size()), 0}};
  return mesh;
}

}  // namespace

std::optional<double> SceneState::timeStep() const {
  if (!time || !timeBefore || *time == *timeBefore) return {};
  return (static_cast<double>(*time) - static_cast<double>(*timeBefore)) * 1e-9;
}

void SceneState::takeOut(EntityObject& entity) {
  if (entity.instance == kNoIndex) return;
  simulator_->removeInstance(entity.instance);
  byInstance_[entity.instance] = nullptr;
  entity.instance = kNoIndex;
}

rgl_entity_t SceneState::place(std::shared_ptr<EntityObject> entity) {
  makeRoom(placed_, placed_.size() + 1);
  const rgl_entity_t handle = entities.add(entity);
  placed_.push_back(std::move(entity));
  return handle;
}

void SceneState::remove(const std::shared_ptr<EntityObject>& entity) {
  takeOut(*entity);
  entity->ownMesh.reset();
  placed_.erase(std::find(placed_.begin(), placed_.end(), entity));
}

void SceneState::clear() {
  while (!placed_.empty()) remove(std::shared_ptr(placed_.back()));
  meshes.clear();
  textures.clear();
  entities.clear();
  time.reset();
  timeBefore.reset();
  removeUnused();
}

Simulator& SceneState::start() {
  if (simulator_) return *simulator_;
  const char* device = std::getenv("GNOSPHERE_RGL_DEVICE");
  SimulatorOptions options;
  options.faces = ReflectingFaces::both;
  options.warn = [](const std::string& message) { log(RGL_LOG_LEVEL_WARN, message); };
  Scene empty;
  empty.materials.resize(1);
  try {
    if (device) options.device = deviceByName(device);
    simulator_ = std::make_unique<Simulator>(empty, std::vector<SensorRequest>(), options);
  } catch (const Error& error) {
    throw Failure(RGL_INITIALIZATION_ERROR, error.what());
  }
  log(RGL_LOG_LEVEL_INFO,
      "GnoSphere's RGL compatibility layer at level 0." + std::to_string(level()) + " on " + simulator_->device().name);
  return *simulator_;
}

void SceneState::upload(const std::shared_ptr<MeshObject>& mesh, const Mesh& content) {
  makeRoom(uploaded_, uploaded_.size() + 1);
  mesh->index = simulator_->addMesh(content);
  uploaded_.push_back({mesh, mesh->index});
}

void SceneState::add(EntityObject& entity) {
  if (entity.vertices.set && !entity.ownMesh) entity.ownMesh = std::make_shared<MeshObject>();
  const std::shared_ptr<MeshObject>& mesh = entity.ownMesh ? entity.ownMesh : entity.mesh;
  if (mesh->index == kNoIndex) upload(mesh, meshOf(*entity.mesh, entity.shape()));
  makeRoom(byInstance_, byInstance_.size() + 1);
  entity.instance = simulator_->addInstance(static_cast<uint32_t>(mesh->index), transformOf(entity.transform.now));
  byInstance_.resize(std::max(byInstance_.size(), entity.instance + 1));
  byInstance_[entity.instance] = &entity;
}

Simulator& SceneState::simulator(int32_t sensorId) {
  start();
  for (const auto& entity : placed_) {
    const bool seen =
        std::find(entity->ignoredBy.begin(), entity->ignoredBy.end(), sensorId) == entity->ignoredBy.end();
    if (entity->deformed && (!entity->ownMesh || entity->ownMesh->index == kNoIndex)) {
      takeOut(*entity);  // it gets a mesh of its own
    } else if (entity->deformed) {
      const std::vector<Vec>& vertices = entity->vertices.now;
      simulator_->setPositions(entity->ownMesh->index, {&vertices[0].x, 3 * vertices.size()});
    }
    if (!seen) takeOut(*entity);
    if (seen && entity->instance == kNoIndex)
      add(*entity);
    else if (seen && entity->moved)
      simulator_->setTransform(entity->instance, transformOf(entity->transform.now));
    entity->deformed = false;
    entity->moved = entity->moved && !seen;
  }
  removeUnused();
  return *simulator_;
}

// Removes the meshes that neither the caller nor an entity has.
void SceneState::removeUnused() {
  for (size_t i = uploaded_.size(); i > 0; --i) {
    const Uploaded& each = uploaded_[i - 1];
    if (each.mesh.use_count() > 1 && each.mesh->index == each.index) continue;
    simulator_->removeMesh(each.index);  // if it throws, the mesh is removed another time
    uploaded_.erase(uploaded_.begin() + static_cast<ptrdiff_t>(i - 1));
  }
}

SceneState& scene() {
  static SceneState* const theScene = new SceneState;  // not destroyed: threads may call until the process ends
  return *theScene;
}

}  // namespace gnosphere::rgl
