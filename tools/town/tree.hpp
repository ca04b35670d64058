// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>

#include "town/mesh_builder.hpp"

namespace gnosphere::town {

enum class TreeKind : uint8_t { broadleaf, poplar, conifer, bush };

/// A tree with trunk, branches and a crown of loose leaves, standing on z = 0.
struct Tree {
  TreeKind kind = TreeKind::broadleaf;
  int leaves = 1000;
  int variant = 0;  ///< seed of its shape

  auto operator<=>(const Tree&) const = default;
};

Mesh treeMesh(const Tree& tree);

}  // namespace gnosphere::town
