// SPDX-License-Identifier: Apache-2.0
#include "town/town.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "gnosphere/error.hpp"
#include "town/opendrive/plan.hpp"
#include "town/plan.hpp"

namespace gnosphere {
namespace {

using namespace town;

constexpr double kDensity = 3.0;            ///< placed triangles per square metre, as a first estimate
constexpr uint64_t kCoarseBelow = 100'000;  ///< triangles: smaller towns have trees with fewer leaves
constexpr uint64_t kFineFrom = 1'000'000;   ///< triangles: towns from here on have finer trees, cars and people
constexpr double kMargin = 60;              ///< metres by which streets come before the objects beside them

/// Places objects and builds each mesh when it is first needed.
class Builder {
 public:
  explicit Builder(Scene& scene) : scene_(scene) {}

  /// Places an object unless the town would then have more than `limit` triangles.
  bool add(const Plan& plan, const Placement& placement, uint64_t limit) {
    const auto [entry, isNew] = meshes_.try_emplace(placement.thing, static_cast<uint32_t>(scene_.meshes.size()));
    if (isNew) scene_.meshes.push_back(plan.meshOf(placement.thing));
    const Mesh& mesh = scene_.meshes[entry->second];
    if (placed_ + mesh.triangleCount() > limit) {
      if (isNew) {
        scene_.meshes.pop_back();
        meshes_.erase(entry);
      }
      return false;
    }
    placed_ += mesh.triangleCount();
    scene_.instances.push_back(
        {mesh.name + " " + std::to_string(++counts_[mesh.name]), entry->second, placement.where});
    return true;
  }
  uint64_t placed() const { return placed_; }

 private:
  Scene& scene_;
  std::map<Thing, uint32_t> meshes_;
  std::map<std::string, uint32_t> counts_;
  uint64_t placed_ = 0;
};

Detail detailOf(uint64_t triangles) {
  Detail detail;
  if (triangles < kCoarseBelow) detail.treeLeaves = 160;
  if (triangles >= kFineFrom) detail = {900, true};
  return detail;
}

/// Adds the placements of a plan, roads of a network first, in the order of their reach, up to `reach`. Returns true if
/// the town is then full.
bool fill(Builder& builder, Plan& plan, double reach, uint64_t triangles) {
  constexpr int kPatience = 400;  // number of consecutive objects that do not fit before it gives up
  std::stable_sort(plan.placements.begin(), plan.placements.end(), [](const Placement& a, const Placement& b) {
    return a.isRoad != b.isRoad ? a.isRoad : a.reach < b.reach;
  });
  int refused = 0;
  for (const Placement& placement : plan.placements) {
    if (placement.reach > reach) break;
    refused = builder.add(plan, placement, triangles) ? 0 : refused + 1;
    if (refused > kPatience) return true;
  }
  return builder.placed() >= triangles;
}

/// A road network, the objects along it, and its area.
struct NetworkTown {
  NetworkTown(const TownOptions& options, const Detail& detail) {
    const opendrive::Network network = opendrive::readNetwork(options.xodr);
    toFile = network.toFile;
    if (options.warn)
      for (const std::string& line : network.warnings) options.warn(line);
    if (options.moved && !network.offset.empty()) options.moved(network.offset);
    land = enclosedLand(options.seed, opendrive::landOf(network));
    plan = planNetwork(network, land, opendrive::planDrive(network, options.seed, kDriveMetres), options.seed, detail);
  }
  Transform toFile;
  Area land;
  Plan plan;
};

/// Returns a line about how many roads and junctions of a network are in a town, and how many triangles all would need;
/// empty if none is missing.
std::string roadsWithoutRoom(const Plan& plan, const Scene& scene, uint64_t triangles) {
  std::map<std::string, uint64_t> lacking;  // triangles by the name of the road or junction, which its pieces share
  uint64_t needed = 0;
  for (const Placement& placement : plan.placements) {
    if (!placement.isRoad) continue;
    const Mesh& piece = plan.pieces[std::get<Piece>(placement.thing).index];
    lacking[piece.name] += piece.triangleCount();
    needed += piece.triangleCount();
  }
  for (const Mesh& mesh : scene.meshes)
    if (const auto road = lacking.find(mesh.name); road != lacking.end()) road->second -= mesh.triangleCount();
  const size_t all = lacking.size();
  std::erase_if(lacking, [](const auto& road) { return road.second == 0; });
  if (lacking.empty()) return "";
  return std::to_string(triangles) + " triangles have room for " + std::to_string(all - lacking.size()) + " of " +
         std::to_string(all) + " roads and junctions; all of them need --triangles " + std::to_string(needed);
}

}  // namespace

Scene makeTown(const TownOptions& options) {
  if (options.triangles < kSmallestTown)
    throw Error(ErrorCode::invalidArgument, "--triangles: " + std::to_string(options.triangles) +
                                                " are too few for a town; the smallest has " +
                                                std::to_string(kSmallestTown));
  const Detail detail = detailOf(options.triangles);
  std::optional<NetworkTown> network;
  if (!options.xodr.empty()) network.emplace(options, detail);
  // Streets and blocks do not move when the extent grows: a larger town contains the smaller one.
  constexpr double kEverything = std::numeric_limits<double>::infinity();
  double extent = 60 + std::sqrt(static_cast<double>(options.triangles) / kDensity) / 2;
  std::optional<Area> clearing;
  if (network) {
    clearing = network->land;
    extent = std::max(extent, 150 + std::max({-clearing->x0, -clearing->y0, clearing->x1, clearing->y1}));
  }
  for (;; extent *= 1.25) {
    Scene scene;
    scene.materials = townMaterials();
    Builder builder(scene);
    bool full = network && fill(builder, network->plan, kEverything, options.triangles);
    if (!full) {
      Plan grid = planGrid(options.seed, extent + kMargin, detail, clearing);
      full = fill(builder, grid, extent, options.triangles);
    }
    if (!full) continue;
    if (network && options.warn)
      if (const std::string lack = roadsWithoutRoom(network->plan, scene, options.triangles); !lack.empty())
        options.warn(lack);
    if (network)
      for (Instance& instance : scene.instances) instance.transform = network->toFile * instance.transform;
    return scene;
  }
}

}  // namespace gnosphere
