// SPDX-License-Identifier: Apache-2.0
#include "vulkan/inline_calls.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace gnosphere::vulkan {
namespace {

bool isReturn(Instruction instruction) {
  return opOf(instruction) == spv::OpReturn || opOf(instruction) == spv::OpReturnValue;
}

// True if a function returns only at its end and has no decorated parameter. A copy of the argument takes the place of
// a parameter, and some decorations are valid on parameters alone.
bool isSimple(const LiveFunction& function, const std::set<uint32_t>& decorated) {
  const std::vector<Instruction> instructions = instructionsOf(function.words);
  const auto isDecorated = [&](Instruction instruction) {
    return opOf(instruction) == spv::OpFunctionParameter && decorated.contains(instruction[2]);
  };
  return std::count_if(instructions.begin(), instructions.end(), isReturn) == 1 &&
         isReturn(instructions[instructions.size() - 2]) &&
         std::none_of(instructions.begin(), instructions.end(), isDecorated);
}

// Writes a function together with the functions that are called there alone.
class Inliner {
 public:
  explicit Inliner(const std::map<uint32_t, const LiveFunction*>& inlined) : inlined_(inlined) {}

  Words write(const LiveFunction& function) {
    head_.clear(), body_.clear();
    write(function, {});
    append(head_, body_);
    return head_;
  }

 private:
  // Writes a function in the place of the instruction `call`, or as a function if there is none.
  void write(const LiveFunction& function, Instruction call) {
    const bool whole = call.empty();
    size_t argument = kFirstArgument;
    uint32_t readLabel = 0;  // of the block that is read; it ends as the block writtenLabel_
    for (const Instruction instruction : instructionsOf(function.words)) {
      Words& part = whole && readLabel == 0 ? head_ : body_;
      switch (opOf(instruction)) {
        case spv::OpFunction:
        case spv::OpReturn:
        case spv::OpFunctionEnd:
          if (whole) append(part, instruction);
          break;
        case spv::OpFunctionParameter:
          if (whole)
            append(part, instruction);
          else
            append(part, spv::OpCopyObject, {instruction[1], instruction[2], call[argument++]});
          break;
        case spv::OpReturnValue:
          if (whole)
            append(part, instruction);
          else
            append(part, spv::OpCopyObject, {call[1], call[2], instruction[1]});
          break;
        case spv::OpLabel:
          // The first block of an inlined function continues the block of the call.
          if (whole || readLabel != 0) {
            append(part, instruction);
            writtenLabel_ = instruction[1];
          }
          readLabel = instruction[1];
          ends_[readLabel] = writtenLabel_;
          break;
        case spv::OpVariable:  // the first block of a function holds all variables
          if (instruction.size() > 4) throw std::logic_error("a variable of a SPIR-V function has an initial value");
          append(head_, instruction);
          break;
        case spv::OpPhi: writePhi(instruction); break;
        case spv::OpFunctionCall:
          writeCall(instruction);
          ends_[readLabel] = writtenLabel_;
          break;
        case spv::OpLoopMerge:
          if (readLabel != writtenLabel_) throw std::logic_error("a loop of a SPIR-V module begins with a call");
          [[fallthrough]];
        default: append(part, instruction);
      }
    }
  }

  void writeCall(Instruction call) {
    const auto callee = inlined_.find(call[3]);
    if (callee == inlined_.end())
      append(body_, call);
    else
      write(*callee->second, call);
  }

  // A phi has pairs of a value and the label of the block that it comes from.
  void writePhi(Instruction phi) {
    Words words(phi.begin(), phi.end());
    for (size_t i = 4; i < words.size(); i += 2) words[i] = ends_.at(words[i]);
    append(body_, words);
  }

  const std::map<uint32_t, const LiveFunction*>& inlined_;
  Words head_, body_;                  // up to the variables of the first block, and after them
  uint32_t writtenLabel_ = 0;          // of the block that is written
  std::map<uint32_t, uint32_t> ends_;  // label of the written block in which a block that was read ends
};

}  // namespace

void inlineSingleCalls(std::vector<LiveFunction>& functions, const std::set<uint32_t>& decorated) {
  std::map<uint32_t, int> calls;
  for (const LiveFunction& function : functions)
    for (const uint32_t id : function.called) ++calls[id];
  std::map<uint32_t, const LiveFunction*> inlined;
  for (const LiveFunction& function : functions)
    if (calls[function.id] == 1 && isSimple(function, decorated)) inlined[function.id] = &function;
  Inliner inliner(inlined);
  std::vector<LiveFunction> whole;
  for (const LiveFunction& function : functions)
    if (!inlined.contains(function.id)) whole.push_back({function.id, inliner.write(function), {}});
  functions = std::move(whole);
}

}  // namespace gnosphere::vulkan
