// SPDX-License-Identifier: Apache-2.0
#include "vulkan/split_variables.hpp"

#include <map>
#include <utility>

namespace gnosphere::vulkan {
namespace {

constexpr uint32_t kMostScalars = 64;

class Splitting {
 public:
  Splitting(std::vector<LiveFunction>& functions, Types& types, const KnownValues& values,
            const std::set<uint32_t>& decorated)
      : functions_(functions), types_(types), values_(values), variables_(types.bound()), accesses_(types.bound()) {
    for (const LiveFunction& function : functions)
      for (const Instruction instruction : instructionsOf(function.words)) declare(function, instruction, decorated);
    for (const LiveFunction& function : functions)
      for (const Instruction instruction : instructionsOf(function.words)) find(instruction);
    keepPairs();
    for (Variable& variable : variables_)
      for (uint32_t i = 0; i < types.scalars(variable.type); ++i) variable.scalars.push_back(types.newId());
  }

  void rewrite() {
    for (LiveFunction& function : functions_) {
      Words words;
      words.reserve(2 * function.words.size());
      for (const Instruction instruction : instructionsOf(function.words)) write(instruction, function, words);
      function.words = std::move(words);
    }
  }

 private:
  // Describes a variable of a function, or a parameter that points to one.
  struct Variable {
    uint32_t type = 0;   // 0 if the variable stays whole
    Words scalars = {};  // ids of their variables
  };
  struct Part {
    uint32_t type = 0;  // 0 if the variable stays whole
    const uint32_t* scalars = nullptr;
  };

  void declare(const LiveFunction& function, Instruction instruction, const std::set<uint32_t>& decorated) {
    const spv::Op op = opOf(instruction);
    if (op == spv::OpFunctionParameter) parameters_[function.id].push_back(instruction[2]);
    const bool initialised = op == spv::OpVariable && instruction.size() > 4;
    if ((op != spv::OpVariable && op != spv::OpFunctionParameter) || initialised) return;
    const uint32_t type = types_.pointee(instruction[1]), scalars = types_.scalars(type);
    if (1 < scalars && scalars <= kMostScalars && !decorated.contains(instruction[2]))
      variables_[instruction[2]].type = type;
  }

  // Finds accesses to parts, pairs of arguments and parameters, and the variables with a use of another kind.
  void find(Instruction instruction) {
    const spv::Op op = opOf(instruction);
    if (op == spv::OpVariable || op == spv::OpFunctionParameter || isPlainLoad(instruction)) return;
    if (isPlainStore(instruction)) return keepWhole(instruction[2]);
    // An inlined function has copies of the pointers that were its arguments.
    const bool accesses = op == spv::OpCopyObject || (op == spv::OpAccessChain && values_.knowsIndices(instruction));
    if (accesses && isSplit(instruction[3])) {
      accesses_[instruction[2]] = instruction;
      return;
    }
    if (op == spv::OpFunctionCall) {
      for (size_t i = kFirstArgument; i < instruction.size(); ++i)
        pairs_.emplace_back(variableOf(instruction[i]), parameters_.at(instruction[3])[i - kFirstArgument]);
      return;
    }
    // A literal number with the value of an id counts as a use of the id.
    for (const uint32_t word : instruction.subspan(1))
      if (word < variables_.size()) keepWhole(word);
  }

  // Keeps arguments whole where the parameter stays whole, and the other way round.
  void keepPairs() {
    for (bool changed = true; changed;) {
      changed = false;
      for (const auto& [argument, parameter] : pairs_)
        if (isSplit(argument) != isSplit(parameter)) {
          keepWhole(argument);
          keepWhole(parameter);
          changed = true;
        }
    }
  }

  uint32_t variableOf(uint32_t pointer) const {
    while (!accesses_[pointer].empty()) pointer = accesses_[pointer][3];
    return pointer;
  }
  bool isSplit(uint32_t pointer) const { return variables_[variableOf(pointer)].type != 0; }
  void keepWhole(uint32_t pointer) { variables_[variableOf(pointer)].type = 0; }

  Part partOf(uint32_t pointer) const {
    if (pointer >= variables_.size()) return {};
    const Instruction access = accesses_[pointer];
    if (access.empty()) return {variables_[pointer].type, variables_[pointer].scalars.data()};
    Part part = partOf(access[3]);
    if (part.type == 0) return {};
    for (const uint32_t index : access.subspan(4)) {
      const Words& parts = types_.parts(part.type);
      for (uint32_t i = 0; i < *values_.of(index); ++i) part.scalars += types_.scalars(parts[i]);
      part.type = parts[*values_.of(index)];
    }
    return part;
  }

  void write(Instruction instruction, const LiveFunction& function, Words& to) {
    switch (opOf(instruction)) {
      case spv::OpFunction:
        append(to, spv::OpFunction, {instruction[1], instruction[2], instruction[3], typeOf(function)});
        return;
      case spv::OpFunctionParameter:
      case spv::OpVariable:
        if (const Part part = partOf(instruction[2]); part.type != 0)
          return eachScalar(part, [&](uint32_t type, uint32_t scalar) {
            append(to, opOf(instruction), {types_.pointer(type), scalar}, {instruction.begin() + 3, instruction.end()});
          });
        break;
      case spv::OpCopyObject:
        if (const auto parts = parts_.find(instruction[3]); parts != parts_.end())
          parts_[instruction[2]] = parts->second;
        [[fallthrough]];
      case spv::OpAccessChain:
        if (partOf(instruction[2]).type != 0) return;
        break;
      case spv::OpLoad:
        if (Part part = partOf(instruction[3]); part.type != 0) return load(part, instruction[2], to);
        break;
      case spv::OpStore:
        if (Part part = partOf(instruction[1]); part.type != 0) return store(part, instruction[2], to);
        break;
      case spv::OpCompositeConstruct:
        // A vector may also be made of smaller ones.
        if (types_.parts(instruction[1]).size() == instruction.size() - 3)
          parts_[instruction[2]] = {instruction.begin() + 3, instruction.end()};
        break;
      case spv::OpCompositeExtract: return extract(instruction, to);
      case spv::OpFunctionCall: return writeCall(instruction, to);
      default: break;
    }
    append(to, instruction);
  }

  uint32_t typeOf(const LiveFunction& function) {
    Words signature = {function.words[1]};
    for (const Instruction instruction : instructionsOf(function.words)) {
      if (opOf(instruction) == spv::OpLabel) break;
      if (opOf(instruction) != spv::OpFunctionParameter) continue;
      const Part part = partOf(instruction[2]);
      if (part.type == 0) signature.push_back(instruction[1]);
      eachScalar(part, [&](uint32_t type, uint32_t) { signature.push_back(types_.pointer(type)); });
    }
    return types_.function(signature);
  }

  void writeCall(Instruction call, Words& to) {
    Words arguments;
    for (const uint32_t argument : call.subspan(kFirstArgument)) {
      const Part part = partOf(argument);
      if (part.type == 0) arguments.push_back(argument);
      eachScalar(part, [&](uint32_t, uint32_t scalar) { arguments.push_back(scalar); });
    }
    append(to, spv::OpFunctionCall, {call[1], call[2], call[3]}, arguments);
  }

  // Calls f(type, scalar) for each scalar of a part; for none if the variable stays whole.
  template <typename F>
  void eachScalar(Part part, const F& f) {
    if (part.type == 0) return;
    const Words& parts = types_.parts(part.type);
    if (parts.empty()) return f(part.type, *part.scalars);
    for (const uint32_t type : parts) {
      eachScalar({type, part.scalars}, f);
      part.scalars += types_.scalars(type);
    }
  }

  // Loads a part; its scalars are behind it then.
  void load(Part& part, uint32_t result, Words& to) {
    const uint32_t type = part.type;
    const Words& types = types_.parts(type);
    if (types.empty()) return append(to, spv::OpLoad, {type, result, *part.scalars++});
    Words values;
    for (const uint32_t one : types) {
      part.type = one;
      load(part, values.emplace_back(types_.newId()), to);
    }
    append(to, spv::OpCompositeConstruct, {type, result}, values);
    parts_[result] = std::move(values);
  }

  // Stores a part; its scalars are behind it then.
  void store(Part& part, uint32_t value, Words& to) {
    const Words& types = types_.parts(part.type);
    if (types.empty()) return append(to, spv::OpStore, {*part.scalars++, value});
    const auto known = parts_.find(value);
    for (uint32_t i = 0; i < types.size(); ++i) {
      const uint32_t one = known == parts_.end() ? types_.newId() : known->second[i];
      if (known == parts_.end()) append(to, spv::OpCompositeExtract, {types[i], one, value, i});
      part.type = types[i];
      store(part, one, to);
    }
  }

  // Writes an extraction of a part from the values that it was made of, as far as they are known.
  void extract(Instruction instruction, Words& to) {
    uint32_t from = instruction[3];
    Instruction indices = instruction.subspan(4);
    for (auto parts = parts_.find(from); parts != parts_.end() && !indices.empty(); parts = parts_.find(from)) {
      from = parts->second[indices[0]];
      indices = indices.subspan(1);
    }
    if (indices.empty())
      append(to, spv::OpCopyObject, {instruction[1], instruction[2], from});
    else
      append(to, spv::OpCompositeExtract, {instruction[1], instruction[2], from}, {indices.begin(), indices.end()});
  }

  std::vector<LiveFunction>& functions_;
  Types& types_;
  const KnownValues& values_;
  std::map<uint32_t, Words> parameters_;              // ids by the id of the function
  std::map<uint32_t, Words> parts_;                   // the values of which a value was made, by its id
  std::vector<Variable> variables_;                   // by id
  std::vector<Instruction> accesses_;                 // by id: the pointer to a variable, or to a part of one
  std::vector<std::pair<uint32_t, uint32_t>> pairs_;  // arguments and their parameters
};

}  // namespace

void splitVariables(std::vector<LiveFunction>& functions, Types& types, const KnownValues& values,
                    const std::set<uint32_t>& decorated) {
  Splitting(functions, types, values, decorated).rewrite();
}

}  // namespace gnosphere::vulkan
