// SPDX-License-Identifier: Apache-2.0
#include "command_line.hpp"

#include <cstdio>
#include <new>
#include <string>
#include <vector>

#include "base/os.hpp"
#include "call_texts.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::cli {
namespace {

struct Command {
  const CLI::App* app;
  Action action;
  int failed;  ///< exit status if the work fails; a wrong call has 2
};

Command addCommand(CLI::App& app, const char* name, const char* description, Action (*add)(CLI::App&), int failed = 1) {
  CLI::App* command = app.add_subcommand(name, description);
  return {command, add(*command), failed};
}

int runChosen(const std::vector<Command>& commands) {
  for (const Command& command : commands) {
    if (!command.app->parsed()) continue;
    try {
      return checkedOutput(command.action(), command.failed);
    } catch (const Error& error) {
      complain(error.what());
      return error.code() == ErrorCode::invalidArgument ? 2 : command.failed;
    } catch (const std::bad_alloc&) {
      complain("out of memory on the host");
    } catch (const std::exception& error) {
      complain(error.what());
    }
    return command.failed;
  }
  complain(
      "no command given; choose scan, plan, accuracy, compare, devices, sensors, effects, options, info, town, drive "
      "or view (see gnosphere --help)");
  return 2;
}

}  // namespace

int runCommandLine(int argc, char** argv) {
  CLI::App app("GnoSphere, a LiDAR simulator that never casts a ray", "gnosphere");
  app.formatter(helpFormatter());
  app.set_version_flag("--version", std::string("gnosphere ") + GNOSPHERE_VERSION);
  app.require_subcommand(0, 1);
  app.footer(
      "Exit status 0 for success, 1 if the work fails, 2 for a wrong call; gnosphere compare has its own.\n"
      "Example: gnosphere scan town.glb -o cloud.pcd");
  const std::vector<Command> commands = {
      addCommand(app, "scan", "Scan a scene and write point clouds", addScan),
      addCommand(app, "plan", "Show which steps a scan would have, and why", addPlan),
      addCommand(app, "accuracy", "Measure error and time of every accuracy setting", addAccuracy),
      addCommand(app, "compare", "Compare two clouds of the same beams", addCompare,
                 2),  // 1 says that the clouds differ
      addCommand(app, "devices", "List every device, and why one is unusable", addDevices),
      addCommand(app, "sensors", "List the built-in sensors, or print one as JSON", addSensors),
      addCommand(app, "effects", "List every effect and its parameters, tell of one, or print a preset as JSON",
                 addEffects),
      addCommand(app, "options", "List every option of simulators and sensors that --set takes", addOptions),
      addCommand(app, "info", "Tell what a scene holds: meshes, materials, animations", addInfo),
      addCommand(app, "town", "Write a synthetic town", addTown),
      addCommand(app, "drive", "Make the data set that a drive file describes", addDrive),
      addCommand(app, "view", "Make an HTML page that shows clouds", addView),
  };
  rememberCommand(argc, argv);
  os::removeUnfinishedAtEnd();
  // A file shows each line of a long run at once. Windows has no buffering by lines, so say() and tables flush.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return checkedOutput(app.exit(error), 1);  // --help and --version
    complain(wrongCall(app, error, "command"));
    return 2;
  }
  return runChosen(commands);
}

}  // namespace gnosphere::cli
