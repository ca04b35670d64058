// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstring>
#include <numbers>
#include <set>
#include <span>
#include <string>

#include "common/effects/arithmetic.h"
#include "every_formula.spv.h"

using namespace gnosphere;

namespace {

double relativeError(float got, double expected) {
  return std::abs(double(got) - expected) / std::abs(expected);
}

/// Calls `call` with values from `first` to `last` in `steps` steps of equal ratio.
template <typename Call>
void sweep(double first, double last, int steps, Call&& call) {
  for (int i = 0; i <= steps; ++i) call(float(first * std::pow(last / first, double(i) / steps)));
}

}  // namespace

TEST_CASE("quotients have errors of at most 3e-7 over the whole range and with any sign") {
  double worst = 0;
  sweep(1e-36, 1e36, 2000000, [&](float b) {
    for (const float a : {1.0f, -0.7f}) worst = std::max(worst, relativeError(gpu::quotient(a, b), double(a) / b));
    worst = std::max(worst, relativeError(gpu::quotient(3.0f, -b), -3.0 / b));
  });
  sweep(1, 2, 1000000, [&](float b) { worst = std::max(worst, relativeError(gpu::quotient(1, b), 1.0 / b)); });
  CHECK(worst < 3e-7);
  CHECK(gpu::quotient(0, 5) == 0);
}

TEST_CASE("square roots have errors of at most 3e-7, also of 0") {
  double worst = 0;
  sweep(1e-36, 1e36, 2000000,
        [&](float x) { worst = std::max(worst, relativeError(gpu::squareRoot(x), std::sqrt(double(x)))); });
  sweep(1, 4, 1000000,
        [&](float x) { worst = std::max(worst, relativeError(gpu::squareRoot(x), std::sqrt(x * 1.0))); });
  CHECK(worst < 3e-7);
  CHECK(gpu::squareRoot(0) == 0);
  CHECK(gpu::squareRoot(-1) == 0);
}

TEST_CASE("inverse square roots have errors of at most 5e-7 over the whole range") {
  double worst = 0;
  const auto check = [&](float x) {
    worst = std::max(worst, relativeError(gpu::inverseRoot(x), 1 / std::sqrt(double(x))));
  };
  sweep(1.01e-37, 0.99e37, 2000000, check);
  sweep(1, 4, 1000000, check);
  CHECK(worst < 5e-7);
}

TEST_CASE("exponentials have errors of at most 3e-7, and underflow to 0") {
  double worst = 0;
  for (int i = -870000; i <= 870000; ++i) {
    const float x = float(i) * 1e-4f;
    worst = std::max(worst, relativeError(gpu::exponential(x), std::exp(double(x))));
  }
  CHECK(worst < 3e-7);
  CHECK(gpu::exponential(0) == 1);
  CHECK(gpu::exponential(-88) == 0);
  CHECK(gpu::exponential(-1e30f) == 0);
  CHECK(std::isfinite(gpu::exponential(1e30f)));
}

TEST_CASE("logarithms have relative errors of at most 3e-7, also near 1") {
  double worst = 0;
  const auto check = [&](float x) {
    if (x != 1.0f) worst = std::max(worst, relativeError(gpu::naturalLog(x), std::log(double(x))));
  };
  sweep(1e-37, 1e37, 2000000, check);
  sweep(0.5, 2, 1000000, check);
  for (float x = 0.999f; x < 1.001f; x = std::nextafter(x, 2.0f)) check(x);
  CHECK(worst < 3e-7);
  CHECK(gpu::naturalLog(1) == 0);
}

TEST_CASE("cosines and sines have errors of at most 2e-7, in every quadrant and for negative turns") {
  double worst = 0;
  for (int i = -4000000; i <= 4000000; ++i) {
    const float turns = float(i) * 0x1p-20f;
    const gpu::vec2 got = gpu::cosSinOfTurn(turns);
    const double angle = 2 * std::numbers::pi * turns;
    worst = std::max({worst, std::abs(got.x - std::cos(angle)), std::abs(got.y - std::sin(angle))});
  }
  CHECK(worst < 2e-7);
  CHECK(gpu::cosSinOfTurn(0).x == 1);
  CHECK(gpu::cosSinOfTurn(0).y == 0);
  CHECK(gpu::cosSinOfTurn(0.25f).y == 1);
}

// The formulas must use no operation that Vulkan may round or fuse freely. A SPIR-V module has five header words, then
// instructions; the first word of each holds its length and its opcode.
TEST_CASE("the SPIR-V of the formulas has only sums and products, none of which may be fused") {
  const std::span<const uint32_t> words = every_formula;
  std::set<uint32_t> unfused;
  for (size_t at = 5; at < words.size(); at += words[at] >> 16)
    if ((words[at] & 0xffff) == 71 && words[at + 2] == 42) unfused.insert(words[at + 1]);  // OpDecorate NoContraction
  int checked = 0;
  for (size_t at = 5; at < words.size(); at += words[at] >> 16) {
    const uint32_t* word = &words[at];
    switch (word[0] & 0xffff) {
      case 129:  // OpFAdd
      case 131:  // OpFSub
      case 133:  // OpFMul
        CHECK(unfused.count(word[2]) == 1);
        ++checked;
        break;
      case 136:  // OpFDiv
      case 140:  // OpFRem
      case 141:  // OpFMod
      case 142:  // OpVectorTimesScalar
      case 148:  // OpDot
        FAIL_CHECK("opcode " << (word[0] & 0xffff));
        break;
      case 12:  // OpExtInst of GLSL.std.450: FAbs, Floor, FMin, UMin, FMax, UMax
        CHECK(std::set<uint32_t>{4, 8, 37, 38, 40, 41}.count(word[4]) == 1);
        break;
      default: break;
    }
  }
  CHECK(checked > 100);
}
