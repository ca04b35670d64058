// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Where the instances and the vertices of a scene are at one moment.
struct SceneState {
  std::vector<Transform> transforms;      ///< by instance; for Simulator::setTransform()
  std::vector<Deformation> deformations;  ///< by mesh, empty unless it is deformable; for Simulator::setDeformation()
};

/// The state outside the time of a clip: the clip repeats, or its first or last state holds.
enum class ClipEnd { loop, hold };

/// The state of the scene `seconds` after the start of a clip of the scene. Everything that the clip does not move is
/// at rest: instances that follow no node keep their transform, and meshes that none of them places their deformation.
/// An empty Clip gives the state at rest. The scene must be valid, see validate(). Throws Error(invalidArgument) for a
/// time that is not finite, and for a clip of another scene that moves a node which this one does not have.
GNOSPHERE_API SceneState stateAt(const Scene& scene, const Clip& clip, double seconds, ClipEnd end = ClipEnd::loop);

/// The clip of this name, or, where none has it, of this number, counted from 0. Throws Error(invalidArgument) that
/// tells the nearest names, or the numbers of several clips that have the name.
GNOSPHERE_API const Clip& clipNamed(const Scene& scene, const std::string& name);

}  // namespace gnosphere
