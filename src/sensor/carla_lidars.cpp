// SPDX-License-Identifier: Apache-2.0
#include "sensor/carla_lidars.hpp"

#include <algorithm>

#include "base/json_text.hpp"

namespace gnosphere {
namespace {

using nlohmann::json;

bool hasCarlaType(const json& node, int depth) {
  if (node.is_object() && textIn(node, "type").starts_with("sensor.")) return true;
  if (!node.is_structured() || depth > 8) return false;
  return std::any_of(node.begin(), node.end(), [&](const json& child) { return hasCarlaType(child, depth + 1); });
}

void collect(const json& node, std::vector<const json*>& lidars, int depth) {
  if (node.is_object() && textIn(node, "type").starts_with("sensor.lidar.")) lidars.push_back(&node);
  if (node.is_structured() && depth < 50)
    for (const json& child : node) collect(child, lidars, depth + 1);
}

}  // namespace

bool isCarla(const json& root) {
  return hasCarlaType(root, 0);
}

bool lacksCarlaType(const json& root) {
  if (!root.is_object() || root.contains("type")) return false;
  const auto has = [&](const char* key) { return root.contains(key); };
  return (has("points_per_second") || has("rotation_frequency")) && !has("columns") && !has("elevation_deg") &&
         !has("patterns");
}

std::vector<const json*> carlaLidars(const json& root) {
  std::vector<const json*> lidars;
  collect(root, lidars, 0);
  return lidars;
}

std::string idsOf(const std::vector<const json*>& lidars) {
  std::string ids;
  for (const json* lidar : lidars) ids += (ids.empty() ? "" : ", ") + textIn(*lidar, "id");
  return ids;
}

bool hasCarlaEffects(const json& lidar) {
  return !textIn(lidar, "type").starts_with("sensor.lidar.ray_cast_semantic");
}

}  // namespace gnosphere
