// SPDX-License-Identifier: Apache-2.0
// The compiled kernels of a simulator: which of them are compiled, when, and which share a pipeline.
#include <atomic>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <chrono>
#include <set>
#include <thread>

#include "base/threads.hpp"
#include "support.hpp"
#include "town/town.hpp"
#include "vulkan/device_functions.hpp"
#include "vulkan/kernel.hpp"
#include "vulkan/pipeline_cache.hpp"
#include "vulkan/ready_device.hpp"

namespace gnosphere::test {
namespace {

TEST_CASE("kernels are compiled on all threads, each once, and a failure reaches the caller") {
  needVulkan();
  if (threadCount() == 1) SKIP("there is one thread");
  vulkan::Device device({}, false);
  static std::atomic<int> made, atOnce;  // compilations, and how many had begun before the first one ended
  static VkResult result;
  // Each waits until another one is there, or gives up.
  functionsOf(device).vkCreateComputePipelines = [](VkDevice, VkPipelineCache, uint32_t,
                                                    const VkComputePipelineCreateInfo*, const VkAllocationCallbacks*,
                                                    VkPipeline*) {
    ++made;
    for (int i = 0; i < 10'000 && made < 2; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (atOnce == 0) atOnce = made.load();
    return result;
  };
  const vulkan::PipelineCache cache(device, "off");
  vulkan::Kernels kernels(device, cache);
  Variant groups, sums;
  groups.kernel = Kernel::project_groups;
  sums.kernel = Kernel::prefix_sum;
  const Variant variants[] = {groups, sums, groups};
  made = 0, result = VK_ERROR_OUT_OF_HOST_MEMORY;
  CHECK_THROWS_AS(kernels.prepare(variants), Error);
  made = atOnce = 0, result = VK_SUCCESS;
  kernels.prepare(variants);
  CHECK(atOnce == 2);
  kernels.prepare(variants);
  kernels.prepare({&sums, 1});
  CHECK(made == 2);
}

TEST_CASE("kernels whose options lead to the same code share a pipeline, and no others do") {
  needVulkan();
  vulkan::Device device({}, vulkanOptions().validation);
  const vulkan::PipelineCache cache(device, "off");
  vulkan::Kernels kernels(device, cache);
  Variant plain, motion, culling, careless;
  plain.kernel = motion.kernel = Kernel::prefix_sum;  // it looks at none of these options
  motion.options.MOTION = motion.options.LISTED = 1, motion.options.LAYERS = 3;
  culling.kernel = careless.kernel = Kernel::project_groups;
  culling.options.CULLING = 31;
  const Variant variants[] = {plain, motion, culling, careless};
  kernels.prepare(variants);
  CHECK(kernels.count() == 3);
  CHECK(kernels.of(plain) == kernels.of(motion));
  CHECK(kernels.of(culling) != kernels.of(careless));
  plain.options.RAYS = 7;
  CHECK_FALSE(kernels.of(plain));
  kernels.prepare({&plain, 1});
  CHECK(kernels.of(plain) == kernels.of(motion));  // it was compiled by an earlier call
  CHECK(kernels.count() == 3);
  CHECK_NOTHROW(device.throwOnMessages());
}

TEST_CASE("scans with addresses of their own for each lane, as newer lavapipes need them, have the same bytes") {
  needVulkan();
  const Scene town = makeTown({.triangles = 3'000u});
  const auto scanWith = [&](const char* sensor, bool own) {
    TestOptions options = vulkanOptions();
    options.effects.sensorMotion.use = EffectUse::on;
    vulkan::destroyIdleDevices();
    const vulkan::LentDevice lent = vulkan::lendDevice(options);  // that of the simulator, too
    const_cast<vulkan::Capabilities&>(lent->device.capabilities()).loadsUntaken = own;
    return makeSimulator(town, builtinSensor(sensor), options).scan({{0, 0, 1.8}, {}});
  };
  for (const char* sensor : {"OS1-64", "Avia"}) {
    INFO(sensor);
    const Scan scan = scanWith(sensor, true);
    CHECK(scan.counters.hits > 0);
    CHECK(sameBytes(scan, scanWith(sensor, false)));
  }
}

TEST_CASE("a kernel's digest changes with every word, and with lanes and constants beside it") {
  vulkan::KernelCode code;
  code.words = {1, 2, 3, 0};
  code.constants = {7};
  code.lanes = 8;
  std::set<vulkan::KernelDigest> digests = {vulkan::digestOf(code)};
  code.constants = {8};  // they are in the words
  CHECK(digests.contains(vulkan::digestOf(code)));
  for (uint32_t& word : code.words) {
    word ^= 0x80000000;
    CHECK(digests.insert(vulkan::digestOf(code)).second);
  }
  std::swap(code.words[0], code.words[1]);
  CHECK(digests.insert(vulkan::digestOf(code)).second);
  code.lanes = 16;
  CHECK(digests.insert(vulkan::digestOf(code)).second);
  code.specialised = false;
  CHECK(digests.insert(vulkan::digestOf(code)).second);
  code.constants = {9};
  CHECK(digests.insert(vulkan::digestOf(code)).second);
}

TEST_CASE(
    "a simulator that only compiles plans what another one runs, with what the compiler says, and does not scan") {
  needVulkan();
  const Scene town = makeTown({.triangles = 1'000u});
  SensorRequest request = {builtinSensor("Puck"), Effects::none()};
  request.effects.sensorMotion.use = EffectUse::on;
  TestOptions options = vulkanOptions();
  const Plan expected = Simulator(town, request, options).plan();
  options.compileOnly = true;
  Simulator simulator(town, request, options);
  const Plan plan = simulator.plan();
  CHECK(plan.binning == expected.binning);
  CHECK(plan.bytes() == expected.bytes());
  CHECK(plan.commands.all() == expected.commands.all());
  REQUIRE(plan.stages.size() == expected.stages.size());
  size_t pipelines = 0;
  for (size_t i = 0; i < plan.stages.size(); ++i) {
    const Plan::Stage &stage = plan.stages[i], &other = expected.stages[i];
    CHECK(stage.name == other.name);
    CHECK(stage.dispatches == other.dispatches);
    REQUIRE(stage.pipelines.size() == other.pipelines.size());
    for (size_t k = 0; k < stage.pipelines.size(); ++k, ++pipelines) {
      INFO(stage.pipelines[k].name);
      CHECK(stage.pipelines[k].name == other.pipelines[k].name);
      CHECK(stage.pipelines[k].constants == other.pipelines[k].constants);
      CHECK(stage.pipelines[k].subgroupSize > 0);
      CHECK(stage.pipelines[k].compileMs > 0);
    }
  }
  CHECK(pipelines > 3);
  const auto refusal = Catch::Matchers::ContainsSubstring("this simulator only compiles, so it cannot scan");
  CHECK_THROWS_WITH(simulator.scan({}), refusal);
  CHECK_THROWS_WITH(simulator.scanBatch(std::vector<Shot>(2)), refusal);
  options.device = DeviceChoice::Kind::reference;
  CHECK_THROWS_WITH(Simulator(town, request, options),
                    "compile_only is for a Vulkan device of the library's own, not for reference");
}

TEST_CASE("a CPU compiles kernels with the first scan that needs them, which is no time of the scan") {
  needVulkan();
  TestOptions options = vulkanOptions();
  options.effects.sensorMotion.use = EffectUse::on;
  options.tuning.keepStill = false;  // the second scan would make the still image
  vulkan::destroyIdleDevices();
  Simulator simulator = makeSimulator(makeTown({.triangles = 1'000u}), builtinSensor("Puck"), options);
  const auto compiled = [&] { return vulkan::lendDevice(options)->kernels.count(); };
  if (simulator.device().type != "cpu") {
    const size_t all = compiled();
    CHECK(all > 0);
    (void)simulator.scan({});
    CHECK(compiled() == all);
    return;
  }
  CHECK(compiled() == 0);
  const auto start = std::chrono::steady_clock::now();
  const Scan scan = simulator.scan({{0, 0, 1.8}, {}});
  const std::chrono::duration<double, std::milli> first = std::chrono::steady_clock::now() - start;
  CHECK(scan.counters.hits > 0);
  CHECK(first.count() - scan.timings.wallMs > 1);
  const size_t atRest = compiled();
  CHECK(atRest > 0);
  (void)simulator.scan({{0, 0, 1.8}, {}});
  CHECK(compiled() == atRest);
  Shot drive;
  drive.motion = {{{0, {{0, 0, 1.8}, {}}}, {0.1, {{1, 0, 1.8}, {}}}}};
  Scan moving;
  simulator.scanInto(drive, moving);
  CHECK(compiled() > atRest);
}

}  // namespace
}  // namespace gnosphere::test
