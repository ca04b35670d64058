// SPDX-License-Identifier: Apache-2.0
// The meshes whose vertices lie in buffers of the caller, in the arrays by which a device takes them.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "common/shared.h"
#include "geometry/flatten.hpp"
#include "geometry/ranges.hpp"
#include "geometry/scene_memory.hpp"

namespace gnosphere {

/// Positions of vertices in memory of the caller's device. Floats are the positions; an integer becomes value * scale +
/// offset, axis by axis.
struct CallerVertices {
  uint64_t address = 0, bytes = 0;  ///< of the first position; of the memory from there on
  uint32_t stride = 0;              ///< bytes from one position to the next
  uint32_t format = gpu::kVertexF32;
  std::array<float, 3> scale = {1, 1, 1}, offset = {};
};

/// Throws Error(invalidArgument) that begins with `name` if the buffer cannot have so many vertices.
void validate(const CallerVertices& buffer, size_t vertices, const std::string& name);

class VertexSources {
 public:
  explicit VertexSources(SceneMemory& memory) : memory_(memory) {}

  /// Whether the mesh's vertices come from a buffer.
  bool has(size_t mesh) const { return sources_.contains(mesh); }
  /// Adds a mesh, whose vertices are still to be set. `group` and `vertex` are its first entries in the arrays of all
  /// meshes.
  void add(size_t mesh, const FlatMesh& flat, uint64_t group, uint64_t vertex);
  void remove(size_t mesh);
  /// Sets the buffer of a mesh's vertices, which counts as a change of the vertices.
  void set(size_t mesh, const CallerVertices& buffer);
  /// All vertices must be taken again, because the arrays have moved.
  void takeAgain();
  /// The vertices of a mesh must be taken again, if they still come from a buffer.
  void takeAgain(size_t mesh) noexcept;

  /// Work of a device that takes vertices: an entry per mesh, and per group of its clusters the entry and the group.
  struct Work {
    std::vector<size_t> meshes;
    std::vector<gpu::VertexSource> sources;
    std::vector<gpu::CallerBuffer> buffers;
    std::vector<std::array<uint32_t, 2>> groups;
  };
  /// Returns what has changed since taken() was called.
  const Work& changed();
  /// Marks the work of changed() as done; must be called when a device takes that work.
  void taken();

  /// Numbers of triangles that a device has left out.
  struct Dropped {
    uint32_t nonFinite = 0, degenerate = 0;
  };
  /// Sets the numbers of a mesh.
  void setDropped(size_t mesh, const Dropped& dropped);
  /// The sum over all meshes.
  Dropped dropped() const;

 private:
  struct Entry {
    gpu::VertexSource source = {};
    uint64_t address = 0;
    uint64_t vertices = 0;  // of its clusters
    uint32_t firstGroup = 0, groups = 0;
    bool changed = false;
    Dropped dropped;
  };

  SceneMemory& memory_;
  std::map<size_t, Entry> sources_;  // by mesh
  Ranges numbers_;
  Work work_;
  bool anyChanged_ = false;
};

}  // namespace gnosphere
