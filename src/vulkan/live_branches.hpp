// SPDX-License-Identifier: Apache-2.0
// Functions of a SPIR-V module without the branches that are never taken.
#pragma once

#include "vulkan/spirv.hpp"

namespace gnosphere::vulkan {

struct LiveFunction {
  uint32_t id = 0;
  Words words;   ///< the whole function, from OpFunction to OpFunctionEnd
  Words called;  ///< ids of the functions that it calls
};

/// Finds the blocks of a function that can be reached, given the values that are known.
class LiveBranches {
 public:
  /// `bound` is larger than every id of the module.
  LiveBranches(KnownValues& values, uint32_t bound) : values_(values), places_(bound) {}

  /// Reads a function from its instructions.
  LiveFunction read(std::span<const Instruction> function);

 private:
  struct Block {
    std::span<const Instruction> instructions;
    Words targets = {};  // labels of the blocks that may follow; none before the block is found to be reached
    bool reached = false;
    bool decided = false;  // only one branch of two is taken
    bool merges = false;   // ends a structure that is reached
    uint32_t header = 0;   // of the loop that is reached and that this block continues
    uint32_t label() const { return instructions[0][1]; }
  };

  Block& at(uint32_t label) { return blocks_[places_[label]]; }
  void follow(size_t index);
  void setTargets(Block& block);
  bool leads(uint32_t from, const Block& to);
  std::optional<uint32_t> valueOfPhi(const Block& block, Instruction phi);
  void write(const Block& block, LiveFunction& live);
  void writePhi(const Block& block, Instruction phi, Words& words);

  KnownValues& values_;
  std::vector<Block> blocks_;
  std::vector<size_t> places_;  // index of a label's block
};

}  // namespace gnosphere::vulkan
