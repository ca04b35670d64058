// SPDX-License-Identifier: Apache-2.0
// The choice of a device: which ones can be used, and which one a name means.
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstring>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "support.hpp"
#include "vulkan/capabilities.hpp"
#include "vulkan/device.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::EndsWith;
using vulkan::chooseDevice;

DeviceInfo deviceOf(const char* name, const char* type, bool usable = true) {
  DeviceInfo info;
  info.name = name;
  info.type = type;
  info.usable = usable;
  if (!usable) info.reason = "it is made of brass";
  return info;
}

vulkan::Offer goodOffer() {
  vulkan::Offer offer;
  offer.compute = true;
  offer.features12.bufferDeviceAddress = VK_TRUE;
  offer.features12.scalarBlockLayout = VK_TRUE;
  offer.subgroup.subgroupSize = 32;
  offer.subgroup.supportedStages = VK_SHADER_STAGE_COMPUTE_BIT;
  offer.subgroup.supportedOperations = ~0u;
  offer.sizes.minSubgroupSize = 32;
  offer.sizeControl.computeFullSubgroups = VK_TRUE;
  return offer;
}

}  // namespace

TEST_CASE("subgroups are full for every size that the device has, or the device is refused") {
  const auto chosen = [](uint32_t size, uint32_t least, bool full, bool sizes = true, VkShaderStageFlags stages = ~0u) {
    vulkan::Offer offer = goodOffer();
    offer.subgroup.subgroupSize = size;
    offer.sizes.minSubgroupSize = least;
    offer.sizes.requiredSubgroupSizeStages = stages;
    offer.sizeControl.computeFullSubgroups = full;
    offer.sizeControl.subgroupSizeControl = sizes;
    const vulkan::FullSubgroups result = fullSubgroupsOf(offer);
    CHECK(reasonAgainst(offer).empty() == (result.size >= 4));
    return std::pair(result.size, result.required);
  };
  CHECK(chosen(2, 1, true) == std::pair(2u, false));  // and is refused
  for (uint32_t size : {4u, 8u, 16u, 32u, 64u}) CHECK(chosen(size, 4, true) == std::pair(size, false));
  CHECK(chosen(32, 8, true, false) == std::pair(32u, false));
  CHECK(chosen(128, 64, true) == std::pair(64u, true));
  CHECK(chosen(128, 16, true) == std::pair(64u, true));
  CHECK(chosen(128, 128, true).first == 0);
  CHECK(chosen(128, 64, true, false).first == 0);
  CHECK(chosen(128, 64, true, true, VK_SHADER_STAGE_VERTEX_BIT).first == 0);
  CHECK(chosen(32, 8, false).first == 0);
}

TEST_CASE("Intel's devices get subgroups of 16 lanes, and of 8 for kernels of many registers, if they can") {
  constexpr uint32_t kIntel = 0x8086;
  vulkan::Offer offer = goodOffer();
  offer.sizes.minSubgroupSize = 8;
  offer.sizes.maxSubgroupSize = 32;
  offer.sizes.requiredSubgroupSizeStages = VK_SHADER_STAGE_COMPUTE_BIT;
  offer.sizeControl.subgroupSizeControl = VK_TRUE;
  const auto chosen = [&] {
    const vulkan::FullSubgroups result = fullSubgroupsOf(offer);
    return std::tuple(result.size, result.required, result.few);
  };
  CHECK(chosen() == std::tuple(32u, false, 0u));
  offer.vendor = kIntel;
  CHECK(chosen() == std::tuple(16u, true, 8u));
  offer.sizes.minSubgroupSize = 16;
  CHECK(chosen() == std::tuple(16u, true, 0u));
  offer.sizes.minSubgroupSize = 32;
  CHECK(chosen() == std::tuple(32u, false, 0u));
  offer.sizes.minSubgroupSize = 8;
  offer.sizeControl.subgroupSizeControl = VK_FALSE;
  CHECK(chosen() == std::tuple(32u, false, 0u));
}

TEST_CASE("a device that lacks a feature is refused with the name of the feature") {
  const auto reason = [](auto change) {
    vulkan::Offer offer = goodOffer();
    change(offer);
    return reasonAgainst(offer);
  };
  CHECK(reason([](vulkan::Offer&) {}) == "");
  CHECK(reason([](vulkan::Offer& offer) { offer.compute = false; }) == "it has no compute queue");
  CHECK(reason([](vulkan::Offer& offer) { offer.features12.scalarBlockLayout = VK_FALSE; }) ==
        "it lacks the scalar block layout");
  CHECK(reason([](vulkan::Offer& offer) { offer.features12.bufferDeviceAddress = VK_FALSE; }) ==
        "its shaders cannot find buffers by address");
  CHECK(reason([](vulkan::Offer& offer) { offer.subgroup.subgroupSize = 2; }) ==
        "its subgroups have 2 lanes, and 4 are needed");
  CHECK(reason([](vulkan::Offer& offer) { offer.sizeControl = {}; }) ==
        "it cannot promise full subgroups, of at most 64 lanes, by VK_EXT_subgroup_size_control; a newer driver may");
  CHECK_THAT(reason([](vulkan::Offer& offer) { offer.subgroup.supportedStages = VK_SHADER_STAGE_FRAGMENT_BIT; }),
             EndsWith("lack operations of subgroups: basic, ballot, vote, shuffle, arithmetic"));
  const std::pair<VkSubgroupFeatureFlags, const char*> operations[] = {
      {VK_SUBGROUP_FEATURE_BALLOT_BIT, "ballot"},
      {VK_SUBGROUP_FEATURE_VOTE_BIT, "vote"},
      {VK_SUBGROUP_FEATURE_SHUFFLE_BIT, "shuffle"},
      {VK_SUBGROUP_FEATURE_ARITHMETIC_BIT, "arithmetic"}};
  for (const auto& [bit, name] : operations)
    CHECK(reason([&](vulkan::Offer& offer) { offer.subgroup.supportedOperations &= ~bit; }) ==
          "its compute shaders lack operations of subgroups: " + std::string(name));
}

TEST_CASE("a lavapipe that ends long loops early is refused with its version and the way out") {
  const auto reason = [](VkDriverId driver, const char* text) {
    vulkan::Offer offer = goodOffer();
    offer.driver.driverID = driver;
    std::strcpy(offer.driver.driverInfo, text);
    return reasonAgainst(offer);
  };
  CHECK(reason(VK_DRIVER_ID_MESA_LLVMPIPE, "Mesa 22.3.6 (LLVM 15.0.6)") ==
        "this lavapipe, Mesa 22.3.6 (LLVM 15.0.6), ends long loops early and would lose hits; Mesa 25.0.7 or newer is "
        "needed, on Debian 12 mesa-vulkan-drivers from bookworm-backports");
  for (const char* text : {"Mesa 9.0", "Mesa 24.3.9", "Mesa 25.0.6", "Mesa ", "", "a text of another kind, 25.0"})
    CHECK(reason(VK_DRIVER_ID_MESA_LLVMPIPE, text) != "");
  for (const char* text : {"Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)", "Mesa 25.2.0-devel (git-0123456789)", "Mesa 100.1.0"})
    CHECK(reason(VK_DRIVER_ID_MESA_LLVMPIPE, text) == "");
  CHECK(reason(VK_DRIVER_ID_MESA_RADV, "Mesa 22.3.6") == "");
}

TEST_CASE("a number selects a device by index, any other text by part of its name") {
  const std::vector<DeviceInfo> devices = {deviceOf("llvmpipe (LLVM 15.0.6, 256 bits)", "cpu"),
                                           deviceOf("NVIDIA GeForce RTX 4090", "discrete"),
                                           deviceOf("Old 3090", "discrete", false)};
  const auto vulkanDevice = [](const char* name) { return DeviceChoice(DeviceChoice::Kind::vulkan, name); };
  CHECK(chooseDevice(devices, DeviceChoice()) == 1);
  CHECK(chooseDevice(devices, vulkanDevice("0")) == 0);
  CHECK(chooseDevice(devices, vulkanDevice("1")) == 1);
  CHECK(chooseDevice(devices, vulkanDevice("4090")) == 1);
  CHECK(chooseDevice(devices, vulkanDevice("256")) == 0);
  CHECK(chooseDevice(devices, vulkanDevice("rtx")) == 1);
  CHECK_THROWS_WITH(chooseDevice(devices, vulkanDevice("2")),
                    "the device 'Old 3090' cannot be used: it is made of brass");
  CHECK_THROWS_WITH(chooseDevice(devices, vulkanDevice("3090")),
                    "the device 'Old 3090' cannot be used: it is made of brass");
  CHECK_THROWS_WITH(chooseDevice(devices, vulkanDevice("7")),
                    ContainsSubstring("there is no device '7', neither with this number nor with this number in its "
                                      "name; 0: llvmpipe") &&
                        ContainsSubstring("; 2: Old 3090 (it is made of brass); reference: the CPU in double"));
  CHECK_THROWS_WITH(chooseDevice(devices, vulkanDevice("5")), ContainsSubstring("there is no device '5'"));
  CHECK_THROWS_WITH(chooseDevice(devices, vulkanDevice("99999999999999999999999")),
                    ContainsSubstring("there is no device '999"));
  CHECK_THROWS_WITH(chooseDevice(devices, vulkanDevice("brass")),
                    ContainsSubstring("there is no device 'brass'; 0: llvmpipe"));
  // Behind the devices of Vulkan are those of CUDA and the reference, which is the last.
  CHECK(deviceByName(std::to_string(listDevices().size() - 1)).kind == DeviceChoice::Kind::reference);
  CHECK_THROWS_WITH(deviceByName(""),
                    ContainsSubstring("device '' is not auto, gpu, the number or a part of the name"));
  CHECK_THROWS_WITH(deviceByName("cuda"), ContainsSubstring("device 'cuda' is not auto"));
  for (const char* name : {"auto", "reference", "cuda:3", "cuda-fast:0", "rtx", "gpu"})
    CHECK(nameOf(deviceByName(name)) == name);
  CHECK(nameOf(DeviceChoice(deviceOf("cuda:12 NVIDIA H100", "cuda"))) == "cuda:12");
  CHECK_THROWS_WITH(chooseDevice({}, deviceByName("0")), ContainsSubstring("no Vulkan device was found"));
}

TEST_CASE("the device gpu is the best that is no CPU, and an error if there is none") {
  const DeviceInfo cpu = deviceOf("llvmpipe (LLVM 15)", "cpu"), card = deviceOf("NVIDIA H100", "discrete"),
                   chip = deviceOf("Intel Arc", "integrated"), broken = deviceOf("Old 3090", "discrete", false);
  for (const char* word : {"gpu", "GPU"}) {
    CHECK(chooseDevice({cpu, chip, card}, deviceByName(word)) == 2);
    CHECK(chooseDevice({chip, cpu}, deviceByName(word)) == 0);
    CHECK(chooseDevice({cpu, broken, chip}, deviceByName(word)) == 2);
  }
  CHECK_THROWS_WITH(chooseDevice({cpu}, deviceByName("gpu")),
                    "no graphics card was found; 0: llvmpipe (LLVM 15); does this process see the card, and is a "
                    "Vulkan driver for it installed? The device 'auto' takes a CPU, too");
  CHECK_THROWS_WITH(chooseDevice({cpu, broken}, deviceByName("gpu")),
                    "the device 'Old 3090' cannot be used: it is made of brass");
  CHECK_THROWS_WITH(chooseDevice({}, deviceByName("gpu")), ContainsSubstring("no Vulkan device was found"));
  // A UUID counts before the name, as that of a DeviceInfo does whose device is called so.
  DeviceInfo named = deviceOf("gpu", "cpu");
  named.uuid[0] = 1;
  CHECK(chooseDevice({card, named}, DeviceChoice(named)) == 1);
  CHECK_THROWS_WITH(chooseDevice({card, chip}, DeviceChoice(named)),
                    "the device with the chosen UUID is no longer there; 0: NVIDIA H100; 1: Intel Arc");
}

}  // namespace gnosphere::test
