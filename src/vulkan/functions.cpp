// SPDX-License-Identifier: Apache-2.0
#include "vulkan/functions.hpp"

namespace gnosphere::vulkan {

#define GNO_LOOK_UP(name_) functions.name_ = reinterpret_cast<PFN_##name_>(lookUp(object, #name_));

InstanceFunctions functionsOf(PFN_vkGetInstanceProcAddr lookUp, VkInstance object) {
  InstanceFunctions functions;
  GNO_INSTANCE_FUNCTIONS(GNO_LOOK_UP)
  return functions;
}

DeviceFunctions functionsOf(PFN_vkGetDeviceProcAddr lookUp, VkDevice object) {
  DeviceFunctions functions;
  GNO_DEVICE_FUNCTIONS(GNO_LOOK_UP)
  return functions;
}

}  // namespace gnosphere::vulkan
