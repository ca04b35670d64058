// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "common/effects/random.h"
#include "effects/formula_inputs.hpp"

using namespace gnosphere;

namespace {

constexpr int kDraws = 1000000;

gpu::EffectParameters seeded(uint64_t seed) {
  gpu::EffectParameters p = {};
  p.seedLow = uint32_t(seed);
  p.seedHigh = uint32_t(seed >> 32);
  return p;
}

/// Deviation of counts from equal ones, in standard deviations of chi-square.
double unevenness(const std::vector<double>& counts) {
  double sum = 0, chiSquare = 0;
  for (const double count : counts) sum += count;
  const double expected = sum / double(counts.size());
  for (const double count : counts) chiSquare += (count - expected) * (count - expected) / expected;
  const double freedom = double(counts.size()) - 1;
  return (chiSquare - freedom) / std::sqrt(2 * freedom);
}

}  // namespace

TEST_CASE("numbers of frames up to 32 bits are their own keys, and longer ones that differ in one or two bits differ") {
  for (const uint64_t frame : {0u, 1u, 7u, 1u << 31, 0xffffffffu}) CHECK(keyOfFrame(frame) == frame);
  std::set<uint32_t> keys = {keyOfFrame(0)};
  for (int a = 0; a < 64; ++a)
    for (int b = a; b < 64; ++b) keys.insert(keyOfFrame(uint64_t{1} << a | uint64_t{1} << b));
  CHECK(keys.size() == 1 + 64 * 65 / 2);
}

// Test vectors: kat_vectors of Random123 1.14, philox4x32 with 10 rounds.
TEST_CASE("Philox gives the published words") {
  struct Row {
    glm::uvec4 counter;
    uint32_t keyLow, keyHigh;
    glm::uvec4 words;
  };
  const Row rows[] = {{{0, 0, 0, 0}, 0, 0, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
                      {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
                       0xffffffff,
                       0xffffffff,
                       {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
                      {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
                       0xa4093822,
                       0x299f31d0,
                       {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}}};
  for (const Row& row : rows) {
    const glm::uvec4 got = gpu::philox(row.counter, row.keyLow, row.keyHigh);
    for (int i = 0; i < 4; ++i) CHECK(got[i] == row.words[i]);
  }
}

TEST_CASE("uniform numbers are evenly distributed in 0 <= u < 1") {
  const gpu::EffectParameters p = seeded(7);
  std::vector<double> counts(100, 0.0);
  for (uint32_t beam = 0; beam < kDraws; ++beam) {
    const glm::uvec4 words = gpu::draw(p, beam, 0, gpu::kDetection);
    for (int i = 0; i < 4; ++i) counts[size_t(gpu::uniform01(words[i]) * 100)] += 1;
  }
  CHECK(std::abs(unevenness(counts)) < 5);
  CHECK(gpu::uniform01(0) == 0);
  CHECK(gpu::uniform01(0xffffffff) < 1);
  CHECK(gpu::uniformAboveZero(0) > 0);
  CHECK(gpu::uniformAboveZero(0xffffffff) == 1);
}

TEST_CASE("normal numbers have the moments and the distribution of the normal distribution") {
  const gpu::EffectParameters p = seeded(3);
  double moments[5] = {};
  std::vector<double> counts(100, 0.0);
  for (uint32_t beam = 0; beam < kDraws; ++beam) {
    const gpu::vec4 g = gpu::gaussians(gpu::draw(p, beam, 0, gpu::kRangeNoise));
    for (const double x : {g.x, g.y, g.z, g.w}) {
      double power = 1;
      for (double& moment : moments) {
        moment += power;
        power *= x;
      }
      counts[size_t(0.5 * std::erfc(-x / std::sqrt(2.0)) * 100)] += 1;
    }
  }
  const double n = moments[0];
  CHECK(std::abs(moments[1] / n) < 5 / std::sqrt(n));
  CHECK(std::abs(moments[2] / n - 1) < 5 * std::sqrt(2 / n));
  CHECK(std::abs(moments[3] / n) < 5 * std::sqrt(15 / n));
  CHECK(std::abs(moments[4] / n - 3) < 5 * std::sqrt(96 / n));
  CHECK(std::abs(unevenness(counts)) < 5);
}

TEST_CASE("every effect that bits.h has room for draws words of its own") {
  std::set<uint32_t> words;
  for (uint32_t bit = 0; gpu::kFootprint >> bit > 1; ++bit)
    for (uint32_t subRay = 0; subRay < 100; ++subRay) words.insert(gpu::draw(seeded(1), 0, subRay, 1u << bit).x);
  CHECK(words.size() == 3000);
}

TEST_CASE("random numbers of neighbouring beams, sub-rays, frames, sensors and effects are uncorrelated") {
  const gpu::EffectParameters p = seeded(1);
  gpu::EffectParameters frame = p, sensor = p;
  frame.frame = 1;
  sensor.sensor = 1;
  double products[7] = {};
  for (uint32_t beam = 0; beam < kDraws; ++beam) {
    const auto first = [&](const gpu::EffectParameters& with, uint32_t of, uint32_t subRay, uint32_t effect) {
      return gpu::uniform01(gpu::draw(with, of, subRay, effect).x) - 0.5;
    };
    const double x = first(p, beam, 0, gpu::kRangeNoise);
    products[0] += x * first(p, beam + 1, 0, gpu::kRangeNoise);
    products[1] += x * first(p, beam, 1, gpu::kRangeNoise);
    products[2] += x * first(p, beam, 0, gpu::kAngleNoise);
    products[3] += x * first(frame, beam, 0, gpu::kRangeNoise);
    products[4] += x * first(sensor, beam, 0, gpu::kRangeNoise);
    products[5] += x * first(seeded(2), beam, 0, gpu::kRangeNoise);
    products[6] += x * first(seeded(uint64_t{1} << 32 | 1), beam, 0, gpu::kRangeNoise);
  }
  // The product of two independent numbers has mean 0 and standard deviation 1 / 12.
  for (const double product : products) CHECK(std::abs(product / kDraws) < 5.0 / 12 / std::sqrt(kDraws));
}
