// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rivals/lines.hpp"
#include "rivals/rival.hpp"

namespace gnosphere::bench {

/// How Embree stores a scene. Embree always uses the robust mode and all cores.
enum class EmbreeWay {
  flat,       ///< all instances' triangles in one tree, optimised for tracing
  instanced,  ///< a tree per mesh and one over the instances, optimised for tracing
  rebuilt,    ///< one tree of low quality, rebuilt when anything has moved
  placed,     ///< as `instanced`, but the tree over the instances has low quality and is rebuilt when they have moved
  refitted,   ///< a tree per instance in world space, whose boxes are updated when vertices have moved
};

/// Whether the bench was built with Embree.
bool haveEmbree();

class EmbreeRival : public Rival {
 public:
  using Rival::trace;
  /// Follows every line through the panes, the triangles whose material lets light pass, to the first other surface.
  /// Lines are relative to the origin given to makeEmbree(). Returns the time in milliseconds.
  virtual double trace(const Lines& lines, const std::vector<bool>& paneMaterials, LineHits& hits) = 0;
};

/// Vertices are stored in single precision relative to `origin`, which should be near the sensor. build() must be
/// called first. The scene must outlive the rival. Throws Error(device) if built without Embree.
std::unique_ptr<EmbreeRival> makeEmbree(const Scene& scene, const Vec3& origin, EmbreeWay way);

}  // namespace gnosphere::bench
