// SPDX-License-Identifier: Apache-2.0
// gnosphere-bench CASE ...: exit status 0 for success, 1 if the work failed or a result was wrong, 2 for a wrong call.
#include <utility>
#include <vector>

#include "call_texts.hpp"
#include "cases.hpp"
#include "cases/results.hpp"
#include "cases/stability.hpp"
#include "console.hpp"
#include "gnosphere/error.hpp"

using namespace gnosphere;
using namespace gnosphere::bench;

namespace {

using Action = std::function<int()>;

void print(const Case& entry, const Session& session, const Report& report) {
  printHead(session.device());
  std::printf("\n## %s: %s\n", entry.name, entry.description);
  std::vector<Table> tables = report.tables;
  tables.push_back(cudaTable(report.outcomes));
  for (const Table& table : tables) {
    if (table.rows.empty()) continue;
    std::printf("\n");
    cli::printMarkdown(table.rows);
    if (!table.note.empty()) std::printf("\n%s\n", table.note.c_str());
  }
  for (const std::string& note : session.notes()) std::printf("\nleft out: %s\n", note.c_str());
  std::printf("\n");
}

std::string plotOf(const Case& entry, Report report, const DeviceInfo& device) {
  if (report.bars.bars.empty()) return cli::toSvg(plotOf(report, entry.description, device));
  report.bars.title = entry.description;
  report.bars.notes.insert(report.bars.notes.begin(), device.name);
  return toSvg(report.bars);
}

/// Runs these cases one after the other and writes their results to one file.
int run(const std::vector<Case>& cases, const Options& options) {
  checkResult(options.json);
  checkPlot(options.plot);
  checkResult(options.renew);
  cli::Json json, results = cli::Json::object();
  bool wrong = false;
  for (const Case& entry : cases) {
    Session session(options, entry.defaults);
    const Report report = entry.run(session);
    wrong = wrong || report.wrong;
    if (options.json != "-") print(entry, session, report);
    if (json.empty()) {
      json = resultsHead(session.device());
      if (const Rates& rates = session.rates(); rates.known())
        json["rates"] = {
            {"gigabytes_per_s", rates.bytesPerMs / 1e6},
            {"gigaoperations_per_s", rates.operationsPerMs > 0 ? cli::Json(rates.operationsPerMs / 1e6) : cli::Json()}};
    }
    results[entry.name] = toJson(report);
    if (!session.notes().empty()) results[entry.name]["left_out"] = session.notes();
    writeResult(options.plot, plotOf(entry, report, session.device()));
  }
  if (cases.size() > 1) results["stability"] = stabilityOf(options.device);
  json["cases"] = results;
  writeResult(options.json, compact(json));
  return wrong ? 1 : 0;
}

/// The help of a case states its own defaults.
void showDefaults(CLI::App& command, const Defaults& defaults) {
  const std::pair<const char*, uint64_t> numbers[] = {
      {"--triangles", defaults.triangles}, {"--runs", defaults.runs}, {"--frames", defaults.frames}};
  for (const auto& [name, number] : numbers)
    if (CLI::Option* const option = command.get_option_no_throw(name)) option->default_str(std::to_string(number));
}

/// Adds a sub-command for each case, and one that runs all of them.
std::vector<std::pair<const CLI::App*, Action>> addCases(CLI::App& app) {
  std::vector<std::pair<const CLI::App*, Action>> actions;
  const auto add = [&](const char* name, const char* description, const std::vector<Case>& cases) {
    CLI::App* command = app.add_subcommand(name, description);
    const auto options = std::make_shared<Options>();
    addOptions(*command, *options);
    const bool scenes = cases[0].run == real;
    if (scenes) adaptToReal(*command, *options);
    if (cases.size() == 1 && cases[0].run == heads) adaptToHeads(*command, *options);
    if (cases[0].run == golden) adaptToGolden(*command, *options);
    if (cases.size() == 1) showDefaults(*command, cases[0].defaults);
    command->footer("Example: gnosphere-bench " + std::string(name) + (scenes ? " --scene FOLDER" : "") +
                    " --device 0 --json results.json");
    actions.emplace_back(command, [cases, options] { return run(cases, *options); });
    return command;
  };
  for (const Case& entry : kCases) add(entry.name, entry.description, {entry});
  add(kReal.name, kReal.description, {kReal});
  add(kGolden.name, kGolden.description, {kGolden});
  CLI::App* all = add("all", "All cases but real and golden", {std::begin(kCases), std::end(kCases)});
  all->remove_option(all->get_option("--plot"));
  CLI::App* stability = app.add_subcommand("stability", "Error of every accuracy as cases get harder");
  actions.emplace_back(stability, addStability(*stability));
  return actions;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Benchmarks of GnoSphere; results are compared before any time is printed", "gnosphere-bench");
  app.set_version_flag("--version", std::string("gnosphere-bench ") + GNOSPHERE_VERSION);
  app.formatter(cli::helpFormatter());
  app.require_subcommand(0, 1);
  app.footer(
      "Exit status 0 for success, 1 if the work fails or a result is wrong, 2 for a wrong call.\n"
      "Example: gnosphere-bench figure7 --rivals none");
  const auto cases = addCases(app);
  cli::rememberCommand(argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return cli::checkedOutput(app.exit(error), 1);  // --help and --version
    cli::complain(cli::wrongCall(app, error, "case"));
    return 2;
  }
  for (const auto& [command, action] : cases) {
    if (!command->parsed()) continue;
    try {
      return cli::checkedOutput(action(), 1);
    } catch (const Error& error) {
      cli::complain(error.what());
      return error.code() == ErrorCode::invalidArgument ? 2 : 1;
    } catch (const std::exception& error) {
      cli::complain(error.what());
      return 1;
    }
  }
  cli::complain("no case is given (see gnosphere-bench --help)");
  return 2;
}
