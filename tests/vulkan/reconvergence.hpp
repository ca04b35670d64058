// SPDX-License-Identifier: Apache-2.0
// Finds operations of subgroups that some lanes of a subgroup may reach without the others. With
// VK_KHR_shader_subgroup_uniform_control_flow, lanes that enter an `if` or a loop together run together again behind
// it, if all of them leave it there. Nothing is promised behind the call of a function from which some return early.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "vulkan/spirv.hpp"

namespace gnosphere::test {

class Reconvergence {
 public:
  /// Lanes return from the functions with the names in `together` at the same places.
  Reconvergence(std::span<const uint32_t> module, const std::set<std::string>& together) : together_(together) {
    uint32_t current = 0;
    const auto instructions = vulkan::instructionsOf(module.subspan(vulkan::kHeaderWords));
    for (const vulkan::Instruction instruction : instructions) {
      const spv::Op op = vulkan::opOf(instruction);
      if (op == spv::OpName) names_[instruction[1]] = nameIn(instruction);
      if (op == spv::OpConstant && instruction.size() == 4) constants_[instruction[2]] = instruction[3];
      if (op == spv::OpFunction) functions_[current = instruction[2]].name = names_[instruction[2]];
      if (current != 0) functions_[current].instructions.push_back(instruction);
    }
    for (auto& [id, function] : functions_) read(function);
  }

  /// Returns each fault as "OUTER behind INNER": OUTER has an operation of a subgroup, or a call that leads to one,
  /// where INNER has parted the lanes.
  const std::set<std::string>& faults() const { return faults_; }

 private:
  struct Function {
    std::string name = {};
    std::vector<vulkan::Instruction> instructions = {};
    bool done = false;
    bool operates = false;    // has operations of subgroups, or calls a function that has some
    std::string parted = {};  // the function that parts the lanes behind a call of this one; empty if none does
  };
  struct Structure {
    std::string parted;  // before it
    size_t returns;
  };

  // The name of a function without its parameters.
  static std::string nameIn(vulkan::Instruction name) {
    const std::string text = reinterpret_cast<const char*>(&name[2]);
    return text.substr(0, text.find('('));
  }

  bool isOperation(vulkan::Instruction instruction) const {
    const spv::Op op = vulkan::opOf(instruction);
    return (op >= spv::OpGroupNonUniformElect && op <= spv::OpGroupNonUniformQuadSwap) ||
           (op == spv::OpControlBarrier && !meets(instruction));
  }
  // Lanes wait for one another at a barrier of their subgroup.
  bool meets(vulkan::Instruction instruction) const {
    return vulkan::opOf(instruction) == spv::OpControlBarrier &&
           constants_.at(instruction[1]) == uint32_t{spv::ScopeSubgroup};
  }

  static void join(std::string& parted, const std::string& other) {
    if (parted.empty()) parted = other;
  }

  void read(Function& function) {
    if (function.done) return;
    function.done = true;
    std::map<uint32_t, std::string>
        looped;  // what has parted the lanes when a loop goes round, by the label of its start
    while (readOnce(function, looped)) {
    }
  }

  // Returns whether the lanes come apart in a loop in which they were together so far.
  bool readOnce(Function& function, std::map<uint32_t, std::string>& looped) {
    std::map<uint32_t, std::string> before;    // what has parted the lanes before a block, by label
    std::map<uint32_t, Structure> structures;  // by the label of the block behind
    std::set<uint32_t> loops;
    std::string parted, entered;  // before an instruction, and before the first round of a loop
    size_t returns = 0;
    uint32_t label = 0;
    bool again = false;
    for (const vulkan::Instruction instruction : function.instructions) {
      switch (vulkan::opOf(instruction)) {
        case spv::OpLabel: {
          label = instruction[1];
          const auto left = structures.find(label);
          parted = left == structures.end() ? before[label] : left->second.parted;
          const bool some = left != structures.end() && returns > left->second.returns;
          if (some && !together_.contains(function.name)) join(parted, function.name);
          entered = parted;
          join(parted, looped[label]);
          break;
        }
        case spv::OpLoopMerge:
          loops.insert(label);
          structures[instruction[1]] = {entered, returns};
          break;
        case spv::OpSelectionMerge: structures[instruction[1]] = {parted, returns}; break;
        case spv::OpBranch:
        case spv::OpBranchConditional:
        case spv::OpSwitch:
          // Other operands than labels are ids, too, or literals to which no block belongs.
          for (const uint32_t target : instruction.subspan(1)) {
            join(before[target], parted);
            if (!loops.contains(target) || parted.empty() || !looped[target].empty()) continue;
            looped[target] = parted;
            again = true;
          }
          break;
        case spv::OpFunctionCall: {
          Function& called = functions_.at(instruction[3]);
          read(called);
          function.operates = function.operates || called.operates;
          if (called.operates && !parted.empty()) faults_.insert(function.name + " behind " + parted);
          join(parted, called.parted);
          break;
        }
        case spv::OpReturn:
        case spv::OpReturnValue:
          ++returns;
          join(function.parted, parted);
          break;
        default:
          if (meets(instruction)) parted.clear();
          if (!isOperation(instruction)) break;
          function.operates = true;
          if (!parted.empty()) faults_.insert(function.name + " behind " + parted);
      }
    }
    if (returns > 1 && !together_.contains(function.name)) function.parted = function.name;
    return again;
  }

  const std::set<std::string>& together_;
  std::map<uint32_t, std::string> names_;
  std::map<uint32_t, uint32_t> constants_;
  std::map<uint32_t, Function> functions_;
  std::set<std::string> faults_;
};

}  // namespace gnosphere::test
