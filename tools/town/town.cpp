// SPDX-License-Identifier: Apache-2.0
#include "town/town.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "town/plan.hpp"

namespace gnosphere {
namespace {

using namespace town;

constexpr double kDensity = 3.0;            ///< placed triangles per square metre, a first guess
constexpr uint64_t kCoarseBelow = 100'000;  ///< triangles: below, trees have fewer leaves
constexpr uint64_t kFineFrom = 1'000'000;   ///< triangles: from here on, trees, cars and people are finer
constexpr double kMargin = 60;              ///< metres: streets come that much before what stands beside them

/// Places things and makes each mesh the first time it is needed.
class Builder {
 public:
  explicit Builder(Scene& scene) : scene_(scene) {}

  /// Places it unless the town would then hold more than `limit` triangles.
  bool add(const Placement& placement, uint64_t limit) {
    const auto [entry, isNew] = meshes_.try_emplace(placement.thing, static_cast<uint32_t>(scene_.meshes.size()));
    if (isNew) scene_.meshes.push_back(meshOf(placement.thing));
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

/// The plan from the middle outwards.
Plan sortedPlan(const TownOptions& options, double extent) {
  Detail detail;
  if (options.triangles < kCoarseBelow) detail.treeLeaves = 160;
  if (options.triangles >= kFineFrom) detail = {900, true};
  Plan plan = planGrid(options.seed, extent + kMargin, detail);
  std::stable_sort(plan.placements.begin(), plan.placements.end(),
                   [](const Placement& a, const Placement& b) { return a.reach < b.reach; });
  return plan;
}

}  // namespace

Scene makeTown(const TownOptions& options) {
  constexpr int kPatience = 400;  // things in a row that are too large for what is left
  // Streets and blocks stay where they are when the extent grows: a larger town contains the smaller one.
  for (double extent = 60 + std::sqrt(static_cast<double>(options.triangles) / kDensity);; extent *= 1.4) {
    const Plan plan = sortedPlan(options, extent);
    Scene scene;
    scene.materials = townMaterials();
    Builder builder(scene);
    int refused = 0;
    for (const Placement& placement : plan.placements) {
      if (placement.reach > extent || refused > kPatience) break;
      refused = builder.add(placement, options.triangles) ? 0 : refused + 1;
    }
    if (refused > 0 || builder.placed() >= options.triangles) return scene;
  }
}

}  // namespace gnosphere
