// SPDX-License-Identifier: Apache-2.0
// The instructions of a SPIR-V module, and constants computed from them.
#pragma once

#define SPV_ENABLE_UTILITY_CODE
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <spirv/unified1/spirv.hpp>
#include <vector>

namespace gnosphere::vulkan {

using Words = std::vector<uint32_t>;
inline constexpr size_t kHeaderWords = 5;    ///< before the first instruction of a module
inline constexpr size_t kFirstArgument = 4;  ///< word of a call
/// The words of one instruction; the first one holds its length and what it does.
using Instruction = std::span<const uint32_t>;

inline spv::Op opOf(Instruction instruction) {
  return static_cast<spv::Op>(instruction[0] & spv::OpCodeMask);
}

/// Returns the id that an instruction defines; 0 if it defines none.
inline uint32_t resultOf(Instruction instruction) {
  bool result = false, type = false;
  spv::HasResultAndType(opOf(instruction), &result, &type);
  return result ? instruction[type ? 2 : 1] : 0;
}

inline std::vector<Instruction> instructionsOf(std::span<const uint32_t> words) {
  std::vector<Instruction> instructions;
  for (size_t at = 0; at < words.size(); at += instructions.back().size())
    instructions.push_back(words.subspan(at, words[at] >> spv::WordCountShift));
  return instructions;
}

inline void append(Words& words, Instruction instruction) {
  words.insert(words.end(), instruction.begin(), instruction.end());
}
inline void append(Words& words, spv::Op op, std::initializer_list<uint32_t> operands, const Words& further = {}) {
  words.push_back(static_cast<uint32_t>((operands.size() + further.size() + 1) << spv::WordCountShift | op));
  words.insert(words.end(), operands);
  words.insert(words.end(), further.begin(), further.end());
}

/// Loads and stores without further operands, such as volatile.
inline bool isPlainLoad(Instruction instruction) {
  return opOf(instruction) == spv::OpLoad && instruction.size() == 4;
}
inline bool isPlainStore(Instruction instruction) {
  return opOf(instruction) == spv::OpStore && instruction.size() == 3;
}

/// The ids whose values are known; a boolean is 0 or 1.
class KnownValues {
 public:
  explicit KnownValues(uint32_t bound) : values_(bound) {}

  void set(uint32_t id, std::optional<uint32_t> value) { values_[id] = value; }
  std::optional<uint32_t> of(uint32_t id) const { return values_[id]; }

  /// Whether all indices of an access chain are known.
  bool knowsIndices(Instruction chain) const {
    for (const uint32_t index : chain.subspan(4))
      if (!values_[index]) return false;
    return true;
  }

  /// Returns the result of an operation on ids; none if it is not known.
  std::optional<uint32_t> of(spv::Op op, Instruction ids) const {
    const std::optional<uint32_t> a = of(ids[0]), b = ids.size() > 1 ? of(ids[1]) : a;
    if (op == spv::OpLogicalAnd && (a == 0u || b == 0u)) return 0;
    if (op == spv::OpLogicalOr && (a == 1u || b == 1u)) return 1;
    if (op == spv::OpSelect && a) return *a ? b : of(ids[2]);
    if (!a || !b) return {};
    switch (op) {
      case spv::OpLogicalNot: return !*a;
      case spv::OpLogicalAnd: return *a & *b;
      case spv::OpLogicalOr: return *a | *b;
      case spv::OpIEqual: return *a == *b;
      case spv::OpINotEqual: return *a != *b;
      case spv::OpUGreaterThan: return *a > *b;
      case spv::OpULessThanEqual: return *a <= *b;
      case spv::OpBitwiseAnd: return *a & *b;
      case spv::OpIAdd: return *a + *b;
      case spv::OpISub: return *a - *b;
      case spv::OpIMul: return *a * *b;
      default: return {};
    }
  }

 private:
  std::vector<std::optional<uint32_t>> values_;
};

/// Appends the instruction that takes the place of a load from an access chain with known indices: it extracts the
/// part from the value of the variable.
inline void appendPart(Words& words, Instruction load, Instruction chain, uint32_t value, const KnownValues& values) {
  const auto size = static_cast<uint32_t>(chain.size());
  words.insert(words.end(), {size << spv::WordCountShift | spv::OpCompositeExtract, load[1], load[2], value});
  for (const uint32_t index : chain.subspan(4)) words.push_back(*values.of(index));
}

}  // namespace gnosphere::vulkan
