// SPDX-License-Identifier: Apache-2.0
// Accuracies and devices: their names, and what they stand for.
#include <string_view>
#include <utility>

#include "gnosphere/error.hpp"
#include "gnosphere/simulator.hpp"
#include "pipeline/backend.hpp"

namespace gnosphere {

const char* nameOf(Accuracy accuracy) {
  switch (accuracy) {
    case Accuracy::paper: return "paper";
    case Accuracy::draft: return "draft";
    case Accuracy::standard: return "standard";
    case Accuracy::exact: break;
  }
  return "exact";
}

AccuracyParts accuracyPartsOf(Accuracy accuracy) {
  using E = AccuracyParts;
  switch (accuracy) {
    case Accuracy::paper: return {E::Bounds::paper, E::Cull::firstCorner, E::Inside::plain, E::Range::plane};
    case Accuracy::draft: return {E::Bounds::exact, E::Cull::nearestPoint, E::Inside::plain, E::Range::plane};
    case Accuracy::standard:
      return {E::Bounds::exact, E::Cull::nearestPoint, E::Inside::watertight, E::Range::edgeWeights};
    case Accuracy::exact: break;
  }
  return {E::Bounds::exact, E::Cull::nearestPoint, E::Inside::exact, E::Range::exact};
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
      uuid(device.uuid) {}

DeviceChoice deviceByName(const std::string& text) {
  using Kind = DeviceChoice::Kind;
  if (text == "auto") return {};
  if (text == "reference") return Kind::reference;
  for (const auto& [prefix, kind] : {std::pair("cuda:", Kind::cuda), std::pair("cuda-fast:", Kind::cudaFast)})
    if (text.starts_with(prefix)) return {kind, text.substr(std::string_view(prefix).size())};
  if (text.empty() || text.starts_with("cuda"))
    throw Error(ErrorCode::invalidArgument, "device '" + text +
                                                "' is not auto, the number or a part of the name of a Vulkan device, "
                                                "reference, cuda:N or cuda-fast:N");
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
