// SPDX-License-Identifier: Apache-2.0
#include "town/town.hpp"

#include <memory>

#include "commands.hpp"
#include "console.hpp"
#include "file.hpp"

namespace gnosphere::cli {
namespace {

int runTown(const TownOptions& options, const std::filesystem::path& file) {
  if (file.extension() != ".glb") {
    throw Error(ErrorCode::invalidArgument, file.string() + ": a town is written as .glb");
  }
  checkWritable(file);  // told before the work, not after it
  const Scene town = makeTown(options);
  writeGlb(town, file);
  say("town", grouped(town.placedTriangleCount()) + " triangles (" + grouped(town.uniqueTriangleCount()) +
                  " unique) in " + grouped(town.instances.size()) + " instances of " + grouped(town.meshes.size()) +
                  " meshes, seed " + std::to_string(options.seed));
  say("wrote", file.string() + ", " + fileSize(file));
  return 0;
}

}  // namespace

Action addTown(CLI::App& app) {
  const auto options = std::make_shared<TownOptions>();
  const auto file = std::make_shared<std::string>();
  app.add_option("-o,--output", *file, "The .glb file to write")->required();
  app.add_option("--triangles", options->triangles, "Placed triangles to aim for")->capture_default_str();
  app.add_option("--seed", options->seed, "Another number, another town")->capture_default_str();
  return [options, file] { return runTown(*options, *file); };
}

}  // namespace gnosphere::cli
