// SPDX-License-Identifier: Apache-2.0
// A beam may have more echoes than it keeps.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "effects/scan_support.hpp"

namespace gnosphere::test {
namespace {

constexpr double kTangent = 0.02;  // of half the footprint

/// Strips of a footprint, side by side, each a metre behind the one to its left. Together they fill the footprint.
struct Strip {
  double distance, begin, end;
  float reflectance;
};
constexpr std::array<Strip, 8> kStrips = {{{10, -1, -0.72, 0.2f},
                                           {11, -0.72, -0.5, 0.9f},
                                           {12, -0.5, -0.3, 0.05f},
                                           {13, -0.3, -0.1, 0.4f},
                                           {14, -0.1, 0.1, 0.02f},
                                           {15, 0.1, 0.3, 0.8f},
                                           {16, 0.3, 0.6, 0.3f},
                                           {17, 0.6, 1, 0.1f}}};

Scene sceneOfStrips(std::span<const Strip> strips) {
  Scene scene;
  for (const Strip& strip : strips) {
    const double d = strip.distance, half = 1.5 * kTangent * d;
    MeshBuilder builder;
    builder.quad({d, strip.end * kTangent * d, -half}, {0, (strip.begin - strip.end) * kTangent * d, 0},
                 {0, 0, 2 * half});
    scene.instances.push_back({"", static_cast<uint32_t>(scene.meshes.size()), {}});
    scene.meshes.push_back(builder.take(static_cast<uint32_t>(scene.materials.size())));
    scene.materials.push_back(lambertian(strip.reflectance));
    scene.materials.back().doubleSided = true;
  }
  return scene;
}

struct Seen {
  double range, intensity;
};

/// The returns of the beam along x, in order of range; no other beam has any.
std::vector<Seen> returnsOf(std::span<const Strip> strips, TestOptions options, uint64_t* lost = nullptr) {
  options.fields = {Field::intensity};
  const Scan scan = scanOn(sceneOfStrips(strips), gridSensor(4, 1, 0, 0, 60), Pose(), options);
  std::vector<Seen> seen;
  const auto intensities = scan.column<float>(Field::intensity);
  for (size_t k = 0; k < scan.ranges.size(); ++k)
    if (scan.hit(k)) seen.push_back({scan.ranges[k], intensities[k]});
  if (lost) *lost = scan.counters.lostEchoes;
  return seen;
}

/// Checks that these are the first of the expected returns.
void checkFirst(const std::vector<Seen>& seen, const std::vector<Seen>& expected) {
  for (size_t k = 0; k < seen.size(); ++k) {
    CHECK(std::abs(seen[k].range - expected[k].range) < 1e-5);
    CHECK(std::abs(seen[k].intensity - expected[k].intensity) < 1e-6);
  }
}

}  // namespace

TEST_CASE("a beam with many echoes keeps the nearest, the farthest and the strongest of those between") {
  for (const char* device : {"vulkan", "reference"}) {
    INFO(device);
    TestOptions options = optionsOn("vulkan");
    if (device == std::string("reference")) options.device = DeviceChoice::Kind::reference;
    options.effects = Effects::none();
    options.effects.intensity = {EffectUse::on, Effects::Intensity::Model::physical, Effects::Intensity::Scale::unit};
    options.effects.divergence = {EffectUse::on, 61, Effects::Divergence::Profile::uniform, 2 * std::atan(kTangent),
                                  2 * std::atan(kTangent)};
    options.effects.returns.use = EffectUse::on;
    options.effects.returns.count = 3;

    std::vector<Seen> alone;
    for (const Strip& strip : kStrips) {
      const std::vector<Seen> seen = returnsOf({&strip, 1}, options);
      REQUIRE(seen.size() == 1);
      CHECK(std::abs(seen[0].range - strip.distance) < 0.05);
      alone.push_back(seen[0]);
    }
    std::vector<Seen> kept(alone.begin() + 1, alone.end() - 1);
    std::ranges::sort(kept, std::greater(), [](const Seen& one) { return one.intensity / (one.range * one.range); });
    kept.resize(4);
    kept.push_back(alone.front());
    kept.push_back(alone.back());
    std::ranges::sort(kept, {}, &Seen::range);
    REQUIRE(kept[2].range > 12.9);  // without the dark strips at 12 and 14 m

    uint64_t lost = 0;
    const std::vector<Seen> all = returnsOf(kStrips, options, &lost);
    CHECK(lost == 2);
    REQUIRE(all.size() == 3);
    checkFirst(all, kept);
    options.effects.returns.count = 4;
    const std::vector<Seen> four = returnsOf(kStrips, options, &lost);
    CHECK(lost == 0);
    REQUIRE(four.size() == 4);
    checkFirst(four, alone);
    // A device compiles for seconds for each number of returns.
    if (options.device.kind == DeviceChoice::Kind::reference) {
      options.effects.returns.count = 8;
      const std::vector<Seen> eight = returnsOf(kStrips, options, &lost);
      CHECK(lost == 0);
      REQUIRE(eight.size() == 8);
      checkFirst(eight, alone);
    }
    options.effects.returns.count = 1;
    options.effects.returns.mode = Effects::Returns::Mode::last;
    CHECK(std::abs(returnsOf(kStrips, options).at(0).range - alone.back().range) < 1e-5);
    options.effects.returns.mode = Effects::Returns::Mode::first;
    CHECK(std::abs(returnsOf(kStrips, options).at(0).range - alone.front().range) < 1e-5);
  }
}

}  // namespace gnosphere::test
