// SPDX-License-Identifier: Apache-2.0
// Lidars in files of attributes as CARLA's sensors have them. The reader of sensors and that of effects share this.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace gnosphere {

/// Whether a JSON object, or one within it, has a type as CARLA's sensors do.
bool isCarla(const nlohmann::json& root);
/// Whether a JSON object has attributes of a CARLA lidar, but no type; and the sentence that refuses it.
bool lacksCarlaType(const nlohmann::json& root);
inline constexpr const char* kLacksCarlaType =
    "has attributes of a CARLA lidar, but no \"type\": add \"type\": \"sensor.lidar.ray_cast\"";

/// An attribute of a CARLA lidar that is a parameter of an effect here.
struct CarlaParameter {
  const char* attribute;
  const char* effect;  ///< empty for the seed, which belongs to all effects
  const char* parameter;
  bool zeroIsNews;  ///< true if CARLA's default is not zero
};
inline constexpr CarlaParameter kCarlaParameters[] = {
    {"noise_seed", "", "seed", false},
    {"atmosphere_attenuation_rate", "intensity", "attenuation", true},
    {"dropoff_general_rate", "drop-out", "general_rate", true},
    {"dropoff_intensity_limit", "drop-out", "intensity_limit", true},
    {"dropoff_zero_intensity", "drop-out", "zero_intensity_rate", true},
    {"noise_stddev", "range-noise", "sigma", false}};

/// Lists the lidars in a tree of objects, down to a depth that no real file has.
std::vector<const nlohmann::json*> carlaLidars(const nlohmann::json& root);
/// Returns the ids of lidars for a message.
std::string idsOf(const std::vector<const nlohmann::json*>& lidars);
/// Whether the attributes of a lidar say what its intensity, its drop-off and its noise are.
bool hasCarlaEffects(const nlohmann::json& lidar);

}  // namespace gnosphere
