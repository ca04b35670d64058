// SPDX-License-Identifier: Apache-2.0
// Accuracies and devices: their names, and what they stand for.
#include <algorithm>
#include <charconv>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>

#include "gnosphere/error.hpp"
#include "gnosphere/options.hpp"
#include "pipeline/backend.hpp"

namespace gnosphere {

namespace {

using Parts = AccuracyParts;
constexpr AccuracySetting kAccuracies[] = {
    {Accuracy::paper,
     "paper",
     {Parts::Bounds::paper, Parts::Cull::firstCorner, Parts::Inside::plain, Parts::Range::plane},
     "Section 3 of the paper to the letter: vertex boxes, first-vertex range cull, plain edge normals."},
    {Accuracy::draft,
     "draft",
     {Parts::Bounds::exact, Parts::Cull::nearestPoint, Parts::Inside::plain, Parts::Range::plane},
     "Exact bounds, but the paper's inside test and range in single precision: beams may slip through at corners."},
    {Accuracy::standard,
     "standard",
     {Parts::Bounds::exact, Parts::Cull::nearestPoint, Parts::Inside::watertight, Parts::Range::edgeWeights},
     "Exact bounds, watertight edges, ranges within the depth interval of the triangle's corners."},
    {Accuracy::exact,
     "exact",
     {Parts::Bounds::exact, Parts::Cull::nearestPoint, Parts::Inside::exact, Parts::Range::exact},
     "Exact predicates, one owner per layer, correctly rounded ranges: the same bytes on every device."},
};

const AccuracySetting& settingOf(Accuracy accuracy) {
  return kAccuracies[std::min(static_cast<size_t>(accuracy), std::size(kAccuracies) - 1)];
}

}  // namespace

std::span<const AccuracySetting> accuracySettings() {
  return kAccuracies;
}

const char* nameOf(Accuracy accuracy) {
  return settingOf(accuracy).name;
}

AccuracyParts accuracyPartsOf(Accuracy accuracy) {
  return settingOf(accuracy).parts;
}

std::vector<DeviceInfo> listDevices(std::string* vulkanProblem) {
  std::vector<DeviceInfo> devices = listVulkanDevices(vulkanProblem);
  std::string cudaProblem;
  for (DeviceInfo& device : cuda::devices(cudaProblem)) devices.push_back(std::move(device));
  devices.push_back(referenceDevice());
  return devices;
}

DeviceChoice::DeviceChoice(const DeviceInfo& device)
    : kind(device.type == "reference" ? Kind::reference
           : device.type == "cuda"    ? Kind::cuda
                                      : Kind::vulkan),
      name(device.name),
      uuid(device.uuid) {
  // The choice of a CUDA device has its number, of which the name of the device is made: "cuda:0 NVIDIA H100".
  if (kind == Kind::cuda && name.starts_with("cuda:")) name = name.substr(5, name.find(' ') - 5);
}

DeviceChoice deviceByName(const std::string& text) {
  using Kind = DeviceChoice::Kind;
  if (text == "auto") return {};
  if (text == "reference") return Kind::reference;
  for (const auto& [prefix, kind] : {std::pair("cuda:", Kind::cuda), std::pair("cuda-fast:", Kind::cudaFast)})
    if (text.starts_with(prefix)) return {kind, text.substr(std::string_view(prefix).size())};
  if (text.empty() || text.starts_with("cuda"))
    throw Error(ErrorCode::invalidArgument, "device '" + text +
                                                "' is not auto, gpu, the number or a part of the name of a Vulkan "
                                                "device, reference, cuda:N or cuda-fast:N");
  // A number is that of listDevices(), where devices of CUDA and the reference follow those of Vulkan.
  size_t index = 0;
  const char* const end = text.data() + text.size();
  if (const auto [next, problem] = std::from_chars(text.data(), end, index); next == end && problem == std::errc()) {
    const std::vector<DeviceInfo> devices = listDevices();
    if (index < devices.size() && DeviceChoice(devices[index]).kind != Kind::vulkan) return devices[index];
  }
  return {Kind::vulkan, text};
}

std::string nameOf(const DeviceChoice& choice) {
  if (choice.adopted) return "adopted";
  switch (choice.kind) {
    case DeviceChoice::Kind::cuda: return "cuda:" + choice.name;
    case DeviceChoice::Kind::cudaFast: return "cuda-fast:" + choice.name;
    case DeviceChoice::Kind::reference: return "reference";
    case DeviceChoice::Kind::vulkan: break;
  }
  return choice.name.empty() ? "auto" : choice.name;
}

}  // namespace gnosphere
