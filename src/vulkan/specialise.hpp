// SPDX-License-Identifier: Apache-2.0
// SPIR-V modules with values in place of their specialisation constants.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace gnosphere::vulkan {

/// Returns the module with the value of each specialisation constant in place (constants[SpecId]; booleans are 0 or 1),
/// without the branches that are then never taken and the functions that are then never called, with values in place of
/// variables that have a single value, and with functions that have a single call in the place of that call. Drivers do
/// the same, but only after they have copied every function into its callers, which takes them many times as long. With
/// `split`, variables hold single scalars: see splitVariables().
///
/// The module must come from glslang without optimisation: a block follows all blocks that branch to it, except at the
/// end of a loop, and loops begin without phis. Throws std::logic_error for another module, for operations on constants
/// that no shader needs yet, and for specialisation constants that are neither boolean nor 32-bit integers.
std::vector<uint32_t> specialised(std::span<const uint32_t> module, std::span<const uint32_t> constants,
                                  bool split = false);

/// A module for a driver.
struct Code {
  std::vector<uint32_t> words;
  bool specialised = true;  ///< false if the constants must be given to the driver
};
/// Returns the specialised module, or the module itself if it has something that specialised() does not know: another
/// compiler than that of the tests may have made it.
Code codeOf(std::span<const uint32_t> module, std::span<const uint32_t> constants, bool split = false);

}  // namespace gnosphere::vulkan
