// SPDX-License-Identifier: Apache-2.0
// Instances of scenes that become actors, because they have boxes.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "drive/drive.hpp"

namespace gnosphere::drive {

/// Actors that stand where a scene has had them, and their models; Actor::model is an index into these.
struct StandingActors {
  std::vector<Scene> models;
  std::vector<Actor> actors;
};

/// Takes the instances for which `category` gives an index into Drive::classes out of a scene, which loses its
/// animation, too, and adds an actor for each of them. Its frame is upright, and has the x axis along the longer of
/// the two sides of its mesh that are level, so that a box has the length of its car.
void takeStanding(Scene& scene, const std::function<std::optional<size_t>(const Instance&)>& category,
                  StandingActors& standing);

}  // namespace gnosphere::drive
