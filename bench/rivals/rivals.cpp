// SPDX-License-Identifier: Apache-2.0
#include "rivals/rivals.hpp"

#include <algorithm>
#include <sstream>

#include "console.hpp"
#include "gnosphere/error.hpp"
#include "pipeline/backend.hpp"
#include "rivals/cuda.hpp"
#include "rivals/embree.hpp"
#include "rivals/vulkan.hpp"

namespace gnosphere::bench {
namespace {

using Contenders = std::vector<std::unique_ptr<Contender>>;

/// Most placed triangles for which one tree over all is built: more would need over 5 GB.
constexpr uint64_t kFlatTriangles = 30'000'000;

void addEmbree(const RivalSetting& setting, Contenders& contenders, std::vector<std::string>& notes) {
  std::vector<EmbreeWay> ways = {EmbreeWay::flat, EmbreeWay::instanced};
  if (setting.motion == Motion::transforms) ways = {EmbreeWay::placed};
  if (setting.motion == Motion::everything) ways = {EmbreeWay::rebuilt, EmbreeWay::refitted, EmbreeWay::placed};
  for (EmbreeWay way : ways) {
    const bool flat = way != EmbreeWay::instanced && way != EmbreeWay::placed;
    if (flat && setting.scene.placedTriangleCount() > kFlatTriangles)
      notes.push_back("embree: one tree over more than " + cli::grouped(kFlatTriangles) +
                      " triangles would take too much memory");
    else
      contenders.push_back(makeGuest(makeEmbree(setting.scene, setting.origin, way), setting.request.sensor));
  }
}

/// Most beams for Vulkan's ray tracing on a CPU, which would take minutes per scan with more.
constexpr size_t kSoftwareBeams = 500'000;

void addVulkan(VulkanWay way, const char* name, const RivalSetting& setting, Contenders& contenders,
               std::vector<std::string>& notes) {
  if (setting.device.apiVersion.empty())
    throw Error(ErrorCode::device, std::string(name) + ": " + setting.device.name + " is not a Vulkan device");
  if (setting.device.type == "cpu" && setting.request.sensor.beamCount() > kSoftwareBeams) {
    notes.push_back(std::string(name) + ": more than " + cli::grouped(kSoftwareBeams) +
                    " beams on a CPU would take minutes per scan");
    return;
  }
  const auto add = [&](bool anew) {
    auto rival = makeVulkan(setting.scene, setting.origin, way, {setting.options.device, setting.motion});
    contenders.push_back(makeGuest(std::move(rival), setting.request.sensor, anew));
  };
  add(false);
  if (setting.motion == Motion::everything) add(true);
}

void addRayQuery(const RivalSetting& setting, Contenders& contenders, std::vector<std::string>& notes) {
  addVulkan(VulkanWay::rayQuery, "rayquery", setting, contenders, notes);
}

void addRayTracing(const RivalSetting& setting, Contenders& contenders, std::vector<std::string>& notes) {
  addVulkan(VulkanWay::rayTracingPipeline, "raytracing", setting, contenders, notes);
}

/// GnoSphere by CUDA: with the same accuracy as by Vulkan, and with nvcc's faster arithmetic.
void addCuda(const RivalSetting& setting, Contenders& contenders, std::vector<std::string>&) {
  if (setting.device.type == "cpu" || setting.device.apiVersion.empty())
    throw Error(ErrorCode::device,
                "cuda is compared with Vulkan on the same card, but GnoSphere runs on " + setting.device.name);
  std::string problem;
  const std::vector<DeviceInfo> devices = cuda::devices(problem);
  const std::string number = std::to_string(sameCard(setting.device, devices, problem));
  using Kind = DeviceChoice::Kind;
  for (const auto& [name, kind] : {std::pair("cuda", Kind::cuda), std::pair("cuda-fast", Kind::cudaFast)}) {
    SimulatorOptions options = setting.options;
    options.device = {kind, number};
    contenders.push_back(makeOurs(setting.scene, setting.request, options, name));
  }
}

struct Entry {
  const char* name;
  void (*add)(const RivalSetting&, Contenders&, std::vector<std::string>& notes);
};

constexpr Entry kRivals[] = {
    {"embree", addEmbree}, {"rayquery", addRayQuery}, {"raytracing", addRayTracing}, {"cuda", addCuda}};

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
      throw Error(ErrorCode::invalidArgument, "--rivals: '" + name + "' is unknown; known are all, none" + list);
    }
    names.push_back(name);
  }
  return names;
}

Contenders makeRivals(const std::vector<std::string>& names, const RivalSetting& setting,
                      std::vector<std::string>& notes) {
  Contenders contenders;
  for (const Entry& entry : kRivals) {
    if (std::find(names.begin(), names.end(), entry.name) == names.end()) continue;
    try {
      entry.add(setting, contenders, notes);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::device && error.code() != ErrorCode::outOfMemory) throw;
      notes.emplace_back(error.what());
    }
  }
  return contenders;
}

}  // namespace gnosphere::bench
