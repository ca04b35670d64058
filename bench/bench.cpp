// SPDX-License-Identifier: Apache-2.0
// gnosphere-bench CASE ...: exit status 0 done, 1 the work failed or an answer was wrong, 2 the call was wrong.
#include <utility>
#include <vector>

#include "cases.hpp"
#include "console.hpp"
#include "gnosphere/error.hpp"

using namespace gnosphere;

int main(int argc, char** argv) {
  CLI::App app("The benches of GnoSphere: answers are compared before a time is printed", "gnosphere-bench");
  app.set_version_flag("--version", std::string("gnosphere-bench ") + GNOSPHERE_VERSION);
  app.require_subcommand(1);
  std::vector<std::pair<const CLI::App*, bench::Action>> cases;
  for (const bench::Case& entry : bench::kCases) {
    CLI::App* command = app.add_subcommand(entry.name, entry.description);
    cases.emplace_back(command, entry.add(*command));
  }
  cli::rememberCommand(argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
    cli::complain(std::string(error.what()) + " (gnosphere-bench --help says more)");
    return 2;
  }
  for (const auto& [command, action] : cases) {
    if (!command->parsed()) continue;
    try {
      return action();
    } catch (const Error& error) {
      cli::complain(error.what());
      return error.code() == ErrorCode::invalidArgument ? 2 : 1;
    } catch (const std::exception& error) {
      cli::complain(error.what());
      return 1;
    }
  }
  return 2;
}
