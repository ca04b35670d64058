// SPDX-License-Identifier: Apache-2.0
#include "vulkan/forward_stores.hpp"

namespace gnosphere::vulkan {
namespace {

constexpr size_t kNone = ~size_t{0};

// Whether the instruction only computes its result.
bool isPure(Instruction instruction) {
  const spv::Op op = opOf(instruction);
  return isPlainLoad(instruction) || op == spv::OpAccessChain || op == spv::OpCopyObject ||
         op == spv::OpCompositeExtract || op == spv::OpCompositeConstruct;
}

// Returns the words of an instruction that are ids of values, as far as copies of values have a use there.
std::span<uint32_t> valuesOf(std::span<uint32_t> instruction) {
  const spv::Op op = opOf(instruction);
  const auto within = [op](spv::Op first, spv::Op last) { return first <= op && op <= last; };
  if (within(spv::OpConvertFToU, spv::OpConvertUToPtr) || within(spv::OpBitcast, spv::OpBitCount))
    return instruction.subspan(3);
  switch (op) {
    case spv::OpReturnValue:
    case spv::OpStore:
    case spv::OpBranchConditional: return instruction.subspan(1, op == spv::OpStore ? 2 : 1);
    case spv::OpCopyObject:
    case spv::OpAccessChain:
    case spv::OpCompositeConstruct:
    case spv::OpPhi: return instruction.subspan(3);
    case spv::OpLoad:
    case spv::OpCompositeExtract: return instruction.subspan(3, 1);
    case spv::OpVectorShuffle: return instruction.subspan(3, 2);
    case spv::OpFunctionCall: return instruction.subspan(kFirstArgument);
    case spv::OpExtInst: return instruction.subspan(5);
    default: return {};
  }
}

// Tells which blocks of a function dominate others. Blocks are numbered in the order of the function.
class Dominators {
 public:
  explicit Dominators(uint32_t bound) : numbers_(bound) {}

  void read(const std::vector<Instruction>& function) {
    size_t count = 0;
    for (const Instruction instruction : function)
      if (opOf(instruction) == spv::OpLabel) numbers_[instruction[1]] = count++;
    parents_.assign(count, kNone);
    depths_.assign(count, 0);
    // A block follows all blocks that branch to it, except at the end of a loop, so one pass is enough.
    size_t block = kNone;
    for (const Instruction instruction : function) switch (opOf(instruction)) {
        case spv::OpLabel: block = numbers_[instruction[1]]; break;
        case spv::OpBranch: reach(block, instruction[1]); break;
        case spv::OpBranchConditional:
          reach(block, instruction[2]);
          reach(block, instruction[3]);
          break;
        case spv::OpSwitch:
          for (size_t i = 2; i < instruction.size(); i += 2) reach(block, instruction[i]);
          break;
        default: break;
      }
  }

  bool dominates(size_t first, size_t second) const {
    while (second != kNone && depths_[second] > depths_[first]) second = parents_[second];
    return first == second;
  }

 private:
  void reach(size_t from, uint32_t label) {
    const size_t to = numbers_[label];
    const bool unreached = from != 0 && parents_[from] == kNone;
    if (to <= from || unreached) return;
    parents_[to] = parents_[to] == kNone ? from : common(parents_[to], from);
    depths_[to] = depths_[parents_[to]] + 1;
  }

  size_t common(size_t first, size_t second) const {
    while (first != second)
      if (depths_[first] > depths_[second])
        first = parents_[first];
      else
        second = parents_[second];
    return first;
  }

  std::vector<size_t> numbers_;  // by label
  std::vector<size_t> parents_;  // by block: the block that dominates it immediately
  std::vector<size_t> depths_;   // by block: how many blocks dominate it
};

class Forwarding {
 public:
  Forwarding(const KnownValues& values, uint32_t bound)
      : values_(values), dominators_(bound), variables_(bound), chains_(bound), originals_(bound), used_(bound) {}

  void rewrite(LiveFunction& function) {
    const std::vector<Instruction> instructions = instructionsOf(function.words);
    dominators_.read(instructions);
    place(instructions, &Forwarding::findStore);
    place(instructions, &Forwarding::findUse);
    Words words;
    words.reserve(function.words.size());
    for (const Instruction instruction : instructions) write(instruction, words);
    function.words = withoutUnused(words);
  }

 private:
  struct Variable {
    bool local = false;      // of a function, without an initial value
    bool forbidden = false;  // has a use that is neither a load nor the store
    bool loaded = false;
    uint32_t stores = 0;
    uint32_t value = 0;              // of the store
    size_t block = 0, position = 0;  // of the store
  };

  // Calls a method for each instruction, with its block and its number.
  void place(const std::vector<Instruction>& instructions, void (Forwarding::*method)(Instruction, size_t, size_t)) {
    size_t block = kNone;
    for (size_t i = 0; i < instructions.size(); ++i) {
      block += opOf(instructions[i]) == spv::OpLabel;
      (this->*method)(instructions[i], block, i);
    }
  }

  void findStore(Instruction instruction, size_t block, size_t position) {
    if (opOf(instruction) == spv::OpVariable) variables_[instruction[2]].local = instruction.size() == 4;
    if (!isPlainStore(instruction)) return;
    Variable& variable = variables_[instruction[1]];
    ++variable.stores;
    variable.value = instruction[2];
    variable.block = block;
    variable.position = position;
  }

  void findUse(Instruction instruction, size_t block, size_t position) {
    if (opOf(instruction) == spv::OpVariable) return;
    if (isPlainStore(instruction)) {
      if (const Instruction chain = chains_[instruction[1]]; !chain.empty()) forbid(chain[3]);
      return forbid(instruction[2]);
    }
    if (isPlainLoad(instruction)) {
      const Instruction chain = chains_[instruction[3]];
      Variable& variable = variables_[chain.empty() ? instruction[3] : chain[3]];
      variable.loaded = true;
      if (!isStoredBefore(variable, block, position)) variable.forbidden = true;
      return;
    }
    if (opOf(instruction) == spv::OpAccessChain && values_.knowsIndices(instruction)) {
      chains_[instruction[2]] = instruction;
      if (const Instruction chain = chains_[instruction[3]]; !chain.empty()) forbid(chain[3]);
      return;
    }
    // A literal number with the value of an id counts as a use of the id.
    for (const uint32_t word : instruction.subspan(1)) {
      if (word >= variables_.size()) continue;
      forbid(word);
      if (const Instruction chain = chains_[word]; !chain.empty()) forbid(chain[3]);
    }
  }

  void forbid(uint32_t id) { variables_[id].forbidden = true; }

  bool isStoredBefore(const Variable& variable, size_t block, size_t position) const {
    if (!variable.local || variable.stores != 1) return false;  // others may be stored in blocks of other functions
    return variable.block == block ? variable.position < position : dominators_.dominates(variable.block, block);
  }

  // Whether the function has no such variable any more.
  bool goes(uint32_t id) const {
    const Variable& variable = variables_[id];
    return variable.local && !variable.forbidden;
  }

  void write(Instruction instruction, Words& to) {
    switch (opOf(instruction)) {
      case spv::OpVariable:
        if (goes(instruction[2])) return;
        break;
      case spv::OpStore:
        if (goes(instruction[1])) return;
        break;
      case spv::OpAccessChain:
        if (!chains_[instruction[2]].empty() && goes(instruction[3])) return;
        break;
      case spv::OpLoad:
        if (goes(instruction[3])) return copy(instruction, variables_[instruction[3]].value, to);
        if (const Instruction chain = chains_[instruction[3]]; !chain.empty() && goes(chain[3]))
          return appendPart(to, instruction, chain, originalOf(variables_[chain[3]].value), values_);
        break;
      case spv::OpCopyObject: return copy(instruction, instruction[3], to);
      default: break;
    }
    const size_t start = to.size();
    append(to, instruction);
    for (uint32_t& id : valuesOf(std::span(to).subspan(start))) id = originalOf(id);
  }

  // Writes a copy of a value in the place of an instruction.
  void copy(Instruction instruction, uint32_t value, Words& to) {
    originals_[instruction[2]] = originalOf(value);
    append(to, spv::OpCopyObject, {instruction[1], instruction[2], originalOf(value)});
  }

  uint32_t originalOf(uint32_t value) const { return originals_[value] == 0 ? value : originals_[value]; }

  // Returns the instructions of a function but for values that no instruction uses.
  Words withoutUnused(const Words& function) {
    const std::vector<Instruction> instructions = instructionsOf(function);
    std::vector<bool> kept(instructions.size());
    for (size_t i = instructions.size(); i-- > 0;) {
      const Instruction instruction = instructions[i];
      const uint32_t result = resultOf(instruction);
      kept[i] = !isPure(instruction) || used_[result];
      if (!kept[i]) continue;
      for (const uint32_t word : instruction.subspan(1))
        if (word < used_.size() && word != result) used_[word] = true;
    }
    Words words;
    words.reserve(function.size());
    for (size_t i = 0; i < instructions.size(); ++i)
      if (kept[i]) append(words, instructions[i]);
    return words;
  }

  const KnownValues& values_;
  Dominators dominators_;
  std::vector<Variable> variables_;  // by id
  std::vector<Instruction> chains_;  // by id: the access to a part, with constant indices
  std::vector<uint32_t> originals_;  // by id: the value of which it is a copy, or 0
  std::vector<bool> used_;           // by id: whether an instruction that is kept uses it
};

}  // namespace

void forwardStores(std::vector<LiveFunction>& functions, const KnownValues& values, uint32_t bound) {
  Forwarding forwarding(values, bound);
  for (LiveFunction& function : functions) forwarding.rewrite(function);
}

}  // namespace gnosphere::vulkan
