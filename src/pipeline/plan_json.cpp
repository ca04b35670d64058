// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/json_text.hpp"
#include "effects/effect_table.hpp"
#include "gnosphere/plan.hpp"

namespace gnosphere {
namespace {

using Json = nlohmann::ordered_json;

Json jsonOf(const Plan::Pipeline& pipeline) {
  Json json = {{"name", pipeline.name}, {"constants", pipeline.constants}};
  if (pipeline.subgroupSize == 0) return json;
  json["subgroup_size"] = pipeline.subgroupSize;
  json["compile_ms"] = pipeline.compileMs;
  json["statistics"] = Json::object();
  for (const Plan::Statistic& statistic : pipeline.statistics) json["statistics"][statistic.name] = statistic.value;
  return json;
}

}  // namespace

uint64_t Plan::bytes() const {
  uint64_t sum = 0;
  for (const Buffer& buffer : buffers) sum += buffer.bytes;
  return sum;
}

uint32_t Plan::dispatches() const {
  uint32_t sum = 0;
  for (const Stage& stage : stages) sum += stage.dispatches;
  return sum;
}

bool Plan::has(const std::string& effect) const {
  return std::any_of(effects.begin(), effects.end(),
                     [&](const Decision& decision) { return decision.in && decision.effect == effect; });
}

std::string toJson(const Plan& plan) {
  Json json;
  json["effects"] = Json::array();
  for (const Plan::Decision& decision : plan.effects) {
    json["effects"].push_back({{"effect", decision.effect},
                               {"request", kUseWords[static_cast<size_t>(decision.request)]},
                               {"in", decision.in},
                               {"left_out", decision.leftOut},
                               {"reason", decision.reason}});
  }
  json["fields"] = plan.fields;
  json["returns"] = plan.returns;
  json["views"] = plan.views;
  json["binning"] = plan.binning;
  json["stages"] = Json::array();
  for (const Plan::Stage& stage : plan.stages) {
    Json pipelines = Json::array();
    for (const Plan::Pipeline& pipeline : stage.pipelines) {
      pipelines.push_back(jsonOf(pipeline));
    }
    json["stages"].push_back({{"name", stage.name}, {"dispatches", stage.dispatches}, {"pipelines", pipelines}});
  }
  json["dispatches"] = plan.dispatches();
  json["commands"] = {{"dispatches", plan.commands.dispatches},
                      {"fills", plan.commands.fills},
                      {"copies", plan.commands.copies},
                      {"barriers", plan.commands.barriers}};
  json["buffers"] = Json::array();
  for (const Plan::Buffer& buffer : plan.buffers) {
    json["buffers"].push_back({{"name", buffer.name}, {"bytes", buffer.bytes}});
  }
  json["bytes"] = plan.bytes();
  return jsonText(json, 2) + "\n";
}

}  // namespace gnosphere
