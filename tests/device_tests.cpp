// SPDX-License-Identifier: Apache-2.0
// Which device is chosen, and what is made on it.
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

#include "support.hpp"
#include "vulkan/device.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;
using vulkan::chooseDevice;

DeviceInfo deviceOf(const char* name, const char* type, bool usable = true) {
  DeviceInfo info;
  info.name = name;
  info.type = type;
  info.usable = usable;
  if (!usable) info.reason = "it is made of brass";
  return info;
}

}  // namespace

TEST_CASE("a number is a device's index, or else part of its name") {
  const std::vector<DeviceInfo> devices = {deviceOf("llvmpipe (LLVM 15.0.6, 256 bits)", "cpu"),
                                           deviceOf("NVIDIA GeForce RTX 4090", "discrete"),
                                           deviceOf("Old 3090", "discrete", false)};
  CHECK(chooseDevice(devices, "auto") == 1);
  CHECK(chooseDevice(devices, "0") == 0);
  CHECK(chooseDevice(devices, "1") == 1);
  CHECK(chooseDevice(devices, "4090") == 1);
  CHECK(chooseDevice(devices, "256") == 0);
  CHECK(chooseDevice(devices, "rtx") == 1);
  CHECK_THROWS_WITH(chooseDevice(devices, "2"), "the device 'Old 3090' cannot be used: it is made of brass");
  CHECK_THROWS_WITH(chooseDevice(devices, "3090"), "the device 'Old 3090' cannot be used: it is made of brass");
  CHECK_THROWS_WITH(chooseDevice(devices, "7"),
                    ContainsSubstring("there is no device '7', neither with this number nor with these digits in its "
                                      "name; 0: llvmpipe") &&
                        ContainsSubstring("; 2: Old 3090 (it is made of brass); reference: the CPU in double"));
  CHECK_THROWS_WITH(chooseDevice(devices, "99999999999999999999999"), ContainsSubstring("there is no device '999"));
  CHECK_THROWS_WITH(chooseDevice(devices, "brass"), ContainsSubstring("there is no device 'brass'; 0: llvmpipe"));
  CHECK_THROWS_WITH(chooseDevice({}, "0"), ContainsSubstring("no Vulkan device was found"));
}

TEST_CASE("timestamps of fewer than 64 bits give the same times, even where they run over") {
  vulkan::Capabilities capabilities;
  capabilities.timestampMs = 0.5;
  CHECK(capabilities.elapsedMs(10, 30) == 0);
  for (uint32_t bits : {1u, 8u, 32u, 36u, 63u, 64u}) {
    INFO(bits << " bits");
    capabilities.timestampBits = bits;
    const uint64_t most = ~uint64_t{0} >> (64 - bits), noise = ~most & 0xabcdef0123456789u;
    CHECK(capabilities.elapsedMs(0, 1) == 0.5);
    CHECK(capabilities.elapsedMs(most, 0) == 0.5);
    CHECK(capabilities.elapsedMs(most | noise, 0) == 0.5);
    if (bits >= 8) CHECK(capabilities.elapsedMs((most - 99) | noise, 100) == 100);
    CHECK(capabilities.elapsedMs(0, most | noise) == 0.5 * static_cast<double>(most));
  }
}

}  // namespace gnosphere::test
