// SPDX-License-Identifier: Apache-2.0
// Whole requests drawn at random: scene, head, effects, accuracy, fields, poses and motion together. The other tests
// vary one of these and hold the rest.
//
// GNOSPHERE_RANDOM_SEED=N looks for faults in requests that no test has tried: a test then draws request N and those
// after it. A failure names the number of the request, which is enough to draw the request again.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "support.hpp"

namespace gnosphere::test {

/// A step changes the scene, and then takes a shot.
struct Step {
  Shot shot;
  std::vector<std::pair<size_t, Transform>> transforms;      ///< by instance
  std::vector<std::pair<size_t, Deformation>> deformations;  ///< by mesh
  std::vector<Instance> added;
};

struct Request {
  Scene scene;
  std::vector<SensorRequest> sensors;
  SimulatorOptions options;
  std::vector<Step> steps;
  std::string text;  ///< what was drawn, for messages
};

/// Returns the request of a number; the same number gives the same request.
Request anyRequest(uint32_t number);

/// Makes the changes of a step.
void change(Simulator& simulator, const Step& step);

/// Returns the numbers of the requests that a test tries: one, or `most` with every combination.
std::vector<uint32_t> numbersToTry(uint32_t most);

}  // namespace gnosphere::test
