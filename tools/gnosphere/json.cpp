// SPDX-License-Identifier: Apache-2.0
#include "json.hpp"

#include <cmath>

#include "base/json_text.hpp"
#include "option_table.hpp"

namespace gnosphere::cli {
namespace {

/// JSON has no infinity; it is written as null.
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json histogramJson(const NearestHistogram& nearest) {
  Json bins = Json::array();
  for (size_t bin = 0; bin < nearest.size(); ++bin) {
    bins.push_back({{"from_m", bin ? kNearestBins[bin - 1] : 0.0},
                    {"to_m", bin < kNearestBins.size() ? Json(kNearestBins[bin]) : Json()},
                    {"points", nearest[bin]}});
  }
  return bins;
}

}  // namespace

Json toJson(const DeviceInfo& device) {
  return {{"name", device.name},
          {"type", device.type},
          {"driver", device.driver},
          {"api_version", device.apiVersion},
          {"max_buffer_bytes", device.maxBufferBytes},
          {"subgroup_size", device.subgroupSize}};
}

Json toJson(const Pose& pose) {
  return {{"position", listOf(pose.position)},
          {"orientation_xyzw", {pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w}}};
}

Json toJson(const Comparison& c) {
  return {
      {"beams", c.beams},
      {"hits", c.hits},
      {"missed", c.missed},
      {"false_hits", c.falseHits},
      {"wrong_owner", c.wrongOwner},
      {"wrong_range", c.wrongRange},
      {"ties", c.ties},
      {"tie_differences", c.tieDifferences},
      {"in_ties",
       {{"missed", c.tieMissed},
        {"false_hits", c.tieFalseHits},
        {"wrong_owner", c.tieWrongOwner},
        {"error_max_m", number(c.tieErrorMax)}}},
      {"range_error_m",
       {{"max", number(c.rangeErrorMax)}, {"p99_99", number(c.rangeError9999)}, {"rms", number(c.rangeErrorRms)}}},
      {"any_owner_error_max_m", number(c.hitErrorMax)},
      {"wrong_point", c.wrongPoint},
      {"point_error_max_m", number(c.pointErrorMax)},
      {"same", c.same()},
  };
}

Json toJson(const Spread& spread) {
  return {{"median", spread.median}, {"min", spread.min}, {"p10", spread.p10}, {"p90", spread.p90}};
}

Json sensorJson(const Sensor& sensor) {
  return {{"name", sensor.name},
          {"beams", sensor.beamCount()},
          {"columns", sensor.columns},
          {"channels", sensor.channels.size()},
          {"range", {{"min", sensor.rangeMin}, {"max", sensor.rangeMax}}}};
}

Json sceneJson(const Scene& scene) {
  return {{"triangles", scene.placedTriangleCount()},
          {"unique_triangles", scene.uniqueTriangleCount()},
          {"instances", scene.instances.size()},
          {"meshes", scene.meshes.size()}};
}

Json toJson(const AccuracyRow& row, uint32_t runs, bool nearest) {
  Json stages = Json::array(), times = Json::object();
  for (const StageTime& stage : row.stages) {
    stages.push_back(stage.name);
    times[stage.name] = stage.ms;
  }
  const auto word = [](const char* part, auto value) {
    return wordsOf(std::string("accuracy_parts.") + part)[static_cast<size_t>(value)].name;
  };
  Json json;
  json["name"] = row.name;
  json["plan"] = {{"stages", stages},
                  {"bounds", word("bounds", row.accuracyParts.bounds)},
                  {"cull", word("cull", row.accuracyParts.cull)},
                  {"inside", word("inside", row.accuracyParts.inside)},
                  {"range", word("range", row.accuracyParts.range)}};
  json["frame"] = {{"runs", runs},
                   {"wall_ms", toJson(row.wallMs)},
                   {"gpu_ms", times.empty() ? Json() : toJson(row.gpuMs)},
                   {"stages_ms", times},
                   {"ratio_to_standard", row.ratio.median},
                   {"ratio_p10", row.ratio.p10},
                   {"ratio_p90", row.ratio.p90}};
  json["error"] = toJson(row.error);
  json["wrong_share"] = row.wrongShare();
  if (nearest) json["nearest_neighbours"] = histogramJson(row.nearest);
  return json;
}

std::string dump(const Json& json) {
  return jsonText(json, 2) + "\n";
}

}  // namespace gnosphere::cli
