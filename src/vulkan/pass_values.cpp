// SPDX-License-Identifier: Apache-2.0
#include "vulkan/pass_values.hpp"

#include <map>
#include <utility>

namespace gnosphere::vulkan {
namespace {

class Passing {
 public:
  Passing(std::vector<LiveFunction>& functions, Types& types, const KnownValues& values,
          const std::set<uint32_t>& decorated)
      : functions_(functions), types_(types), values_(values), read_(types.bound()), chains_(types.bound()) {
    for (const LiveFunction& function : functions)
      for (const Instruction instruction : instructionsOf(function.words)) {
        if (opOf(instruction) == spv::OpLabel) break;
        if (opOf(instruction) != spv::OpFunctionParameter) continue;
        const uint32_t id = instruction[2];
        parameters_[function.id].push_back(id);
        if (!decorated.contains(id)) read_[id] = types.pointee(instruction[1]);
      }
    for (const LiveFunction& function : functions)
      for (const Instruction instruction : instructionsOf(function.words)) find(instruction);
  }

  void rewrite() {
    for (LiveFunction& function : functions_) {
      Words words;
      words.reserve(function.words.size());
      for (const Instruction instruction : instructionsOf(function.words)) write(instruction, function, words);
      function.words = std::move(words);
    }
  }

 private:
  // Finds the parameters that an instruction does not only read.
  void find(Instruction instruction) {
    const spv::Op op = opOf(instruction);
    if (op == spv::OpFunctionParameter || isPlainLoad(instruction)) return;
    if (op == spv::OpAccessChain && read_[instruction[3]] != 0 && values_.knowsIndices(instruction)) {
      chains_[instruction[2]] = instruction;
      return;
    }
    // A literal number with the value of an id counts as a use of the id.
    for (const uint32_t word : instruction.subspan(1)) {
      if (word >= read_.size()) continue;
      read_[word] = 0;
      forbidChain(word);
    }
  }

  void forbidChain(uint32_t id) {
    if (!chains_[id].empty()) read_[chains_[id][3]] = 0;
  }

  // Returns the parameter that gets the argument of a call at this word.
  uint32_t parameterOf(Instruction call, size_t word) const { return parameters_.at(call[3])[word - kFirstArgument]; }

  void write(Instruction instruction, const LiveFunction& function, Words& to) {
    const size_t start = to.size();
    switch (opOf(instruction)) {
      case spv::OpFunction:
        append(to, instruction);
        to[start + 4] = typeOf(function, instruction);
        return;
      case spv::OpFunctionParameter:
        append(to, instruction);
        if (read_[instruction[2]] != 0) to[start + 1] = read_[instruction[2]];
        return;
      case spv::OpAccessChain:
        if (!chains_[instruction[2]].empty() && read_[instruction[3]] != 0) return;
        break;
      case spv::OpLoad:
        if (read_[instruction[3]] != 0)
          return append(to, spv::OpCopyObject, {instruction[1], instruction[2], instruction[3]});
        if (const Instruction chain = chains_[instruction[3]]; !chain.empty() && read_[chain[3]] != 0)
          return appendPart(to, instruction, chain, chain[3], values_);
        break;
      case spv::OpFunctionCall: return writeCall(instruction, to);
      default: break;
    }
    append(to, instruction);
  }

  void writeCall(Instruction call, Words& to) {
    Words words(call.begin(), call.end());
    for (size_t i = kFirstArgument; i < words.size(); ++i) {
      const uint32_t type = read_[parameterOf(call, i)];
      if (type == 0) continue;
      const uint32_t value = types_.newId();
      append(to, spv::OpLoad, {type, value, words[i]});
      words[i] = value;
    }
    append(to, words);
  }

  uint32_t typeOf(const LiveFunction& function, Instruction instruction) {
    Words signature = {instruction[1]};
    for (const Instruction one : instructionsOf(function.words)) {
      if (opOf(one) == spv::OpLabel) break;
      if (opOf(one) == spv::OpFunctionParameter) signature.push_back(read_[one[2]] != 0 ? read_[one[2]] : one[1]);
    }
    return types_.function(signature);
  }

  std::vector<LiveFunction>& functions_;
  Types& types_;
  const KnownValues& values_;
  std::map<uint32_t, Words> parameters_;  // ids by the id of the function
  Words read_;                       // by id: the type of the value if it is a parameter that is only read, or else 0
  std::vector<Instruction> chains_;  // by id: the access with constant indices to a part of a parameter
};

}  // namespace

void passValues(std::vector<LiveFunction>& functions, Types& types, const KnownValues& values,
                const std::set<uint32_t>& decorated) {
  Passing(functions, types, values, decorated).rewrite();
}

}  // namespace gnosphere::vulkan
