// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <catch2/generators/catch_generators.hpp>
#include <string>

#include "support.hpp"

namespace gnosphere::test {

/// Generates the kinds of devices on which memory runs out.
inline DeviceChoice::Kind everyKind() {
  const auto kind = GENERATE(DeviceChoice::Kind::reference, DeviceChoice::Kind::vulkan);
  if (kind == DeviceChoice::Kind::vulkan) needVulkan();
  return kind;
}

inline std::string nameOf(DeviceChoice::Kind kind, const std::string& call) {
  return (kind == DeviceChoice::Kind::reference ? "reference: " : "vulkan: ") + call;
}

}  // namespace gnosphere::test
