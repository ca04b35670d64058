// SPDX-License-Identifier: Apache-2.0
// gnosphere-bench figure7: the five sensors of the paper's Table 2 over one town, as in its Figure 7.
#include <memory>

#include "cases.hpp"
#include "cases/results.hpp"
#include "town/town.hpp"

namespace gnosphere::bench {
namespace {

using cli::Json;

constexpr Accuracy kAccuracies[] = {Accuracy::paper, Accuracy::draft, Accuracy::standard, Accuracy::exact};

struct Options {
  std::string device = "auto", accuracy = "standard", json, sensor;
  uint64_t triangles = 1'000'000;
  uint32_t runs = 20;
};

struct Row {
  const Sensor& sensor;
  Comparison check;
  std::vector<Timings> runs;

  template <class Get>
  Spread of(Get get) const {
    std::vector<double> values;
    for (const Timings& timings : runs) values.push_back(get(timings));
    return spreadOf(values);
  }
  Spread wall() const {
    return of([](const Timings& t) { return t.wallMs; });
  }
  Spread gpu() const {
    return of([](const Timings& t) { return t.gpuMs; });
  }
  Spread stage(size_t stage) const {
    return of([stage](const Timings& t) { return t.stages[stage].ms; });
  }
};

/// On the street, where the town has its crossing.
const Pose kPose = {{0, 0, 1.8}, {}};

SimulatorOptions simulatorOptions(const Options& options) {
  SimulatorOptions settings;
  settings.device = options.device;
  for (Accuracy accuracy : kAccuracies)
    if (options.accuracy == nameOf(accuracy)) settings.accuracy = accuracy;
  return settings;
}

std::vector<Row> measure(const Scene& town, const std::vector<Sensor>& sensors, Simulator& simulator,
                         const Options& options) {
  const auto progress = cli::stepProgress();
  SimulatorOptions settings;
  settings.device = "reference";
  Simulator reference(town, sensors, settings);
  std::vector<Row> rows;
  for (size_t s = 0; s < sensors.size(); ++s) {
    progress("check sensor", s + 1, sensors.size());
    rows.push_back({sensors[s], compare(reference.scan(kPose, s), simulator.scan(kPose, s)), {}});
  }
  for (uint32_t run = 0; run < options.runs; ++run) {
    progress("run", run + 1, options.runs);
    for (size_t s = 0; s < sensors.size(); ++s) rows[s].runs.push_back(simulator.scan(kPose, s).timings);
  }
  return rows;
}

/// A time that is all over the place is marked.
std::string medianCell(const Spread& spread) {
  const bool unsteady = spread.p90 - spread.p10 > 0.05 * spread.median;
  return cli::bareMs(spread.median) + (unsteady ? " *" : "");
}

void print(const std::vector<Row>& rows) {
  std::vector<cli::TableRow> table = {{"sensor", "beams", "hits", "wrong", "ties"}};
  const std::vector<StageTime>& stages = rows[0].runs[0].stages;
  if (!stages.empty()) table[0].insert(table[0].end(), {"gpu ms", "min", "10-90 %"});
  for (const StageTime& stage : stages) table[0].push_back(stage.name);
  table[0].insert(table[0].end(), {"wall ms", "min", "10-90 %"});
  for (const Row& row : rows) {
    const Comparison& c = row.check;
    table.push_back({row.sensor.name, cli::grouped(c.beams), cli::grouped(c.hits),
                     cli::grouped(c.missed + c.falseHits + c.wrongRange), cli::grouped(c.ties)});
    const auto add = [&](const Spread& spread) {
      table.back().push_back(medianCell(spread));
      table.back().push_back(cli::bareMs(spread.min));
      table.back().push_back(cli::bareMs(spread.p10) + "-" + cli::bareMs(spread.p90));
    };
    if (!stages.empty()) add(row.gpu());
    for (size_t s = 0; s < stages.size(); ++s) table.back().push_back(cli::bareMs(row.stage(s).median));
    add(row.wall());
  }
  std::printf("\n");
  cli::printMarkdown(table);
  std::printf(
      "\nMedians of %zu runs, the sensors in turn; wrong: missed, false or at another range than the reference, "
      "outside ties;\nwall: submit to results on the host; *: more than 5 %% between the 10th and the 90th "
      "percentile\n",
      rows[0].runs.size());
}

std::string toJson(const std::vector<Row>& rows, const Scene& town, const Simulator& simulator,
                   const Options& options) {
  Json json = resultsHead(simulator.device());
  json["scene"] = cli::sceneJson(town);
  json["plan"] = {{"accuracy", options.accuracy}};
  for (const Row& row : rows) {
    Json stages = Json::object();
    for (size_t s = 0; s < row.runs[0].stages.size(); ++s)
      stages[row.runs[0].stages[s].name] = cli::toJson(row.stage(s));
    json["sensors"].push_back({{"sensor", cli::sensorJson(row.sensor)},
                               {"error", cli::toJson(row.check)},
                               {"frame",
                                {{"runs", row.runs.size()},
                                 {"wall_ms", cli::toJson(row.wall())},
                                 {"gpu_ms", stages.empty() ? Json() : cli::toJson(row.gpu())},
                                 {"stages_ms", stages}}}});
  }
  return cli::dump(json);
}

int run(const Options& options) {
  checkResult(options.json);
  const std::vector<Sensor> sensors =
      options.sensor.empty() ? builtinSensors() : std::vector<Sensor>{findSensor(options.sensor)};
  const Scene town = makeTown({options.triangles, 1});
  Simulator simulator(town, sensors, simulatorOptions(options));
  const std::vector<Row> rows = measure(town, sensors, simulator, options);
  if (options.json != "-") {
    printHead(simulator.device());
    cli::say("scene",
             "a town of " + cli::grouped(town.placedTriangleCount()) + " triangles, accuracy " + options.accuracy);
    print(rows);
  }
  writeResult(options.json, toJson(rows, town, simulator, options));
  for (const Row& row : rows) {
    const bool promised = options.accuracy == "standard" || options.accuracy == "exact";
    if (!promised || row.check.missed + row.check.falseHits + row.check.wrongRange == 0) continue;
    cli::complain(row.sensor.name + ": the answer differs from the reference");
    return 1;
  }
  return 0;
}

}  // namespace

Action addFigure7(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  std::vector<std::string> names;
  for (Accuracy accuracy : kAccuracies) names.push_back(nameOf(accuracy));
  app.add_option("--device", options->device, "As gnosphere scan --device")->capture_default_str();
  app.add_option("--accuracy", options->accuracy, "As gnosphere scan --accuracy")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  app.add_option("--sensor", options->sensor, "Only this one, a built-in name or a JSON file");
  app.add_option("--triangles", options->triangles, "Of the town")->capture_default_str();
  app.add_option("--runs", options->runs, "Timed scans of every sensor")
      ->check(CLI::Range(uint32_t{1}, uint32_t{1'000'000}))
      ->capture_default_str();
  app.add_option("--json", options->json, "A JSON file of everything measured, or - for stdout");
  return [options] { return run(*options); };
}

}  // namespace gnosphere::bench
