// SPDX-License-Identifier: Apache-2.0
#include "rivals/rivals.hpp"

#include <algorithm>
#include <sstream>

#include "console.hpp"
#include "gnosphere/error.hpp"
#include "rivals/embree.hpp"
#include "rivals/vulkan.hpp"

namespace gnosphere::bench {
namespace {

using Entrants = std::vector<Entrant>;

/// Beyond this many placed triangles one tree over all of them is not tried: it would take more than 5 GB.
constexpr uint64_t kFlatTriangles = 30'000'000;

void addEmbree(const RivalSetting& setting, Entrants& entrants, std::vector<std::string>& notes) {
  std::vector<EmbreeWay> ways = {EmbreeWay::flat, EmbreeWay::instanced};
  if (setting.motion == Motion::transforms) ways = {EmbreeWay::placed};
  if (setting.motion == Motion::everything) ways = {EmbreeWay::rebuilt, EmbreeWay::refitted, EmbreeWay::placed};
  for (EmbreeWay way : ways) {
    const bool flat = way != EmbreeWay::instanced && way != EmbreeWay::placed;
    if (flat && setting.scene.placedTriangleCount() > kFlatTriangles)
      notes.push_back("embree: one tree over more than " + cli::grouped(kFlatTriangles) + " triangles is not tried");
    else
      entrants.push_back({makeEmbree(setting.scene, setting.origin, way)});
  }
}

/// On a CPU, Vulkan's ray tracing takes minutes per scan beyond this many beams.
constexpr size_t kSoftwareBeams = 500'000;

void addVulkan(VulkanWay way, const char* name, const RivalSetting& setting, Entrants& entrants,
               std::vector<std::string>& notes) {
  if (setting.software && setting.beams > kSoftwareBeams) {
    notes.push_back(std::string(name) + ": more than " + cli::grouped(kSoftwareBeams) +
                    " beams on a CPU would take minutes per scan");
    return;
  }
  const VulkanOptions options = {setting.device, setting.motion};
  entrants.push_back({makeVulkan(setting.scene, setting.origin, way, options)});
  if (setting.motion == Motion::everything)
    entrants.push_back({makeVulkan(setting.scene, setting.origin, way, options), true});
}

void addRayQuery(const RivalSetting& setting, Entrants& entrants, std::vector<std::string>& notes) {
  addVulkan(VulkanWay::rayQuery, "rayquery", setting, entrants, notes);
}

void addRayTracing(const RivalSetting& setting, Entrants& entrants, std::vector<std::string>& notes) {
  addVulkan(VulkanWay::rayTracingPipeline, "raytracing", setting, entrants, notes);
}

struct Entry {
  const char* name;
  void (*add)(const RivalSetting&, Entrants&, std::vector<std::string>& notes);
};

constexpr Entry kRivals[] = {{"embree", addEmbree}, {"rayquery", addRayQuery}, {"raytracing", addRayTracing}};

}  // namespace

std::vector<std::string> parseRivals(const std::string& text) {
  std::vector<std::string> known, names;
  for (const Entry& entry : kRivals) known.emplace_back(entry.name);
  if (text == "all") return known;
  if (text == "none") return {};
  std::istringstream stream(text);
  for (std::string name; std::getline(stream, name, ',');) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      std::string list;
      for (const std::string& other : known) list += ", " + other;
      throw Error(ErrorCode::invalidArgument, "--rivals: there is no '" + name + "'; there are all, none" + list);
    }
    names.push_back(name);
  }
  return names;
}

Entrants makeRivals(const std::vector<std::string>& names, const RivalSetting& setting,
                    std::vector<std::string>& notes) {
  Entrants entrants;
  for (const Entry& entry : kRivals) {
    if (std::find(names.begin(), names.end(), entry.name) == names.end()) continue;
    try {
      entry.add(setting, entrants, notes);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::device && error.code() != ErrorCode::outOfMemory) throw;
      notes.emplace_back(error.what());
    }
  }
  return entrants;
}

}  // namespace gnosphere::bench
