// SPDX-License-Identifier: Apache-2.0
#include "vulkan/ready_device.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <mutex>
#include <utility>

namespace gnosphere::vulkan {
namespace {

// A device with more kernels than this is not kept, so that a process that scans in ever new ways does not grow.
constexpr size_t kMostKernels = 256;

// The settings that a device is made with.
struct Settings {
  std::string name;
  std::array<uint8_t, 16> uuid;
  bool validation;
  std::filesystem::path folder;

  explicit Settings(const SimulatorOptions& options)
      : name(options.device.name),
        uuid(options.device.uuid),
        validation(options.validation),
        folder(cacheFolder(options.cache)) {}
  bool operator==(const Settings&) const = default;
};

struct OwnDevice : ReadyDevice {
  explicit OwnDevice(const SimulatorOptions& options) : ReadyDevice(options), settings(options) {}
  Settings settings;
  pid_t process = getpid();
};

// The devices that no simulator uses, the one used last first. The end of the process destroys none of them, because
// drivers may have unloaded parts of themselves before.
struct Idle {
  std::mutex mutex;
  std::array<OwnDevice*, 2> devices = {};
};
Idle& idle() {
  static Idle& one = *new Idle;
  return one;
}

// A process that was forked has no threads of the driver, so what its parent has kept is of no use, nor can it be
// destroyed.
void forgetParents(Idle& all) {
  for (OwnDevice*& device : all.devices)
    if (device && device->process != getpid()) device = nullptr;
}

}  // namespace

LentDevice lendDevice(const SimulatorOptions& options) {
  if (options.device.adopted) return LentDevice(new OwnDevice(options));
  const Settings settings(options);
  {
    const std::lock_guard lock(idle().mutex);
    forgetParents(idle());
    for (OwnDevice*& device : idle().devices)
      if (device && device->settings == settings) {
        device->device.limitBuffers(options.tuning.maxBufferBytes);
        return LentDevice(std::exchange(device, nullptr));
      }
  }
  return LentDevice(new OwnDevice(options));
}

void GiveBack::operator()(ReadyDevice* device) const noexcept {
  auto* given = static_cast<OwnDevice*>(device);
  if (!given->failed && !given->device.adopted() && given->kernels.count() <= kMostKernels) {
    const std::lock_guard lock(idle().mutex);
    forgetParents(idle());
    // Each device moves one place on, up to the first free place. Without a free place the last device is destroyed.
    for (OwnDevice*& place : idle().devices) {
      std::swap(place, given);
      if (!given) return;
    }
  }
  delete given;
}

void destroyIdleDevices() noexcept {
  const std::lock_guard lock(idle().mutex);
  forgetParents(idle());
  for (OwnDevice*& device : idle().devices) delete std::exchange(device, nullptr);
}

}  // namespace gnosphere::vulkan
