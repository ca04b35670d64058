// SPDX-License-Identifier: Apache-2.0
// The kernels of the plans that people use, specialised as a device gets them: valid modules, whose lanes run together
// wherever they have operations of subgroups.
#include <catch2/catch_test_macros.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "deformable.hpp"
#include "effects/scan_support.hpp"
#include "effects/sensor_plan.hpp"
#include "pipeline/device_backend.hpp"
#include "pipeline/host_memory.hpp"
#include "town/town.hpp"
#include "vulkan/kernel.hpp"
#include "vulkan/reconvergence.hpp"
#include "vulkan/spirv_tools.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

/// A machine that only notes which kernels it would have to compile.
class NotingMachine final : public Machine {
 public:
  NotingMachine(const vulkan::Capabilities& capabilities, std::set<Variant>& variants) : variants_(variants) {
    traits_ = {{}, capabilities.cpu, capabilities.int64Atomics, capabilities.float64};
    traits_.info.maxBufferBytes = uint64_t{4} << 30;
    traits_.info.subgroupSize = capabilities.subgroups.size;
    traits_.spreadsRays = true;
  }
  const Traits& traits() const override { return traits_; }
  std::unique_ptr<DeviceMemory> allocate(const char* name, uint64_t bytes, MemoryKind) override {
    return std::make_unique<HostMemory>(name, bytes);
  }
  void prepare(std::span<const Variant> variants) override { variants_.insert(variants.begin(), variants.end()); }
  size_t slots() const override { return 1; }
  void submit(size_t, std::span<const Step>, const BoundArrays&) override {}
  void wait(size_t) override {}
  void readTimings(size_t, Timings&) override {}

 private:
  Traits traits_;
  std::set<Variant>& variants_;
};

/// A town with panes, a fence with holes and a limb that bends.
Scene fullTown() {
  Scene scene = makeTown({.triangles = 1'000u});
  for (size_t i = 0; i < scene.materials.size(); i += 2) scene.materials[i].transmission = 0.5f;
  addFence(scene, plate(6, 3), translation(0, 0, 2));
  return scene;
}

/// Returns the modules of the kernels of plans that people use, as a device with these capabilities gets them: of
/// tools/gpus and, with every combination, of heads as they come, of every accuracy and way of binning, and of each
/// effect.
std::map<Words, Variant> usedModules(const vulkan::Capabilities& capabilities) {
  std::set<Variant> variants;
  const auto plan = [&](const Scene& scene, const std::string& sensor, const std::vector<std::string>& effects,
                        const std::vector<std::string>& settings = {}, std::vector<Field> fields = {}) {
    SimulatorOptions options;
    for (const std::string& setting : settings) assign(options, setting);
    SensorRequest request = {builtinSensor(sensor), effectPreset(effects[0]), std::move(fields)};
    for (size_t i = 1; i < effects.size(); ++i) assign(request.effects, effects[i]);
    SensorPlanner planner(options);
    makeDeviceBackend(std::make_unique<NotingMachine>(capabilities, variants), scene,
                      {planner.plan(scene, request, 0, false)}, options);
  };
  const auto footprint = [&](const Scene& scene, const char* returns, const std::string& subRays) {
    plan(scene, "VLP-16",
         {"clean", "intensity=on", returns, "divergence.horizontal=0.003", "divergence.vertical=0.0015",
          "divergence.sub_rays=" + subRays});
  };
  const Scene town = fullTown(), bare = makeTown({.triangles = 1'000u});
  plan(bare, "HDL-64E", {"clean"});
  plan(bare, "HDL-64E", {"clean"}, {"accuracy=exact"});
  plan(bare, "HDL-64E", {"clean"}, {"tuning.binning=lists"});
  plan(bare, "VLP-16", {"clean", "intensity=on", "fog.visibility=150", "rain.rate=25", "range-noise.sigma=0.02"});
  plan(town, "VLP-16", {"clean", "intensity=on", "returns.count=3", "transmission=on"});
  plan(town, "OS1-64", {"auto"});
  plan(town, "Puck", {"clean", "sensor-motion=on"});
  footprint(bare, "returns=off", "19");
  if (everyCombination()) {
    for (const std::string accuracy : {"paper", "draft", "standard", "exact"})
      for (const std::string binning : {"auto", "nearest", "lists", "slabs"})
        if (accuracy != "paper" || binning == "auto")
          plan(bare, "HDL-64E", {"clean"}, {"accuracy=" + accuracy, "tuning.binning=" + binning});
    for (const char* sensor : {"Puck", "VLP-32C", "OS1-64", "Avia", "RS-M1"}) {
      plan(bare, sensor, {"auto"});
      plan(town, sensor, {"auto"});
      plan(town, sensor, {"clean", "sensor-motion=on"});
    }
    for (const std::string& preset : effectPresets()) plan(town, "HDL-64E", {preset});
    for (const char* effect :
         {"detection.range=60", "drop-out.general_rate=0.1", "range-noise.sigma=0.02", "angle-noise.azimuth=0.002",
          "intensity-noise.sigma=0.05", "returns.count=3", "transmission=on", "cut-outs=on", "sensor-motion=on",
          "object-motion=on", "fog.visibility=60", "rain.rate=20", "snow.rate=2", "radial-speed=on"})
      plan(town, "Puck", {"clean", "intensity=on", effect});
    for (const char* subRays : {"7", "19", "61"})
      for (const char* returns : {"returns=off", "returns.count=3"}) footprint(town, returns, subRays);
    plan(town, "Puck", {"clean", "intensity=on", "radial-speed=auto"}, {}, effectFields());
    Random random(3);
    for (const char* accuracy : {"standard", "exact"})
      plan(limbs(random, 3), "VLP-16", {"clean"}, {std::string("accuracy=") + accuracy});
  }
  std::map<Words, Variant> modules;
  for (const Variant& variant : variants) {
    const vulkan::KernelCode code = vulkan::codeOf(capabilities, variant);
    INFO(nameOf(variant.kernel));
    CHECK(code.specialised);
    modules[code.words] = variant;
  }
  return modules;
}

}  // namespace

TEST_CASE("the kernels of the plans that people use are specialised, and valid then", "[combinations]") {
  const Tools tools;
  vulkan::Capabilities card, oldCard, cpu;
  card.int64Atomics = card.float64 = card.keepsSpecialFloats = card.uniformControlFlow = true;
  card.subgroups = {32};
  oldCard.subgroups = {64};
  oldCard.unrolls = false;
  cpu.cpu = cpu.int64Atomics = cpu.float64 = cpu.keepsVectors = true;
  cpu.subgroups = {8};
  std::vector<const vulkan::Capabilities*> devices = {&card};
  if (everyCombination()) devices = {&card, &oldCard, &cpu};
  for (const vulkan::Capabilities* device : devices) {
    const std::map<Words, Variant> modules = usedModules(*device);
    CHECK(modules.size() > 30);
    for (const auto& [module, variant] : modules) {
      INFO(nameOf(variant.kernel) << " for subgroups of " << device->subgroups.size << " lanes, pass "
                                  << variant.options.PASS);
      tools.validate(module);
    }
  }
}

TEST_CASE("every kernel gives its lanes addresses of their own for a driver that needs them") {
  vulkan::Capabilities driver, other;
  driver.cpu = other.cpu = driver.int64Atomics = other.int64Atomics = true;
  driver.subgroups = other.subgroups = {8};
  driver.loadsUntaken = true;
  for (uint32_t kernel = 0; kernel <= static_cast<uint32_t>(Kernel::records); ++kernel) {
    Variant variant;
    variant.kernel = static_cast<Kernel>(kernel);
    INFO(nameOf(variant.kernel));
    CHECK(vulkan::codeOf(driver, variant).words != vulkan::codeOf(other, variant).words);
  }
}

TEST_CASE("lanes run together wherever a kernel of the plans that people use has operations of subgroups",
          "[combinations]") {
  // These functions return early for reasons that are the same in all lanes of a subgroup. No operation follows a
  // square root of a number below 1.
  const std::set<std::string> together = {"boundAndStore", "cornersOf",  "deformedPosition", "deformerOf",
                                          "endOfEcho",     "findHit",    "handOn",           "list",
                                          "loadHit",       "main",       "morphedPosition",  "nextCluster",
                                          "rangesOf",      "squareRoot", "toSensor",         "tryBoxes",
                                          "tryProjected",  "trySlabs",   "vertexOfMesh",     "verticesOf"};
  vulkan::Capabilities card;
  card.int64Atomics = card.float64 = true;
  card.subgroups = {32};
  std::map<Words, Variant> modules = usedModules(card);
  const Variant fitting = {Kernel::fit_clusters, {}, false};
  modules[vulkan::codeOf(card, fitting).words] = fitting;
  for (const auto& [module, variant] : modules) {
    INFO(nameOf(variant.kernel) << ", pass " << variant.options.PASS);
    CHECK(Reconvergence(module, together).faults() == std::set<std::string>());
  }
}

TEST_CASE("lanes that return early from a function come apart, and meet behind the `if` around its call") {
  const auto faults = [](const std::string& call) {
    const Words module = Tools().compile(R"(#version 460
      #extension GL_KHR_shader_subgroup_arithmetic : require
      layout(local_size_x = 64) in;
      layout(binding = 0) buffer Output { uint y[]; };
      void change(uint i) {
        if (y[i] == 0) return;
        y[i] = 2;
      }
      void main() {
        for (uint i = gl_LocalInvocationID.x; i < 640; i += 64) {
          uint sum = subgroupAdd(y[i]);
          )" + call + R"(
          y[i] += sum;
        }
      })");
    return Reconvergence(module, {}).faults();
  };
  CHECK(faults("change(i);") == std::set<std::string>{"main behind change"});
  CHECK(faults("if (sum > 0) change(i);") == std::set<std::string>());
  CHECK(faults("if (sum > 0) change(i); else return;") == std::set<std::string>{"main behind main"});
}
