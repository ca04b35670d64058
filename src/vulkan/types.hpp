// SPDX-License-Identifier: Apache-2.0
// The types of a SPIR-V module.
#pragma once

#include <map>

#include "vulkan/spirv.hpp"

namespace gnosphere::vulkan {

/// The types of pointers to variables of functions, and those of functions, which may get further ones.
class Types {
 public:
  /// `bound` is larger than every id of the module.
  explicit Types(uint32_t bound) : bound_(bound) {}

  /// Reads an instruction before the first function.
  void read(Instruction instruction) {
    if (opOf(instruction) == spv::OpTypePointer && instruction[2] == spv::StorageClassFunction)
      pointees_[instruction[1]] = instruction[3];
    if (opOf(instruction) == spv::OpTypeFunction)
      functions_[{instruction.begin() + 2, instruction.end()}] = instruction[1];
  }

  /// Returns the type that a pointer of this type points to; 0 if it is not a pointer to a variable of a function.
  uint32_t pointee(uint32_t type) const {
    const auto found = pointees_.find(type);
    return found == pointees_.end() ? 0 : found->second;
  }

  /// Returns the type of functions with these types of the result and the parameters.
  uint32_t function(const Words& signature) {
    uint32_t& id = functions_[signature];
    if (id == 0) {
      id = newId();
      added_.push_back(static_cast<uint32_t>((signature.size() + 2) << spv::WordCountShift | spv::OpTypeFunction));
      added_.push_back(id);
      append(added_, signature);
    }
    return id;
  }

  uint32_t newId() { return bound_++; }
  uint32_t bound() const { return bound_; }
  /// The instructions of the types that the module does not have yet.
  const Words& added() const { return added_; }

 private:
  std::map<uint32_t, uint32_t> pointees_;
  std::map<Words, uint32_t> functions_;
  Words added_;
  uint32_t bound_;
};

}  // namespace gnosphere::vulkan
