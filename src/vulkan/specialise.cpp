// SPDX-License-Identifier: Apache-2.0
#include "vulkan/specialise.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

#include "vulkan/forward_stores.hpp"
#include "vulkan/inline_calls.hpp"
#include "vulkan/live_branches.hpp"
#include "vulkan/pass_values.hpp"
#include "vulkan/split_variables.hpp"
#include "vulkan/store_results.hpp"

namespace gnosphere::vulkan {
namespace {

constexpr size_t kBoundWord = 3;  // of the header

// The instructions before the first function.
class Globals {
 public:
  Globals(std::span<const Instruction> instructions, std::span<const uint32_t> constants, KnownValues& values)
      : values_(values) {
    for (const Instruction instruction : instructions) read(instruction, constants);
  }

  uint32_t entryPoint() const { return entryPoint_; }

  /// Calls f(instruction) for each instruction that a module with these constants has.
  template <typename F>
  void each(F f) const {
    for (const Words& instruction : instructions_) f(Instruction(instruction));
  }

 private:
  void read(Instruction instruction, std::span<const uint32_t> constants) {
    switch (opOf(instruction)) {
      case spv::OpDecorate:
        if (instruction[2] != spv::DecorationSpecId) break;
        if (instruction[3] < constants.size()) given_[instruction[1]] = constants[instruction[3]];
        return;
      case spv::OpEntryPoint: entryPoint_ = instruction[2]; break;
      case spv::OpTypeBool: boolean_ = instruction[1]; break;
      case spv::OpConstantTrue: values_.set(instruction[2], 1); break;
      case spv::OpConstantFalse: values_.set(instruction[2], 0); break;
      case spv::OpConstant:
        if (instruction.size() == 4) values_.set(instruction[2], instruction[3]);
        break;
      case spv::OpSpecConstantTrue: return setConstant(instruction, valueOr(instruction[2], 1));
      case spv::OpSpecConstantFalse: return setConstant(instruction, valueOr(instruction[2], 0));
      case spv::OpSpecConstant:
        if (instruction.size() != 4) throw std::logic_error("a specialisation constant has more than 32 bits");
        return setConstant(instruction, valueOr(instruction[2], instruction[3]));
      case spv::OpSpecConstantOp: {
        const auto op = static_cast<spv::Op>(instruction[3]);
        const std::optional<uint32_t> value = values_.of(op, instruction.subspan(4));
        if (!value) throw std::logic_error("no value for operation " + std::to_string(op) + " on constants");
        return setConstant(instruction, *value);
      }
      default: break;
    }
    instructions_.emplace_back(instruction.begin(), instruction.end());
  }

  uint32_t valueOr(uint32_t id, uint32_t value) const {
    const auto given = given_.find(id);
    return given == given_.end() ? value : given->second;
  }

  // Adds a constant of the same type and id.
  void setConstant(Instruction instruction, uint32_t value) {
    const uint32_t type = instruction[1], id = instruction[2];
    values_.set(id, value);
    Words& words = instructions_.emplace_back();
    if (type == boolean_)
      append(words, value ? spv::OpConstantTrue : spv::OpConstantFalse, {type, id});
    else
      append(words, spv::OpConstant, {type, id, value});
  }

  KnownValues& values_;
  uint32_t entryPoint_ = 0, boolean_ = 0;
  std::map<uint32_t, uint32_t> given_;  // values by id
  std::vector<Words> instructions_;
};

std::vector<LiveFunction> functionsOf(std::span<const Instruction> instructions, KnownValues& values, uint32_t bound) {
  LiveBranches branches(values, bound);
  std::vector<LiveFunction> functions;
  for (size_t i = 0, first = 0; i < instructions.size(); ++i) {
    if (opOf(instructions[i]) == spv::OpFunction) first = i;
    if (opOf(instructions[i]) == spv::OpFunctionEnd)
      functions.push_back(branches.read(instructions.subspan(first, i + 1 - first)));
  }
  return functions;
}

// Removes the functions that the entry point does not lead to.
void keepCalled(std::vector<LiveFunction>& functions, uint32_t entryPoint) {
  Words called = {entryPoint};
  for (size_t i = 0; i < called.size(); ++i)
    for (const LiveFunction& function : functions)
      if (function.id == called[i])
        for (const uint32_t id : function.called)
          if (std::find(called.begin(), called.end(), id) == called.end()) called.push_back(id);
  std::erase_if(functions, [&](const LiveFunction& function) {
    return std::find(called.begin(), called.end(), function.id) == called.end();
  });
}

// Whether an instruction only describes an id, so that it must go if the id is no longer defined.
bool describes(Instruction instruction) {
  const spv::Op op = opOf(instruction);
  return op == spv::OpName || op == spv::OpMemberName || op == spv::OpDecorate || op == spv::OpMemberDecorate;
}

bool isScalarConstant(Instruction instruction) {
  const spv::Op op = opOf(instruction);
  return op == spv::OpConstant || op == spv::OpConstantTrue || op == spv::OpConstantFalse;
}

// Returns for each id whether an instruction may use it. A literal number or text with the value of an id counts as a
// use.
std::vector<bool> usedIds(const Globals& globals, const std::vector<LiveFunction>& functions, uint32_t bound) {
  std::vector<bool> used(bound);
  const auto use = [&](Instruction instruction) {
    const uint32_t result = resultOf(instruction);
    for (const uint32_t word : instruction.subspan(1))
      if (word < bound && word != result) used[word] = true;
  };
  globals.each([&](Instruction instruction) {
    if (!describes(instruction) && !isScalarConstant(instruction)) use(instruction);
  });
  for (const LiveFunction& function : functions)
    for (const Instruction instruction : instructionsOf(function.words)) use(instruction);
  return used;
}

}  // namespace

std::vector<uint32_t> specialised(std::span<const uint32_t> module, std::span<const uint32_t> constants, bool split) {
  const uint32_t bound = module[kBoundWord];
  const std::vector<Instruction> instructions = instructionsOf(module.subspan(kHeaderWords));
  const auto isFunction = [](Instruction instruction) { return opOf(instruction) == spv::OpFunction; };
  const auto functionsStart = std::find_if(instructions.begin(), instructions.end(), isFunction);
  KnownValues values(bound);
  const Globals globals({instructions.begin(), functionsStart}, constants, values);
  std::vector<LiveFunction> functions = functionsOf({functionsStart, instructions.end()}, values, bound);
  keepCalled(functions, globals.entryPoint());
  std::set<uint32_t> decorated;
  globals.each([&](Instruction instruction) {
    if (opOf(instruction) == spv::OpDecorate) decorated.insert(instruction[1]);
  });
  Types types(bound, values);
  globals.each([&](Instruction instruction) { types.read(instruction); });
  passValues(functions, types, values, decorated);
  inlineSingleCalls(functions, decorated);
  if (split) {
    storeResults(functions, types);
    splitVariables(functions, types, values, decorated);
  }
  forwardStores(functions, values, types.bound());

  // The module loses the constants that no instruction uses any more, so that constants of different values which leave
  // the same branches give the same words.
  const std::vector<bool> used = usedIds(globals, functions, types.bound());
  const auto stays = [&](Instruction instruction) { return !isScalarConstant(instruction) || used[instruction[2]]; };
  std::vector<bool> defined(types.bound());
  const auto define = [&](Instruction instruction) { defined[resultOf(instruction)] = true; };
  globals.each([&](Instruction instruction) {
    if (stays(instruction)) define(instruction);
  });
  for (const LiveFunction& function : functions)
    for (const Instruction instruction : instructionsOf(function.words)) define(instruction);
  Words words(module.begin(), module.begin() + kHeaderWords);
  globals.each([&](Instruction instruction) {
    if (describes(instruction) ? defined[instruction[1]] : stays(instruction)) append(words, instruction);
  });
  append(words, types.added());
  for (const LiveFunction& function : functions) append(words, function.words);
  words[kBoundWord] = types.bound();
  return words;
}

Code codeOf(std::span<const uint32_t> module, std::span<const uint32_t> constants, bool split) {
  try {
    return {specialised(module, constants, split)};
  } catch (const std::logic_error&) {
    return {{module.begin(), module.end()}, false};
  }
}

}  // namespace gnosphere::vulkan
