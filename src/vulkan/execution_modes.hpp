// SPDX-License-Identifier: Apache-2.0
// Promises that a SPIR-V module asks of the compiler. glslang knows no source for them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gnosphere::vulkan {

/// Returns the module with the demand that -0, NaN and infinity keep their meaning in single precision.
std::vector<uint32_t> keepingSpecialFloats(std::span<const uint32_t> module);

/// Returns the module with the demand that the lanes of a subgroup meet again where their ways join. The device must
/// have been created with VK_KHR_shader_subgroup_uniform_control_flow.
std::vector<uint32_t> withUniformControlFlow(std::span<const uint32_t> module);

}  // namespace gnosphere::vulkan
