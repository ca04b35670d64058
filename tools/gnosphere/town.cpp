// SPDX-License-Identifier: Apache-2.0
#include "town/town.hpp"

#include <charconv>
#include <memory>
#include <system_error>

#include "base/path.hpp"
#include "base/utf8.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "scanning.hpp"
#include "town_drive.hpp"

namespace gnosphere::cli {
namespace {

struct TownCall {
  TownOptions options;
  bool baked = false;
  std::string file, xodr, drive, example;
};

/// Refuses a number of triangles that is none. Returns the problem, or nothing, as CLI11 asks for.
std::string triangleCount(std::string& text) {
  uint64_t count = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), count);
  if (result.ec == std::errc() && result.ptr == text.data() + text.size() && count <= 0x7fffffff) return "";
  return "'" + text + "' is not a whole number up to 2147483647, written in digits alone";
}

int runTown(const TownCall& call) {
  const std::filesystem::path file = pathOf(call.file);
  if (file.extension() != ".glb") {
    throw Error(ErrorCode::invalidArgument, file.string() + ": the name must end in .glb");
  }
  if (!call.example.empty() && pathOf(call.example).extension() != ".json")
    throw Error(ErrorCode::invalidArgument, "--drive: " + call.example + ": the name must end in .json");
  if (!call.example.empty() && toUtf8(file.filename().string()) != file.filename().string())
    throw Error(ErrorCode::invalidArgument,
                "--drive: " + call.file + ": a drive file names it, in JSON, which is UTF-8; choose such a name");
  std::vector<std::string> files = {call.file, call.drive};
  if (!call.example.empty())
    for (const std::filesystem::path& part : townDriveFiles(pathOf(call.example))) files.push_back(part.string());
  checkOutputFiles(files, {call.xodr});
  const std::vector<Pose> drive = makeDrive(call.options);
  Scene town = makeTown(call.options);
  if (call.baked) town = bake(town);
  writeGlb(town, file);
  if (!call.drive.empty()) writeTum(drive, pathOf(call.drive));
  if (!call.example.empty())
    writeTownDrive(town, file, call.options.xodr.empty() ? steered(drive) : drive, pathOf(call.example));
  say("town", grouped(town.placedTriangleCount()) + " triangles (" + grouped(town.uniqueTriangleCount()) +
                  " unique) in " + grouped(town.instances.size()) + " instances of " + grouped(town.meshes.size()) +
                  " meshes, seed " + std::to_string(call.options.seed));
  say("wrote", file.string() + ", " + fileSize(call.file));
  if (!call.example.empty()) say("example", call.example + ", for gnosphere drive");
  const Vec3& start = drive.front().position;
  const std::string pose = formatted("%.2f,%.2f,%.2f", start.x, start.y, start.z);
  if (!call.drive.empty()) {
    say("drive", call.drive + ", " + std::to_string(drive.size()) + " poses from " + pose + " on");
  } else if (!call.options.xodr.empty()) {
    say("start", pose + ", on a lane in the middle of the town");
  }
  return 0;
}

}  // namespace

Action addTown(CLI::App& app) {
  const auto call = std::make_shared<TownCall>();
  app.add_option("-o,--output", call->file, "The .glb file to write")->required();
  app.add_option("--xodr", call->xodr,
                 "Build the town along the roads of an OpenDRIVE file instead of a grid of streets");
  app.add_option("--triangles", call->options.triangles, "Placed triangles to aim for, at least 1000")
      ->check(CLI::Validator(triangleCount, "UINT up to 2147483647"))
      ->capture_default_str();
  app.add_option("--seed", call->options.seed, "Seed of the town")->capture_default_str();
  app.add_flag("--bake", call->baked, "Write unique geometry in tiles of 64 m instead of instances");
  app.add_option("--trajectory", call->drive,
                 "Write a drive of 400 poses through the town to a TUM file: t x y z qx qy qz qw");
  app.add_option("--drive", call->example,
                 "Write an example drive through the town, for gnosphere drive: a .json file, and beside it its "
                 "trajectory and models");
  app.footer("Example: gnosphere town --triangles 1000000 -o town.glb");
  return [call] {
    call->options.xodr = pathOf(call->xodr);
    call->options.warn = [](const std::string& message) { complain("warning: " + message); };
    call->options.moved = [](const std::string& offset) {
      say("offset", offset + ", of the file's header; the town is moved by it, and traffic must be, too");
    };
    return runTown(*call);
  };
}

}  // namespace gnosphere::cli
