// SPDX-License-Identifier: Apache-2.0
// gnosphere plan: prints which steps a scan would have, and why, without scanning.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "console.hpp"
#include "effect_options.hpp"
#include "pipeline/kernels.hpp"
#include "scanning.hpp"

namespace gnosphere::cli {
namespace {

struct PlanOptions : ScanningOptions, EffectOptions {
  std::string fields, records;
  size_t views = 1;
  bool json = false, pipelines = false;
};

std::string bytesText(uint64_t bytes) {
  if (bytes < 10'000) return grouped(bytes) + " B";
  const double kib = static_cast<double>(bytes) / 1024;
  return kib < 1024 ? formatted("%.1f KiB", kib) : formatted("%.1f MiB", kib / 1024);
}

/// Prints the planned effects, then the others, each with its reason.
void printEffects(const Plan& plan) {
  for (bool in : {true, false}) {
    std::vector<const Plan::Decision*> decisions;
    size_t width = 0;
    for (const Plan::Decision& decision : plan.effects) {
      if (decision.in == in) decisions.push_back(&decision);
      width = std::max(width, decision.effect.size());
    }
    if (decisions.empty()) continue;
    std::printf("\n%s\n", in ? "effects that are in" : "effects that are out, and cost nothing");
    for (const Plan::Decision* decision : decisions) {
      std::printf("  %-*s  %s\n", static_cast<int>(width), decision->effect.c_str(), decision->reason.c_str());
    }
  }
}

/// Returns text such as "bin x 2, scan x 3": the number of specialisations of each shader.
std::string pipelinesText(const Plan::Stage& stage) {
  if (stage.pipelines.empty()) return "(the host)";
  std::string text;
  for (size_t i = 0; i < stage.pipelines.size();) {
    size_t next = i + 1;
    while (next < stage.pipelines.size() && stage.pipelines[next].name == stage.pipelines[i].name) ++next;
    text += (i ? ", " : "") + stage.pipelines[i].name + (next - i > 1 ? formatted(" x %zu", next - i) : "");
    i = next;
  }
  return text;
}

void printStages(const Plan& plan) {
  if (plan.stages.empty()) return;
  std::printf("\n%-8s  %10s  %s\n", "stage", "dispatches", "pipelines");
  for (const Plan::Stage& stage : plan.stages) {
    std::printf("%-8s  %10s  %s\n", stage.name.c_str(), grouped(stage.dispatches).c_str(),
                pipelinesText(stage).c_str());
  }
  std::printf("%-8s  %10s\n", "all", grouped(plan.dispatches()).c_str());
  const Plan::Commands& commands = plan.commands;
  if (commands.all() > 0)
    std::printf("\ncommands  %u: %u dispatches, %u fills, %u copies, %u barriers\n", commands.all(),
                commands.dispatches, commands.fills, commands.copies, commands.barriers);
}

/// Prints what the driver's compiler says of each pipeline.
void printPipelines(const Plan& plan) {
  for (const Plan::Stage& stage : plan.stages)
    for (const Plan::Pipeline& pipeline : stage.pipelines) {
      const uint32_t pass = optionsOf(pipeline.constants).PASS;
      std::printf("\n%s%s: %u lanes, compiled in %.0f ms\n", pipeline.name.c_str(),
                  pass > 0 ? formatted(", pass %u", pass).c_str() : "", pipeline.subgroupSize, pipeline.compileMs);
      if (pipeline.statistics.empty()) std::printf("  the driver says nothing of it\n");
      for (const Plan::Statistic& statistic : pipeline.statistics)
        std::printf("  %-28s %14s\n", statistic.name.c_str(), formatted("%.10g", statistic.value).c_str());
    }
}

void printBuffers(const Plan& plan) {
  if (plan.buffers.empty()) return;
  std::printf("\n");
  std::vector<TableRow> rows = {{"buffer", "size"}};
  for (const Plan::Buffer& buffer : plan.buffers) rows.push_back({buffer.name, bytesText(buffer.bytes)});
  rows.push_back({"all", bytesText(plan.bytes())});
  printTable(rows);
}

/// Returns text such as "64 of 1,024 in one submission".
std::string viewsText(size_t wanted, uint32_t views) {
  if (views == 1) return "1: scans of this sensor are made one by one";
  return grouped(views) + (views < wanted ? " of " + grouped(wanted) : "") + " in one submission";
}

void print(const PlanOptions& options, const DeviceInfo& device, const Scene& scene, const Sensor& sensor,
           const Plan& plan) {
  say("scene", options.scene + ": " + grouped(scene.placedTriangleCount()) + " triangles, " +
                   grouped(scene.materials.size()) + (scene.materials.size() == 1 ? " material" : " materials"));
  say("device", device.name);
  say("sensor", sensor.name + ": " + grouped(sensor.beamCount()) + " beams" + maskedText(maskedBeams(sensor)) + ", " +
                    grouped(plan.returns) + (plan.returns == 1 ? " return each" : " returns each"));
  if (options.views > 1) say("views", viewsText(options.views, plan.views));
  if (!plan.binning.empty()) say("binning", plan.binning);
  printEffects(plan);
  printStages(plan);
  options.pipelines ? printPipelines(plan) : printBuffers(plan);
}

int runPlan(const PlanOptions& options) {
  checkScanning(options);
  SimulatorOptions settings = simulatorOptions(options);
  settings.compileOnly |= options.pipelines;
  SensorRequest request = {sensorOf(options.sensor), effectsOf(options)};
  settings.materials = materialsOf(options);
  applyToRequest(options, request);
  if (!options.fields.empty()) request.fields = parseFields(options.fields);
  if (!options.records.empty()) request.layout = layoutOf(parseFields(options.records));
  const Scene scene = loadScene(options);
  const Simulator simulator(scene, request, settings);
  const Plan plan = simulator.plan(0, options.views);
  if (options.json)
    std::printf("%s", toJson(plan).c_str());
  else
    print(options, simulator.device(), scene, request.sensor, plan);
  return 0;
}

}  // namespace

Action addPlan(CLI::App& app) {
  const auto options = std::make_shared<PlanOptions>();
  addScanningOptions(app, *options);
  addEffectOptions(app, *options);
  addAccuracyOption(app, options->settings);
  app.add_option("--fields", options->fields, "Fields that would be written, as in gnosphere scan");
  CLI::Option* pipelines = app.add_flag(
      "--pipelines", options->pipelines,
      "Compile the pipelines, without using any other part of the device, and print what the driver's compiler "
      "says of each");
  app.add_option("--records", options->records,
                 "Fields of records that stay on the device, as in docs/engine.md; only with --pipelines")
      ->needs(pipelines);
  app.add_option(
         "--views", options->views,
         "Scans that are made together, as in a batch: the plan of one submission of so many, or as many as fit")
      ->check(CLI::Range(size_t{1}, size_t{1'000'000}))
      ->capture_default_str();
  app.add_flag("--json", options->json, "Print JSON");
  app.footer("Example: gnosphere plan town.glb --effect fog.visibility=200");
  return [options] { return runPlan(*options); };
}

}  // namespace gnosphere::cli
