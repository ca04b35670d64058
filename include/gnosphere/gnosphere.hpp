// SPDX-License-Identifier: Apache-2.0
// GnoSphere: a LiDAR simulator that never casts a ray. One include of the API, all but gnosphere/vulkan.hpp, which
// needs Vulkan's headers, gnosphere/ros2.hpp and gnosphere/eval.
#pragma once

#include "gnosphere/animation.hpp"
#include "gnosphere/batch.hpp"
#include "gnosphere/batch_stream.hpp"
#include "gnosphere/effects.hpp"
#include "gnosphere/error.hpp"
#include "gnosphere/options.hpp"
#include "gnosphere/output.hpp"
#include "gnosphere/plan.hpp"
#include "gnosphere/scan.hpp"
#include "gnosphere/scene.hpp"
#include "gnosphere/sensor.hpp"
#include "gnosphere/simulator.hpp"
