// SPDX-License-Identifier: Apache-2.0
// The types of a SPIR-V module.
#pragma once

#include <map>
#include <set>

#include "base/lasting.hpp"
#include "vulkan/spirv.hpp"

namespace gnosphere::vulkan {

/// The types of values, of pointers to variables of functions, and of functions. The last two may get further ones.
class Types {
 public:
  /// `bound` is larger than every id of the module.
  Types(uint32_t bound, const KnownValues& values) : values_(values), bound_(bound) {}

  /// Reads an instruction before the first function.
  void read(Instruction instruction) {
    switch (opOf(instruction)) {
      case spv::OpTypeVoid: void_ = instruction[1]; break;
      case spv::OpTypeBool:
      case spv::OpTypeInt:
      case spv::OpTypeFloat: scalars_.insert(instruction[1]); break;
      case spv::OpTypeVector:
      case spv::OpTypeMatrix: parts_[instruction[1]] = Words(instruction[3], instruction[2]); break;
      case spv::OpTypeArray:
        if (const std::optional<uint32_t> size = values_.of(instruction[3]))
          parts_[instruction[1]] = Words(*size, instruction[2]);
        break;
      case spv::OpTypeStruct: parts_[instruction[1]] = {instruction.begin() + 2, instruction.end()}; break;
      case spv::OpTypePointer:
        if (instruction[2] == spv::StorageClassFunction) {
          pointees_[instruction[1]] = instruction[3];
          pointers_[instruction[3]] = instruction[1];
        }
        break;
      case spv::OpTypeFunction: functions_[{instruction.begin() + 2, instruction.end()}] = instruction[1]; break;
      default: break;
    }
  }

  /// Returns the type of a function's result if it returns no value.
  uint32_t nothing() const { return void_; }

  /// Returns the types of the parts of a vector, a matrix, an array or a structure; none for other types.
  const Words& parts(uint32_t type) const {
    static const auto& none = lasting(Words());
    const auto found = parts_.find(type);
    return found == parts_.end() ? none : found->second;
  }

  /// Returns the number of scalars of a type; 0 if it has something else, too, such as a pointer.
  uint32_t scalars(uint32_t type) const {
    if (scalars_.contains(type)) return 1;
    uint32_t count = 0;
    for (const uint32_t part : parts(type)) {
      const uint32_t more = scalars(part);
      if (more == 0) return 0;
      count += more;
    }
    return count;
  }

  /// Returns the type that a pointer of this type points to; 0 if it is not a pointer to a variable of a function.
  uint32_t pointee(uint32_t type) const {
    const auto found = pointees_.find(type);
    return found == pointees_.end() ? 0 : found->second;
  }

  /// Returns the type of pointers to variables of a type in functions.
  uint32_t pointer(uint32_t type) {
    uint32_t& id = pointers_[type];
    if (id == 0) {
      id = newId();
      pointees_[id] = type;
      append(added_, spv::OpTypePointer, {id, spv::StorageClassFunction, type});
    }
    return id;
  }

  /// Returns the type of functions with these types of the result and the parameters.
  uint32_t function(const Words& signature) {
    uint32_t& id = functions_[signature];
    if (id == 0) {
      id = newId();
      append(added_, spv::OpTypeFunction, {id}, signature);
    }
    return id;
  }

  uint32_t newId() { return bound_++; }
  uint32_t bound() const { return bound_; }
  /// The instructions of the types that the module does not have yet.
  const Words& added() const { return added_; }

 private:
  const KnownValues& values_;
  std::set<uint32_t> scalars_;
  std::map<uint32_t, Words> parts_;
  std::map<uint32_t, uint32_t> pointees_, pointers_;
  std::map<Words, uint32_t> functions_;
  Words added_;
  uint32_t bound_, void_ = 0;
};

}  // namespace gnosphere::vulkan
