// SPDX-License-Identifier: Apache-2.0
// Devices on the command line: their list, and messages where there is none.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tools/cli_support.hpp"

using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::EndsWith;
using namespace gnosphere::test;

TEST_CASE("an unknown CUDA device is a one-line error, with or without CUDA in the build") {
  checkRefused("scan floor.obj --device cuda:99", 1, "device 'cuda:99': ");
}

TEST_CASE("the list of devices ends with the reference, which needs no Vulkan") {
  const Workplace place;
  const auto devices =
      place.runJson("devices --json", "VK_DRIVER_FILES=/nonexistent VK_ICD_FILENAMES=/nonexistent").at("devices");
  REQUIRE_FALSE(devices.empty());
  CHECK(devices.back().at("type") == "reference");
  CHECK(devices.back().at("usable") == true);
  CHECK(place.run("devices").status == 0);
}

namespace {

/// Returns the path of lavapipe's manifest. Its name is lvp_icd.json, or has the architecture before the ending. A test
/// is skipped if no such file is there.
std::filesystem::path lavapipesManifest() {
  const std::filesystem::path folder = "/usr/share/vulkan/icd.d";
  std::filesystem::path manifest;
  if (std::filesystem::exists(folder))
    for (const auto& file : std::filesystem::directory_iterator(folder))
      if (file.path().filename().string().starts_with("lvp_icd.")) manifest = file.path();
  if (manifest.empty()) SKIP("lavapipe's manifest is not in " << folder);
  return manifest;
}

}  // namespace

TEST_CASE("a device is listed once, however many manifests its driver has") {
  const std::filesystem::path manifest = lavapipesManifest();
  const Workplace place;
  place.put("again.json", bytesOf(manifest));
  const std::string once = "VK_DRIVER_FILES=" + manifest.string();
  CHECK(place.runJson("devices --json", once).at("devices").size() == 2);
  CHECK(place.runJson("devices --json", once + ":again.json").at("devices").size() == 2);
}

TEST_CASE("a driver that leaves out parts of Vulkan is found") {
  auto manifest = nlohmann::json::parse(bytesOf(lavapipesManifest()));
  manifest["file_format_version"] = "1.0.1";
  manifest["ICD"]["is_portability_driver"] = true;
  const Workplace place;
  place.put("portability.json", manifest.dump());
  CHECK(place.runJson("devices --json", "VK_DRIVER_FILES=portability.json").at("devices").size() == 2);
}

TEST_CASE("without a Vulkan driver one line says how to get one") {
  const Workplace place;
  const std::string noDriver = "VK_DRIVER_FILES=/nonexistent VK_ICD_FILENAMES=/nonexistent";
  const Result scan = place.run("scan floor.obj", noDriver);
  CHECK(scan.status == 1);
  CHECK_THAT(scan.err, ContainsSubstring("apt install mesa-vulkan-drivers brings one") && EndsWith("\n"));
  CHECK_THAT(scan.err, ContainsSubstring("VK_DRIVER_FILES is '/nonexistent' and hides all other drivers: unset it"));
  CHECK(std::count(scan.err.begin(), scan.err.end(), '\n') == 1);
  // The first device is the reference, or one of CUDA; a number too large for 64 bits is not its number.
  CHECK(place.run("scan floor.obj --device 99999999999999999999999", noDriver).status == 1);
  place.put("bad.json", "no manifest");
  const Result bad = place.run("scan floor.obj", "VK_DRIVER_FILES=bad.json VK_ICD_FILENAMES=bad.json");
  CHECK(bad.status == 1);
  CHECK_THAT(bad.err, ContainsSubstring("VK_DRIVER_FILES is 'bad.json' and hides all other drivers: unset it"));
  CHECK(std::count(bad.err.begin(), bad.err.end(), '\n') == 1);
}
