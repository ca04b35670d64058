// SPDX-License-Identifier: Apache-2.0
// Modules with values in place of their specialisation constants, against SPIRV-Tools: spirv-val must accept them, and
// spirv-opt, which replaces the constants by itself, must optimise both to the same operations.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "vulkan/execution_modes.hpp"
#include "vulkan/kernel.hpp"
#include "vulkan/spirv.hpp"
#include "vulkan/spirv_tools.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

/// Returns how many instructions of a module are counted by `counts(instruction)`.
template <typename Counts>
size_t countIn(const Words& module, Counts counts) {
  const auto instructions = vulkan::instructionsOf(std::span(module).subspan(vulkan::kHeaderWords));
  return static_cast<size_t>(std::count_if(instructions.begin(), instructions.end(), counts));
}

size_t functionsIn(const Words& module) {
  return countIn(module, [](vulkan::Instruction one) { return vulkan::opOf(one) == spv::OpFunction; });
}

/// Returns how many variables the functions of a module have.
size_t localsIn(const Words& module) {
  return countIn(module, [](vulkan::Instruction one) {
    return vulkan::opOf(one) == spv::OpVariable && one[3] == spv::StorageClassFunction;
  });
}

/// Returns how many parameters of functions are pointers to variables.
size_t pointersIn(const Words& module) {
  std::set<uint32_t> pointers;
  return countIn(module, [&](vulkan::Instruction one) {
    if (vulkan::opOf(one) == spv::OpTypePointer) pointers.insert(one[1]);
    return vulkan::opOf(one) == spv::OpFunctionParameter && pointers.contains(one[1]);
  });
}

/// Checks two rules that SPIRV-Tools knows only since 2025: a type with a layout is for memory of buffers alone
/// (VUID-StandaloneSpirv-None-10684), and an address is loaded with its own alignment
/// (VUID-StandaloneSpirv-PhysicalStorageBuffer64-06314).
void checkLayouts(const Words& module) {
  std::set<uint32_t> laidOut, wide;           // types with a layout, and those of 8 bytes
  std::map<uint32_t, uint32_t> pointeeTypes;  // by type of pointer
  for (const vulkan::Instruction one : vulkan::instructionsOf(std::span(module).subspan(vulkan::kHeaderWords))) {
    switch (vulkan::opOf(one)) {
      case spv::OpDecorate:
        if (one[2] == spv::DecorationArrayStride) laidOut.insert(one[1]);
        break;
      case spv::OpMemberDecorate:
        if (one[3] == spv::DecorationOffset) laidOut.insert(one[1]);
        break;
      case spv::OpTypeInt:
      case spv::OpTypeFloat:
        if (one[2] == 64) wide.insert(one[1]);
        break;
      case spv::OpTypeArray:
      case spv::OpTypeStruct:
        for (const uint32_t part : one.subspan(2))
          if (laidOut.contains(part)) laidOut.insert(one[1]);
        break;
      case spv::OpTypePointer:
        pointeeTypes[one[1]] = one[3];
        if (one[2] == spv::StorageClassPhysicalStorageBuffer) wide.insert(one[1]);
        break;
      case spv::OpVariable:
        if (one[3] == spv::StorageClassPrivate || one[3] == spv::StorageClassWorkgroup ||
            one[3] == spv::StorageClassFunction)
          CHECK_FALSE(laidOut.contains(pointeeTypes.at(one[1])));
        break;
      case spv::OpLoad:
        if (wide.contains(one[1]) && one.size() > 5 && (one[4] & spv::MemoryAccessAlignedMask)) CHECK(one[5] >= 8);
        break;
      default: break;
    }
  }
}

/// Returns the passes of spirv-opt that put the given constants in place. `booleans` has the numbers of booleans.
std::string placing(const Words& constants, const std::vector<size_t>& booleans) {
  std::string values;
  for (size_t i = 0; i < constants.size(); ++i) {
    const bool boolean = std::find(booleans.begin(), booleans.end(), i) != booleans.end();
    values +=
        std::to_string(i) + ":" + (boolean ? (constants[i] ? "true" : "false") : std::to_string(constants[i])) + " ";
  }
  return "'--set-spec-const-default-value=" + values + "' --freeze-spec-const --fold-spec-const-op-composite";
}

}  // namespace

TEST_CASE("a specialised module means what spirv-opt makes of the same constants") {
  const Tools tools;
  const Words module = tools.compile(R"(#version 460
    layout(local_size_x = 64) in;
    layout(constant_id = 0) const bool A = false;
    layout(constant_id = 1) const bool B = false;
    layout(constant_id = 2) const uint N = 3;
    layout(push_constant) uniform Input { uint x; };
    layout(binding = 0) buffer Output { uint y[]; };
    uint table[N * 2 + 1];
    uint collatz(uint n) {
      uint steps = 0;
      while (n > 1) {
        n = (n & 1) == 0 ? n / 2 : 3 * n + 1;
        if (A) break;
        ++steps;
      }
      return steps;
    }
    uint early(uint n) {
      if (N == 1) return n;
      for (uint i = 0; i < n; ++i) {
        if (B && i == 3) continue;
        if (A || n == 7) return i;
        y[i + 100] = i;
      }
      return 5;
    }
    uint chosen(uint n) {
      switch (n) {
        case 0: return A ? early(n) : collatz(n);
        case 1: if (B) break;
        case 2: n += 7; break;
        default: if (!A && N > 2) n *= 3;
      }
      return n;
    }
    void main() {
      bool odd = (x & 1) == 1;
      table[x % 3] = x;
      if ((A && odd) || (B && N != 2)) y[0] = collatz(x);
      if ((N & 2) != 0) y[1] = early(x); else y[2] = chosen(x);
      for (;;) {
        if (A && B) break;
        y[3] = table[x % 2];
        break;
      }
      while (A) { y[4] += chosen(y[5]); if (y[4] > 9) break; }
    })");
  for (const uint32_t a : {0, 1})
    for (const uint32_t b : {0, 1})
      for (const uint32_t n : {1, 2, 3}) {
        INFO("A = " << a << ", B = " << b << ", N = " << n);
        const Words constants = {a, b, n};
        const Words specialised = vulkan::specialised(module, constants);
        tools.checkMeaning(specialised, module, placing(constants, {0, 1}));
      }
}

TEST_CASE("functions with a single call move into their callers") {
  const Tools tools;
  const Words module = tools.compile(R"(#version 460
    layout(constant_id = 0) const uint N = 3;
    layout(push_constant) uniform Input { uint x; };
    layout(binding = 0) buffer Output { uint y[]; };
    void split(uint n, out uint half_, inout uint odd) {
      half_ = n / 2;
      if ((n & 1) == 1) odd += N; else odd -= 1;
    }
    bool any(uint n) {
      bool found = false;
      for (uint i = 0; i < n && !found; ++i) found = y[i] == N;
      return found;
    }
    uint inner(const uint n) { return n * n; }
    uint outer(uint n) { return n > 4 ? inner(n) + 1 : n; }
    uint twice(uint n) { return n + y[n]; }
    uint early(uint n) {
      if (n == 3) return 7;
      return n + outer(n);
    }
    void main() {
      uint a = 1, b = N;
      for (uint i = 0; i < x; ++i) {
        split(i + x, a, b);
        y[i] = (i > 2 && any(i)) || b == 3 ? a : b;
        b += early(i);
      }
      y[9] = twice(a) + twice(b);
    })");
  for (const uint32_t n : {1, 3}) {
    const Words constants = {n}, specialised = vulkan::specialised(module, constants);
    tools.checkMeaning(specialised, module, placing(constants, {}));
    // The functions main(), twice() and early() are left.
    CHECK(functionsIn(module) == 7);
    CHECK(functionsIn(specialised) == 3);
  }
}

TEST_CASE("functions take values in place of pointers to variables that they only read") {
  const Tools tools;
  const Words module = tools.compile(R"(#version 460
    layout(push_constant) uniform Input { uint x; };
    layout(binding = 0) buffer Output { uint y[]; };
    struct Pair { uint a; vec3 b; uint c[2]; };
    uint inner(Pair p, uint i) { return p.a + p.c[1] + i; }
    uint passed(Pair p, uint n) { return inner(p, n) + inner(p, 2) * uint(p.b.y); }
    uint indexed(Pair p, uint i) { return p.c[i & 1]; }
    uint written(Pair p, uint n) {
      p.a += n;
      n = inner(p, n);
      return n * n;
    }
    uint handed(Pair p, uint n) { return indexed(p, n) + inner(p, n); }
    void both(Pair p, out uint q, inout uint r) {
      q = p.a + r;
      if (q > 3) r += p.c[0];
    }
    void main() {
      Pair p = Pair(x, vec3(x), uint[2](x + 1, x + 2));
      uint q = 0, r = x;
      for (uint i = 0; i < x; ++i) {
        y[i] = passed(p, i) + passed(p, r) + indexed(p, i) + indexed(p, r);
        y[i] += written(p, i) * written(p, q) + handed(p, i) - handed(p, q);
        both(p, q, r);
        both(p, r, q);
        if (i == 5) p.c[1] = r;
      }
    })");
  const Words specialised = vulkan::specialised(module, {});
  tools.checkMeaning(specialised, module);
  CHECK(pointersIn(module) == 13);
  // The parameter p of indexed() is left, p and n of written(), and q and r of both().
  CHECK(pointersIn(specialised) == 5);
}

TEST_CASE("a variable whose single store comes before its loads becomes the value") {
  const Tools tools;
  const Words module = tools.compile(R"(#version 460
    layout(push_constant) uniform Input { uint x; };
    layout(binding = 0) buffer Output { uint y[]; };
    struct Pair { uint a; uint c[2]; };
    uint shared_;
    void main() {
      uint once = y[0] + x;              // removed
      Pair pair = Pair(once, uint[2](y[1], y[2])), part;
      uint only = 3 * once;              // removed: it is stored alone
      uint previous, either, count = 0;  // they are left
      bool any = false;                  // is left
      for (uint i = 0; i < once; ++i) {  // i is left
        uint each = y[i] * once;         // removed
        if (any) y[i + 7] = previous;
        previous = each + 1;
        any = each > 9;
        count += each + pair.c[1];
      }
      if (count > x) either = pair.a;
      part.c[0] = count;                 // is left: a part is stored
      part.a = count + 1;
      y[3] = either + part.a;
      shared_ = part.c[0];
      y[4] = shared_ + pair.c[0];
    })");
  const Words specialised = vulkan::specialised(module, {});
  tools.checkMeaning(specialised, module);
  CHECK(localsIn(specialised) == 6);
}

TEST_CASE("copies of values go") {
  const Tools tools;
  const Words module = tools.compile(R"(#version 460
    layout(push_constant) uniform Input { uint x; };
    layout(binding = 0) buffer Output { float z[100]; uint y[]; };
    void store(uint n, vec2 v) {
      const vec2 twice = 2 * v.yx;
      if (n > 3 && twice.x > sqrt(v.y)) z[n] = mix(twice.x, v.x, 0.5);
    }
    void main() {
      const uint n = y[x];
      const vec2 v = vec2(n, n + x);
      for (uint i = 0; i < n; ++i) store(i * n, n > i ? v : -v);
    })");
  const Words specialised = vulkan::specialised(module, {});
  tools.checkMeaning(specialised, module);
  CHECK(countIn(specialised, [](vulkan::Instruction one) { return vulkan::opOf(one) == spv::OpCopyObject; }) == 0);
}

TEST_CASE("variables are split into variables of their scalars, also those that functions write for their callers") {
  const Tools tools;
  const Words module = tools.compile(R"(#version 460
    layout(push_constant) uniform Input { uint x; };
    layout(binding = 0) buffer Output { float z[100]; uint y[]; };
    struct Part { uint a; uint c[2]; };
    struct Whole { Part first, second; uint d; };
    Part chosen(uint n) {
      if (n > 5) return Part(n, uint[2](3, n));
      return Part(y[n], uint[2](y[n + 1], n));
    }
    void change(inout Whole w, out Part part, uint n) {
      part = chosen(n);
      if (part.a > w.d) w.second = part; else w.first.c[1] = part.c[0] + n;
    }
    uint indexed(Whole w, inout Part part, uint n) {
      part.c[n & 1] += w.d;
      return part.c[n] + part.a;
    }
    void main() {
      Whole whole = Whole(chosen(x), chosen(x + 1), x);
      Part part;
      for (uint i = 0; i < x; ++i) {
        change(whole, part, i);
        change(whole, whole.first, part.a);
        if (i == 7) whole.d = part.c[1];
      }
      Part dynamic = chosen(whole.d);
      y[9] = indexed(whole, dynamic, x) + indexed(whole, dynamic, y[3]);
      y[10] = whole.first.a + whole.first.c[1] + whole.second.c[0] + whole.d;
    })");
  const Words split = vulkan::specialised(module, {}, true);
  tools.checkMeaning(split, module);
  std::map<uint32_t, uint32_t> pointees;
  std::set<uint32_t> scalars;
  size_t composites = 0;
  for (const vulkan::Instruction one : vulkan::instructionsOf(std::span(split).subspan(vulkan::kHeaderWords))) {
    const spv::Op op = vulkan::opOf(one);
    if (op == spv::OpTypeInt || op == spv::OpTypeBool) scalars.insert(one[1]);
    if (op == spv::OpTypePointer && one[2] == spv::StorageClassFunction) pointees[one[1]] = one[3];
    if (op == spv::OpVariable || op == spv::OpFunctionParameter)
      composites += pointees.contains(one[1]) && !scalars.contains(pointees.at(one[1]));
  }
  // The second parameter of indexed() is left whole, because its parts have no fixed place, and so is the copy of its
  // argument that each call makes.
  CHECK(composites == 3);
}

TEST_CASE("constants that decide the same branches give the same words") {
  const Tools tools;
  const Words module = tools.compile(R"(#version 460
    layout(constant_id = 0) const uint N = 3;
    layout(constant_id = 1) const uint UNUSED = 3;
    layout(constant_id = 2) const uint USED = 3;
    layout(binding = 0) buffer Output { uint y[]; };
    void main() { if (N > 100) y[0] = 1; else y[USED] = 2; })");
  const auto with = [&](uint32_t n, uint32_t unused, uint32_t used) {
    const Words specialised = vulkan::specialised(module, Words{n, unused, used});
    tools.validate(specialised);
    return specialised;
  };
  const Words words = with(200, 1000, 2000);
  CHECK(words == with(300, 1001, 2001));  // the branch that uses the last one is gone
  CHECK(words != with(90, 1000, 2000));
  CHECK(with(90, 1000, 2000) != with(90, 1000, 2001));
  CHECK(with(90, 1000, 2000) == with(80, 1002, 2000));
}

TEST_CASE("a constant expression that cannot be computed is an error, not a wrong module") {
  const Words module = Tools().compile(R"(#version 460
    layout(constant_id = 0) const uint N = 3;
    layout(binding = 0) buffer Output { uint y[]; };
    void main() { y[0] = N << 2; })");
  REQUIRE_THROWS_AS(vulkan::specialised(module, Words{1}), std::logic_error);
  // Then the driver gets the module as it is, with the constants beside it.
  const vulkan::Code code = vulkan::codeOf(module, Words{1});
  CHECK(code.words == module);
  CHECK(!code.specialised);
}

TEST_CASE("every kernel is a valid module with any options") {
  const Tools tools;
  std::mt19937 random(5);
  std::ifstream list(GNOSPHERE_SPIRV_LIST);
  size_t modules = 0;
  for (std::string file; std::getline(list, file); ++modules)
    for (int i = 0; i < 2; ++i) {
      OptionWords words;
      for (uint32_t& word : words) word = static_cast<uint32_t>(random() >> random() % 32);
      Options options = std::bit_cast<Options>(words);
      for (uint32_t* part : {&options.BOUNDS, &options.CULL, &options.INSIDE, &options.RANGE, &options.FACES,
                             &options.BINNING, &options.PASS})
        *part %= 4;
      for (uint32_t* flag : {&options.AZIMUTH_OFFSETS, &options.MOTION, &options.LISTED, &options.MAPPED,
                             &options.ORIGINS, &options.STAGGERED})
        *flag %= 2;
      options.LAYERS = options.LAYERS % 4 + 1, options.RETURNS = options.RETURNS % 6 + 1;
      options.RAYS = placesFor(options.RAYS % 64);
      INFO(file << ", " << i);
      const Words module = vulkan::specialised(wordsIn(file), wordsOf(options), i == 1);
      const Words demanding = vulkan::withUniformControlFlow(vulkan::keepingSpecialFloats(module));
      CHECK(demanding.size() > module.size());
      tools.validate(demanding);
      checkLayouts(demanding);
    }
  CHECK(modules > 10);
}

TEST_CASE("kernels of a plain scan are optimised to the operations that spirv-opt finds by itself") {
  const Tools tools;
  const fs::path folder = [] {
    std::ifstream list(GNOSPHERE_SPIRV_LIST);
    std::string file;
    std::getline(list, file);
    return fs::path(file).parent_path();
  }();
  Options options = {2, 1, 1, 1};
  options.BINNING = 2, options.CULLING = 31;
  const OptionWords words = wordsOf(options);
  const Words constants(words.begin(), words.end());
  for (const char* kernel : {"project_groups_int64", "bin_int64", "resolve"}) {
    INFO(kernel);
    const Words module = wordsIn(folder / (std::string(kernel) + ".spv"));
    const Words specialised = vulkan::specialised(module, constants);
    CHECK(specialised.size() < module.size());
    CHECK(tools.optimised(specialised) == tools.optimised(module, placing(constants, {4, 13, 14, 15})));
  }
}
