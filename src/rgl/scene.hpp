// SPDX-License-Identifier: Apache-2.0
// The scene that rays hit: meshes, textures and entities as the caller made them, and the simulator that has a copy.
#pragma once

#include <array>
#include <cstdint>
#include <gnosphere/simulator.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "rgl/math.hpp"
#include "rgl/objects.hpp"

namespace gnosphere::rgl {

inline constexpr size_t kNoIndex = ~size_t{0};

struct MeshObject {
  std::vector<Vec> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<rgl_vec2f> uvs;
  std::vector<rgl_bone_weights_t> weights;
  std::vector<Mat> restPoses;
  size_t index = kNoIndex;  ///< in the simulator
};

struct TextureObject {
  std::vector<uint8_t> texels;
  int32_t width = 0, height = 0;
};

/// A value that the caller sets from time to time, with the scene's time of the last two settings.
template <class T>
struct History {
  T now, before;
  std::optional<uint64_t> time, timeBefore;
  bool set = false;  ///< whether `now` was ever set

  void change(T value, std::optional<uint64_t> at) {
    if (set) {
      before = std::move(now);
      timeBefore = time;
    }
    now = std::move(value);
    time = at;
    set = true;
  }
};

struct EntityObject {
  std::shared_ptr<MeshObject> mesh;
  std::shared_ptr<TextureObject> texture;
  History<Mat> transform;
  History<std::vector<Vec>> vertices;  ///< of its own, if it is animated
  int32_t id = RGL_DEFAULT_ENTITY_ID;
  float retro = 0;
  std::vector<int32_t> ignoredBy;       ///< ids of sensors
  size_t instance = kNoIndex;           ///< in the simulator
  std::shared_ptr<MeshObject> ownMesh;  ///< with only its index in the simulator, if the entity is animated
  bool moved = false, deformed = false;

  const std::vector<Vec>& shape() const { return vertices.set ? vertices.now : mesh->vertices; }
  /// Gives the entity the shape that it has as its own, so that deform() needs no more memory.
  void keepShape() {
    if (!vertices.set) vertices.change(mesh->vertices, {});
  }
  void deform(std::vector<Vec> to, std::optional<uint64_t> at) {
    keepShape();
    vertices.change(std::move(to), at);
    deformed = true;
  }
};

/// The one scene of the library.
class SceneState {
 public:
  Objects<rgl_mesh_t, MeshObject> meshes{"Mesh"};
  Objects<rgl_texture_t, TextureObject> textures{"Texture"};
  Objects<rgl_entity_t, EntityObject> entities{"Entity"};
  std::optional<uint64_t> time, timeBefore;

  /// Adds an entity and gives it a handle.
  rgl_entity_t place(std::shared_ptr<EntityObject> entity);
  void remove(const std::shared_ptr<EntityObject>& entity);
  void clear();
  /// Must be called when the vertices of a mesh differ from those in the simulator. The next entity that uses the mesh
  /// then gets a new copy of it.
  void forget(MeshObject& mesh) { mesh.index = kNoIndex; }
  bool empty() const { return placed_.empty(); }

  /// Seconds between the last two times; nothing if there are none, or if they are the same.
  std::optional<double> timeStep() const;

  /// The simulator, with all changes since the last call, as a sensor of this id sees it.
  Simulator& simulator(int32_t sensorId);
  /// The entity that an instance of the simulator stands for.
  const EntityObject& entityOf(size_t instance) const { return *byInstance_[instance]; }
  /// Removes a sensor that was added to the simulator.
  void removeSensor(size_t sensor) {
    if (simulator_) simulator_->removeSensor(sensor);
  }

 private:
  Simulator& start();
  void add(EntityObject& entity);
  void upload(const std::shared_ptr<MeshObject>& mesh, const Mesh& content);
  void takeOut(EntityObject& entity);
  void removeUnused();

  std::unique_ptr<Simulator> simulator_;
  std::vector<std::shared_ptr<EntityObject>> placed_;
  std::vector<EntityObject*> byInstance_;
  struct Uploaded {
    std::shared_ptr<MeshObject> mesh;
    size_t index;
  };
  std::vector<Uploaded> uploaded_;  ///< the meshes in the simulator
};

SceneState& scene();

}  // namespace gnosphere::rgl
