// SPDX-License-Identifier: Apache-2.0
// The devices of the machine.
#include <algorithm>

#include "c/handles.hpp"

namespace gnosphere::c {

// Programs that were compiled with an older header step through an array of them.
static_assert(sizeof(void*) != 8 || sizeof(gno_device_info) == 80, "gno_device_info never grows");

void describe(const DeviceInfo& device, gno_device_info& info) {
  info.name = device.name.c_str();
  info.type = device.type.c_str();
  info.driver = device.driver.c_str();
  info.api_version = device.apiVersion.c_str();
  info.max_buffer_bytes = device.maxBufferBytes;
  info.subgroup_size = device.subgroupSize;
  info.usable = device.usable;
  info.reason = device.reason.c_str();
  std::copy(device.uuid.begin(), device.uuid.end(), info.uuid);
}

}  // namespace gnosphere::c

using namespace gnosphere;
using namespace gnosphere::c;

extern "C" gno_status gno_devices(const gno_device_info** devices, size_t* count, const char** problem) {
  return guard([&] {
    the(devices, "devices"), the(count, "count");
    thread_local std::vector<DeviceInfo> all;
    thread_local std::vector<gno_device_info> described;
    thread_local std::string why;
    why.clear();
    all = listDevices(&why);
    described.assign(all.size(), gno_device_info_init());
    for (size_t i = 0; i < all.size(); ++i) describe(all[i], described[i]);
    *devices = described.data();
    *count = all.size();
    if (problem) *problem = why.c_str();
  });
}
