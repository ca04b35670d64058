// SPDX-License-Identifier: Apache-2.0
#include "vulkan/live_branches.hpp"

#include <algorithm>
#include <stdexcept>

namespace gnosphere::vulkan {
namespace {

// Returns the instruction before the last one of a block, if it names the end of a loop or of a selection.
Instruction mergeOf(std::span<const Instruction> block) {
  if (block.size() < 2) return {};
  const Instruction before = block[block.size() - 2];
  return opOf(before) == spv::OpLoopMerge || opOf(before) == spv::OpSelectionMerge ? before : Instruction();
}

}  // namespace

LiveFunction LiveBranches::read(std::span<const Instruction> function) {
  blocks_.clear();
  size_t first = function.size() - 1;
  for (size_t i = function.size() - 1, end = i; i-- > 0;)
    if (opOf(function[i]) == spv::OpLabel) {
      blocks_.push_back({function.subspan(i, end - i)});
      first = end = i;
    }
  std::reverse(blocks_.begin(), blocks_.end());
  for (size_t i = 0; i < blocks_.size(); ++i) places_[blocks_[i].label()] = i;
  if (!blocks_.empty()) blocks_[0].reached = true;
  for (size_t i = 0; i < blocks_.size(); ++i)
    if (blocks_[i].reached) follow(i);

  LiveFunction live = {resultOf(function[0]), {}, {}};
  for (const Instruction instruction : function.first(first)) append(live.words, instruction);
  for (const Block& block : blocks_) write(block, live);
  append(live.words, function.back());
  return live;
}

// Computes the values of a block, and reaches the blocks that may follow.
void LiveBranches::follow(size_t index) {
  Block& block = blocks_[index];
  const Instruction merge = mergeOf(block.instructions);
  const bool loop = !merge.empty() && opOf(merge) == spv::OpLoopMerge;
  for (const Instruction instruction : block.instructions) {
    const spv::Op op = opOf(instruction);
    if (op == spv::OpPhi && loop) throw std::logic_error("a loop of a SPIR-V module begins with a phi");
    if (op == spv::OpPhi) values_.set(resultOf(instruction), valueOfPhi(block, instruction));
    if (op == spv::OpLogicalAnd || op == spv::OpLogicalOr || op == spv::OpLogicalNot)
      values_.set(resultOf(instruction), values_.of(op, instruction.subspan(3)));
  }
  setTargets(block);
  for (const uint32_t target : block.targets) {
    if (places_[target] <= index && !at(target).reached)
      throw std::logic_error("a block of a SPIR-V module comes before one that branches to it");
    at(target).reached = true;
  }
  if (merge.empty() || (block.decided && !loop)) return;
  at(merge[1]).merges = true;
  if (loop) at(merge[2]).header = block.label();
}

void LiveBranches::setTargets(Block& block) {
  const Instruction last = block.instructions.back();
  if (opOf(last) == spv::OpBranch) {
    block.targets = {last[1]};
  } else if (opOf(last) == spv::OpBranchConditional) {
    const std::optional<uint32_t> condition = values_.of(last[1]);
    block.decided = condition.has_value();
    block.targets = {last[2], last[3]};
    if (condition) block.targets = {*condition ? last[2] : last[3]};
  } else if (opOf(last) == spv::OpSwitch) {
    for (size_t i = 2; i < last.size(); i += 2) block.targets.push_back(last[i]);
  }
}

bool LiveBranches::leads(uint32_t from, const Block& to) {
  const Words& targets = at(from).targets;
  return std::find(targets.begin(), targets.end(), to.label()) != targets.end();
}

// A phi has pairs of a value and the label of the block that it comes from.
std::optional<uint32_t> LiveBranches::valueOfPhi(const Block& block, Instruction phi) {
  std::optional<uint32_t> common;
  for (size_t i = 3; i < phi.size(); i += 2) {
    if (!leads(phi[i + 1], block)) continue;
    const std::optional<uint32_t> value = values_.of(phi[i]);
    if (!value || (common && common != value)) return {};
    common = value;
  }
  return common;
}

// A structure keeps the blocks that it names, even if nothing reaches them; then they are empty.
void LiveBranches::write(const Block& block, LiveFunction& live) {
  Words& words = live.words;
  if (!block.reached && !block.merges && block.header == 0) return;
  append(words, block.instructions[0]);
  if (!block.reached)
    return block.header ? append(words, spv::OpBranch, {block.header}) : append(words, spv::OpUnreachable, {});
  for (const Instruction instruction : block.instructions.subspan(1)) {
    const spv::Op op = opOf(instruction);
    if (op == spv::OpFunctionCall) live.called.push_back(instruction[3]);
    if (op == spv::OpPhi)
      writePhi(block, instruction, words);
    else if (op == spv::OpBranchConditional && block.decided)
      append(words, spv::OpBranch, {block.targets[0]});
    else if (op != spv::OpSelectionMerge || !block.decided)
      append(words, instruction);
  }
}

void LiveBranches::writePhi(const Block& block, Instruction phi, Words& words) {
  Words kept(phi.begin(), phi.begin() + 3);
  for (size_t i = 3; i < phi.size(); i += 2)
    if (leads(phi[i + 1], block)) kept.insert(kept.end(), {phi[i], phi[i + 1]});
  kept[0] = static_cast<uint32_t>(kept.size() << spv::WordCountShift | spv::OpPhi);
  append(words, kept);
}

}  // namespace gnosphere::vulkan
