// SPDX-License-Identifier: Apache-2.0
#include "command_line.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "base/nearest_text.hpp"
#include "base/os.hpp"
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

/// Help whose lines fit the terminal, with any version of CLI11.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() {
    column_width(kNames);
    // CLI11 from 2.5 on would wrap the wrapped lines again.
    [](auto& self) {
      if constexpr (requires { self.enable_footer_formatting(false); }) {
        self.enable_footer_formatting(false);
        self.enable_description_formatting(false);
      }
    }(*this);
  }
  /// The versions of CLI11 differ in the number of empty lines between the parts of the help.
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    std::string text = Formatter::make_help(app, std::move(name), mode);
    for (size_t at; (at = text.find("\n\n\n")) != text.npos;) text.erase(at, 1);
    return text;
  }
  std::string make_option(const CLI::Option* option, bool positional) const override {
    std::string name = "  " + make_option_name(option, positional) + make_option_opts(option);
    name.resize(name.find_last_not_of(' ') + 1);
    const std::string description = option->get_description();
    if (description.empty()) return name + "\n";
    if (name.size() < kNames)
      name.resize(kNames, ' ');
    else
      name += "\n" + std::string(kNames, ' ');
    return name + wrapped(description, columns_, kNames) + "\n";
  }
  std::string make_subcommand(const CLI::App* command) const override {
    std::string name = "  " + command->get_name();
    name.resize(kCommands, ' ');
    return name + wrapped(command->get_description(), columns_, kCommands) + "\n";
  }
  /// The example is a command to copy, so it stays one line.
  std::string make_footer(const CLI::App* app) const override {
    const std::string footer = app->get_footer();
    const size_t example = std::min(footer.find("Example: "), footer.size());
    return wrapped(footer.substr(0, example), columns_) + footer.substr(example) + "\n";
  }

 private:
  static constexpr size_t kNames = 26, kCommands = 14;  ///< columns of the names of options, and of commands
  size_t columns_ = textColumns();
};

/// Says which word of a call is none of the command's, or that there is no such command.
std::string unknownWord(const CLI::App& app, const std::vector<CLI::App*>& chosen) {
  std::vector<std::string> words = app.remaining(true);  // behind --, those of a command are the program's
  std::erase(words, "--");
  const auto dashed = [](const std::string& word) {  // as options are, but not numbers below 0
    return word.size() > 1 && word[0] == '-' && word.find_first_of("0123456789") != 1;
  };
  const auto found = std::find_if(words.begin(), words.end(), dashed);
  const std::string word = found != words.end() ? *found : words.at(0);
  std::vector<std::string> names;
  if (dashed(word)) {
    for (const CLI::Option* option : (chosen.empty() ? &app : chosen[0])->get_options())
      if (!option->get_lnames().empty()) names.push_back("--" + option->get_lnames()[0]);
    return "there is no option '" + word + "'; " + nearestText(word, std::move(names));
  }
  if (!chosen.empty()) {
    const auto hasValue = [](const CLI::Option* option) {
      return option->nonpositional() && option->count() > 0 && option->get_expected_max() > 0;
    };
    return "there is no place for '" + word + "'" +
           (std::ranges::any_of(chosen[0]->get_options(), hasValue) ? "; commas join the values of one option, as 1,2,3"
                                                                    : "");
  }
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  return "there is no command '" + word + "'; " + nearestText(word, std::move(names));
}

/// Says which option has a text in place of a number.
std::string noNumber(const CLI::ConversionError& error, const std::vector<CLI::App*>& chosen) {
  for (const CLI::App* command : chosen)
    for (const CLI::Option* option : command->get_options()) {
      const std::string name = option->get_name(), type = option->get_type_name();
      if (option->results().empty() ||
          error.what() != std::string(CLI::ConversionError(name, option->results()).what()))
        continue;
      const char* const wanted = type.starts_with("FLOAT")                             ? "a number"
                                 : type.starts_with("INT") || type.starts_with("UINT") ? "a whole number"
                                                                                       : "a value of its kind";
      return name + " must be " + wanted + ", is '" + option->results().back() + "'";
    }
  return error.what();
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
  app.formatter(std::make_shared<HelpFormatter>());
  app.set_version_flag("--version", std::string("gnosphere ") + GNOSPHERE_VERSION);
  app.require_subcommand(0, 1);
  app.footer("Example: gnosphere scan town.glb -o cloud.pcd");
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
    const auto chosen = app.get_subcommands();
    const auto* const unconverted = dynamic_cast<const CLI::ConversionError*>(&error);
    const bool isUnknown = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    complain((isUnknown     ? unknownWord(app, chosen)
              : unconverted ? noNumber(*unconverted, chosen)
                            : std::string(error.what())) +
             " (see gnosphere " + (chosen.empty() ? "" : chosen[0]->get_name() + " ") + "--help)");
    return 2;
  }
  return runChosen(commands);
}

}  // namespace gnosphere::cli
