// SPDX-License-Identifier: Apache-2.0
// The same names for the same things in every JSON that the tools write.
#pragma once

#include <nlohmann/json.hpp>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere::cli {

using Json = nlohmann::ordered_json;

Json toJson(const DeviceInfo& device);
Json toJson(const Pose& pose);
Json toJson(const Comparison& comparison);
Json toJson(const Spread& spread);
Json sensorJson(const Sensor& sensor);
Json sceneJson(const Scene& scene);
/// A row of the accuracy report: its plan, frame (times) and error.
Json toJson(const AccuracyRow& row, uint32_t runs, bool nearest);

std::string dump(const Json& json);  ///< with a line feed at the end; what is not UTF-8 is replaced

}  // namespace gnosphere::cli
