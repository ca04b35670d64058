// SPDX-License-Identifier: Apache-2.0
#include "vulkan/execution_modes.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "vulkan/spirv.hpp"

namespace gnosphere::vulkan {
namespace {

// Newer than some versions of spirv.hpp.
constexpr uint32_t kSubgroupUniformControlFlow = 4421;

bool isBefore(spv::Op op, spv::Op wanted) {
  // The order in which a module has its instructions, as far as it matters here.
  constexpr spv::Op kOrder[] = {spv::OpCapability,  spv::OpExtension,  spv::OpExtInstImport,
                                spv::OpMemoryModel, spv::OpEntryPoint, spv::OpExecutionMode};
  const auto place = [&](spv::Op one) { return std::find(std::begin(kOrder), std::end(kOrder), one); };
  return place(op) <= place(wanted) && place(op) != std::end(kOrder);
}

// Inserts an instruction behind the last one of its section.
std::vector<uint32_t> with(std::span<const uint32_t> module, spv::Op op, const Words& operands) {
  std::vector<uint32_t> words(module.begin(), module.begin() + kHeaderWords);
  bool inserted = false;
  for (const Instruction instruction : instructionsOf(module.subspan(kHeaderWords))) {
    if (!inserted && !isBefore(opOf(instruction), op)) {
      words.push_back(static_cast<uint32_t>(operands.size() + 1) << spv::WordCountShift | op);
      words.insert(words.end(), operands.begin(), operands.end());
      inserted = true;
    }
    words.insert(words.end(), instruction.begin(), instruction.end());
  }
  return words;
}

uint32_t entryPointOf(std::span<const uint32_t> module) {
  for (const Instruction instruction : instructionsOf(module.subspan(kHeaderWords)))
    if (opOf(instruction) == spv::OpEntryPoint) return instruction[2];
  return 0;
}

// A name is padded with zeros to whole words, at least one zero.
Words wordsOf(const char* name) {
  Words words(std::strlen(name) / sizeof(uint32_t) + 1);
  std::memcpy(words.data(), name, std::strlen(name));
  return words;
}

}  // namespace

std::vector<uint32_t> keepingSpecialFloats(std::span<const uint32_t> module) {
  constexpr uint32_t kBits = 32;
  const std::vector<uint32_t> able = with(module, spv::OpCapability, {spv::CapabilitySignedZeroInfNanPreserve});
  return with(able, spv::OpExecutionMode, {entryPointOf(module), spv::ExecutionModeSignedZeroInfNanPreserve, kBits});
}

std::vector<uint32_t> withUniformControlFlow(std::span<const uint32_t> module) {
  const std::vector<uint32_t> named = with(module, spv::OpExtension, wordsOf("SPV_KHR_subgroup_uniform_control_flow"));
  return with(named, spv::OpExecutionMode, {entryPointOf(module), kSubgroupUniformControlFlow});
}

}  // namespace gnosphere::vulkan
