// SPDX-License-Identifier: Apache-2.0
// Clouds of `exact` have the committed hashes on every device; `gnosphere-bench golden --renew` writes the table.
#include <catch2/matchers/catch_matchers_range_equals.hpp>

#include "cuda/twin.hpp"
#include "golden.hpp"

using namespace gnosphere;
using namespace gnosphere::bench;
using namespace gnosphere::test;
using Catch::Matchers::RangeEquals;
using Sentences = std::vector<std::string>;

TEST_CASE("golden: clouds of every Vulkan and CUDA device have the committed hashes",
          "[second-driver][driver-combinations]") {
  needVulkan();
  for (const DeviceInfo& device : listDevices()) {
    if (!device.usable || device.type == "reference") continue;
    INFO(device.name);
    TestOptions options = vulkanOptions();
    options.device = device;
    std::vector<GoldenGroup> groups = goldenGroups();
    std::vector<GoldenCloud> table(goldenTable().begin(), goldenTable().end());
    REQUIRE(table.size() > 6);
    if (fewerCombinations(device)) {  // The first group has no effects.
      groups.resize(1);
      table.resize(groups[0].names.size());
    }
    const std::vector<GoldenCloud> clouds = scanGolden(options, groups);
    CHECK_THAT(differencesOf(clouds, table), RangeEquals(Sentences{}));

    // The comparison finds a wrong digit, a cloud that is not in the table, and one that is there alone.
    const GoldenCloud& wrong = table[0];
    const std::string hash = wrong.hash;
    table[0].hash[7] ^= 1;
    table[2].name = "another";
    CHECK_THAT(differencesOf(clouds, table),
               RangeEquals(Sentences{wrong.name + ": the hash is " + hash + ", not " + wrong.hash,
                                     "another: nobody scans it", clouds[2].name + ": the table has no hash of it"}));
  }
}

TEST_CASE("golden: the CUDA kernels on the host have the committed hashes") {
  const Scene scene = goldenScene();
  std::vector<GoldenCloud> clouds;
  for (const GoldenGroup& group : goldenGroups())
    for (size_t i = 0; i < group.names.size(); ++i) {
      TestOptions options;
      options.accuracy = Accuracy::exact;
      options.effects = group.requests[i].effects;
      options.fields = group.requests[i].fields;
      // Random numbers depend on the index of the sensor.
      CudaOnHost simulator(scene, std::vector(i + 1, group.requests[i].sensor), options);
      clouds.push_back({group.names[i], hashOf(simulator.scan(goldenPose(), i), group.requests[i].fields)});
    }
  CHECK_THAT(differencesOf(clouds, goldenTable()), RangeEquals(Sentences{}));
}
