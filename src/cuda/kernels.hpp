// SPDX-License-Identifier: Apache-2.0
// The kernels of a scan: the shaders' text, compiled as CUDA, or as C++ for tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared.h"

namespace gnosphere::cuda {

/// As shaders/options.glsl names and orders them.
struct Options {
  uint32_t BOUNDS, CULL, INSIDE, RANGE;
  bool AZIMUTH_OFFSETS;
  uint32_t FACES, PASS, CULLING, EFFECTS, FIELDS, LAYERS, RETURNS;
};

/// What a kernel reads and writes: set 0 (a sensor and the work arrays), set 1 (a chunk of the scene), push constants.
struct Job {
  void* arrays[2][gpu::kWorkBindingCountEffects];
  gpu::Pass pass;
  Options options;
  uint32_t subRays;  ///< of a footprint
  bool moving;       ///< the sensor or instances move within the scan, or lasers are beside its origin
};

/// In the order of a scan, with the names of the shaders.
enum class Kernel {
  project_groups,
  project_clusters,
  project_occluders,
  project_triangles,
  bin,
  prefix_sum,
  resolve,
  effects_footprint,
  effects_surfaces,
  effects
};

inline const char* nameOf(Kernel kernel) {
  constexpr const char* names[] = {
      "project_groups", "project_clusters", "project_occluders", "project_triangles", "bin",
      "prefix_sum",     "resolve",          "effects_footprint", "effects_surfaces",  "effects"};
  return names[static_cast<size_t>(kernel)];
}

/// In the order of shaders/options.glsl.
inline std::vector<uint32_t> constantsOf(const Options& o) {
  return {o.BOUNDS, o.CULL,    o.INSIDE,  o.RANGE,  o.AZIMUTH_OFFSETS, o.FACES,
          o.PASS,   o.CULLING, o.EFFECTS, o.FIELDS, o.LAYERS,          o.RETURNS};
}

/// So many workgroups; the next launch sees what this one has written. Implemented twice: `parity` without contraction
/// of products and sums, `fast` as the compiler sees fit.
namespace parity {
void launch(Kernel kernel, const Job& job, uint32_t groupsX, uint32_t groupsY = 1);
}
namespace fast {
void launch(Kernel kernel, const Job& job, uint32_t groupsX, uint32_t groupsY = 1);
}

}  // namespace gnosphere::cuda
