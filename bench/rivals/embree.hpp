// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rivals/rival.hpp"

namespace gnosphere::bench {

/// How Embree is asked to hold a scene. Always robust, on all cores.
enum class EmbreeWay {
  flat,       ///< every instance's triangles in one tree, made to be traced
  instanced,  ///< a tree per mesh and one over the instances, made to be traced
  rebuilt,    ///< one tree of low quality, built anew when anything has moved
  placed,     ///< as `instanced`, but the tree over the instances is of low quality and built anew when they have moved
  refitted,   ///< a tree per instance in world space, its boxes adapted when vertices have moved
};

/// Whether it was there when the bench was built.
bool haveEmbree();

/// Vertices are handed over in single precision relative to `origin`, which should be near the sensor. Nothing is
/// built yet. The scene must outlive the rival. Throws Error(device) without Embree.
std::unique_ptr<Rival> makeEmbree(const Scene& scene, const Vec3& origin, EmbreeWay way);

}  // namespace gnosphere::bench
