// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>

#include "town/mesh_builder.hpp"

namespace gnosphere::town {

enum class PropKind : uint8_t {
  lamp,
  trafficLight,
  signStop,
  signDisc,
  signBlue,
  bench,
  bin,
  bollard,
  hydrant,
  busStop,
  kiosk,
  fence,  ///< `length` metres along x
  hedge,  ///< `length` metres along x
  person,
  bicycle,
};

/// A piece of street furniture, or a person. Props stand on z = 0; their front, if any, faces +x.
struct Prop {
  PropKind kind = PropKind::lamp;
  int variant = 0;
  int length = 0;
  bool fine = true;  ///< rounder people

  auto operator<=>(const Prop&) const = default;
};

Mesh propMesh(const Prop& prop);
Mesh personMesh(int variant, bool fine);  ///< in person.cpp

}  // namespace gnosphere::town
