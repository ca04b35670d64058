// SPDX-License-Identifier: Apache-2.0
// Parts that several JSON outputs share, so that they use the same names.
#pragma once

#include <nlohmann/json.hpp>

#include "gnosphere/eval/accuracy.hpp"
#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

using Json = nlohmann::ordered_json;

Json toJson(const DeviceInfo& device);
Json toJson(const Pose& pose);
Json toJson(const Comparison& comparison);
Json toJson(const Spread& spread);
Json sensorJson(const Sensor& sensor);
Json sceneJson(const Scene& scene);
/// Returns a row of the accuracy report: its plan, times and error.
Json toJson(const AccuracyRow& row, uint32_t runs, bool nearest);

std::string dump(const Json& json);  ///< ends with a line feed; invalid UTF-8 is replaced

}  // namespace gnosphere::cli
