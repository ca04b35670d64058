// SPDX-License-Identifier: Apache-2.0
#include "command_line.hpp"

#include <new>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "console.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::cli {
namespace {

struct Command {
  const CLI::App* app;
  Action action;
};

Command addCommand(CLI::App& app, const char* name, const char* description, Action (*add)(CLI::App&)) {
  CLI::App* command = app.add_subcommand(name, description);
  return {command, add(*command)};
}

int runChosen(const std::vector<Command>& commands) {
  for (const Command& command : commands) {
    if (!command.app->parsed()) continue;
    try {
      return command.action();
    } catch (const Error& error) {
      complain(error.what());
      return error.code() == ErrorCode::invalidArgument ? 2 : 1;
    } catch (const std::bad_alloc&) {
      complain("out of memory on the host");
    } catch (const std::exception& error) {
      complain(error.what());
    }
    return 1;
  }
  complain(
      "no command given; choose scan, plan, accuracy, compare, devices, sensors, effects, options, info, town, drive "
      "or view "
      "(see "
      "gnosphere --help)");
  return 2;
}

}  // namespace

int runCommandLine(int argc, char** argv) {
  CLI::App app("GnoSphere, a LiDAR simulator that never casts a ray", "gnosphere");
  app.set_version_flag("--version", std::string("gnosphere ") + GNOSPHERE_VERSION);
  app.require_subcommand(0, 1);
  app.footer("Example: gnosphere scan town.glb -o cloud.pcd");
  const std::vector<Command> commands = {
      addCommand(app, "scan", "Scan a scene and write point clouds", addScan),
      addCommand(app, "plan", "Show which steps a scan would have, and why", addPlan),
      addCommand(app, "accuracy", "Measure error and time of every accuracy setting", addAccuracy),
      addCommand(app, "compare", "Compare two clouds of the same beams", addCompare),
      addCommand(app, "devices", "List every device, and why one is unusable", addDevices),
      addCommand(app, "sensors", "List the built-in sensors, or print one as JSON", addSensors),
      addCommand(app, "effects", "List every effect and its parameters, or print a preset as JSON", addEffects),
      addCommand(app, "options", "List every option of simulators and sensors that --set takes", addOptions),
      addCommand(app, "info", "Tell what a scene holds: meshes, materials, animations", addInfo),
      addCommand(app, "town", "Write a synthetic town", addTown),
      addCommand(app, "drive", "Make the data set that a drive file describes", addDrive),
      addCommand(app, "view", "Make an HTML page that shows clouds", addView),
  };
  rememberCommand(argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
    const auto chosen = app.get_subcommands();
    complain(std::string(error.what()) + " (see gnosphere " + (chosen.empty() ? "" : chosen[0]->get_name() + " ") +
             "--help)");
    return 2;
  }
  return runChosen(commands);
}

}  // namespace gnosphere::cli
