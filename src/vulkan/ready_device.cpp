// SPDX-License-Identifier: Apache-2.0
#include "vulkan/ready_device.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "base/maker_process.hpp"

namespace gnosphere::vulkan {
namespace {

// A device with more kernels than this gets no more simulators, so that a process that scans in ever new ways does not
// grow.
constexpr size_t kMostKernels = 256;

// The number of devices without a simulator that a process keeps.
constexpr ptrdiff_t kMostIdle = 2;

// The settings that a device is made with.
struct Settings {
  std::string name;
  std::array<uint8_t, 16> uuid;
  bool validation;
  std::filesystem::path folder;
  std::shared_ptr<const AdoptedDevice> adopted;

  explicit Settings(const SimulatorOptions& options)
      : name(options.device.name),
        uuid(options.device.uuid),
        validation(options.validation),
        folder(cacheFolder(options.cache)),
        adopted(options.device.adopted) {}
  bool operator==(const Settings&) const = default;
};

struct SharedDevice : ReadyDevice {
  explicit SharedDevice(const SimulatorOptions& options) : ReadyDevice(options), settings(options) {}
  // A process that was forked has no threads of the driver, so devices of its parent are of no use there.
  bool isParents() const { return maker.isParent(); }
  bool takesMore() const { return !device.failed() && !isParents() && kernels.count() <= kMostKernels; }
  // The caller's device must outlive its simulators only, so it is not kept.
  bool canBeKept() const { return takesMore() && !settings.adopted; }
  bool isIdle() const { return users == 0 && !isParents(); }

  Settings settings;
  MakerProcess maker;
  // Both are guarded by Devices::mutex.
  size_t users = 0;
  std::thread::id thread;  // on which its simulators were made
};

// The devices of this process, the one that was given back or made last first. The end of the process destroys none of
// them, because drivers may have unloaded parts of themselves before.
struct Devices {
  std::mutex mutex;
  std::vector<std::unique_ptr<SharedDevice>> devices;
};
Devices& all() {
  static Devices& one = *new Devices;
  return one;
}

}  // namespace

LentDevice lendDevice(const SimulatorOptions& options) {
  const Settings settings(options);
  const std::lock_guard lock(all().mutex);
  auto& devices = all().devices;
  const auto find = [&](const auto& suits) {
    return std::find_if(devices.begin(), devices.end(),
                        [&](const auto& one) { return one->settings == settings && one->takesMore() && suits(*one); });
  };
  const std::thread::id thread = std::this_thread::get_id();
  auto device =
      find([&](const SharedDevice& one) { return one.users > 0 && (one.thread == thread || settings.adopted); });
  if (device == devices.end()) device = find([](const SharedDevice& one) { return one.isIdle(); });
  if (device == devices.end()) device = devices.insert(devices.begin(), std::make_unique<SharedDevice>(options));
  (*device)->thread = thread;
  ++(*device)->users;
  return LentDevice(device->get());
}

void GiveBack::operator()(ReadyDevice* given) const noexcept {
  std::unique_ptr<SharedDevice> last;  // destroyed without the lock
  const std::lock_guard lock(all().mutex);
  auto& devices = all().devices;
  const auto place = std::find_if(devices.begin(), devices.end(), [&](const auto& one) { return one.get() == given; });
  if ((*place)->isParents() || --(*place)->users > 0) return;
  std::rotate(devices.begin(), place, place + 1);
  const auto isIdle = [](const auto& one) { return one->isIdle(); };
  auto surplus = devices.begin();
  if ((*surplus)->canBeKept()) {
    if (std::count_if(devices.begin(), devices.end(), isIdle) <= kMostIdle) return;
    surplus = std::find_if(devices.rbegin(), devices.rend(), isIdle).base() - 1;
  }
  last = std::move(*surplus);
  devices.erase(surplus);
}

void destroyIdleDevices() noexcept {
  const std::lock_guard lock(all().mutex);
  std::erase_if(all().devices, [](const auto& one) { return one->isIdle(); });
}

}  // namespace gnosphere::vulkan
