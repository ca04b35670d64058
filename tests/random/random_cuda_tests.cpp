// SPDX-License-Identifier: Apache-2.0
// Requests drawn at random: CUDA's kernels, run on the host, against Vulkan's. No change of a scene adds an instance,
// because Simulator then makes new plans, which this test would have to make as well.
// Graphics cards may round the quotients of `standard` in other ways, so there requests of `exact` alone are compared.
#include "effects/scan_support.hpp"
#include "random/request.hpp"

namespace gnosphere::test {
namespace {

void change(Backend& backend, const Scene& scene, const Step& step) {
  for (const auto& [i, transform] : step.transforms)
    backend.setInstance(i, scene.instances[i].mesh, transform, scene.instances[i].world);
  for (const auto& [mesh, deformation] : step.deformations) backend.setDeformation(mesh, deformation);
}

void requireSame(uint32_t number) {
  Request request = anyRequest(number);
  INFO("request " << number << ":" << request.text);
  Simulator vulkan(request.scene, request.sensors, request.options);
  if (request.options.accuracy != Accuracy::exact && !dividesExactly(vulkan.device())) return;
  CudaOnHost cuda(request.options, request.scene, request.sensors);
  for (size_t i = 0; i < request.steps.size(); ++i) {
    INFO("shot " << i);
    Step& step = request.steps[i];
    step.added.clear();
    change(vulkan, step);
    change(cuda.backend(), request.scene, step);
    Scan expected, found;
    vulkan.scanInto(step.shot, expected);
    cuda.scanInto(step.shot, found);
    CHECK(firstBytes(expected, found) == "none");
  }
}

}  // namespace

TEST_CASE("CUDA's kernels give the bytes of Vulkan's for requests drawn at random", "[combinations]") {
  needVulkan();
  for (const uint32_t number : numbersToTry(20)) requireSame(number);
}

}  // namespace gnosphere::test
