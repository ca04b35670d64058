// SPDX-License-Identifier: Apache-2.0
#include "vulkan/store_results.hpp"

#include <map>

namespace gnosphere::vulkan {
namespace {

class Storing {
 public:
  Storing(std::vector<LiveFunction>& functions, Types& types) : functions_(functions), types_(types) {
    for (const LiveFunction& function : functions) {
      size_t returns = 0;
      for (const Instruction instruction : instructionsOf(function.words))
        returns += opOf(instruction) == spv::OpReturnValue;
      const uint32_t type = function.words[1];
      if (returns > 1 && types.scalars(type) > 1) results_[function.id] = type;
    }
  }

  void rewrite() {
    for (LiveFunction& function : functions_) function.words = rewritten(function);
  }

 private:
  Words rewritten(const LiveFunction& function) {
    const auto own = results_.find(function.id);
    const bool stores = own != results_.end();
    const uint32_t result = stores ? types_.newId() : 0;
    Words head, variables, body, signature = {types_.nothing()};
    for (const Instruction instruction : instructionsOf(function.words)) {
      const spv::Op op = opOf(instruction);
      if (op == spv::OpFunctionParameter) signature.push_back(instruction[1]);
      if (op == spv::OpLabel && body.empty()) {
        if (stores) addParameter(types_.pointer(own->second), result, signature, head);
        append(head, instruction);
      } else if (op == spv::OpFunction || op == spv::OpFunctionParameter) {
        append(head, instruction);
      } else if (op == spv::OpVariable) {
        append(variables, instruction);
      } else if (op == spv::OpReturnValue && stores) {
        append(body, spv::OpStore, {result, instruction[1]});
        append(body, spv::OpReturn, {});
      } else if (op == spv::OpFunctionCall && results_.contains(instruction[3])) {
        writeCall(instruction, variables, body);
      } else {
        append(body, instruction);
      }
    }
    append(head, variables);
    append(head, body);
    return head;
  }

  void addParameter(uint32_t pointer, uint32_t result, Words& signature, Words& head) {
    append(head, spv::OpFunctionParameter, {pointer, result});
    signature.push_back(pointer);
    head[1] = types_.nothing();
    head[4] = types_.function(signature);
  }

  void writeCall(Instruction call, Words& variables, Words& body) {
    const uint32_t type = results_.at(call[3]), variable = types_.newId();
    append(variables, spv::OpVariable, {types_.pointer(type), variable, spv::StorageClassFunction});
    Words arguments(call.begin() + kFirstArgument, call.end());
    arguments.push_back(variable);
    append(body, spv::OpFunctionCall, {types_.nothing(), types_.newId(), call[3]}, arguments);
    append(body, spv::OpLoad, {type, call[2], variable});
  }

  std::vector<LiveFunction>& functions_;
  Types& types_;
  std::map<uint32_t, uint32_t> results_;  // types by the ids of the functions that store them
};

}  // namespace

void storeResults(std::vector<LiveFunction>& functions, Types& types) {
  Storing(functions, types).rewrite();
}

}  // namespace gnosphere::vulkan
