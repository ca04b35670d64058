// SPDX-License-Identifier: Apache-2.0
// Result buffers in CUDA, by a driver of CUDA that is ours: ctest puts it before any other libcuda.so.1.
#include <dlfcn.h>

#include <catch2/matchers/catch_matchers_string.hpp>
#include <filesystem>
#include <iterator>

#include "support.hpp"
#include "vulkan/fake_cuda.hpp"

namespace gnosphere::test {
namespace {

using Catch::Matchers::ContainsSubstring;

FakeCuda& fake() {
  void* const library = dlopen("libcuda.so.1", RTLD_NOW);
  const auto found = library ? reinterpret_cast<FakeCuda* (*)()>(dlsym(library, "fakeCuda")) : nullptr;
  if (!found) SKIP("the libcuda.so.1 of the tests is not in LD_LIBRARY_PATH");
  return *found();
}

ptrdiff_t openFiles() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

void checkNothingLives(const FakeCuda& cuda) {
  CHECK(cuda.retained == 0);
  CHECK(cuda.pushed == 0);
  CHECK(cuda.imported == 0);
  CHECK(cuda.mapped == 0);
}

}  // namespace

TEST_CASE("CUDA imports each result buffer once, and a call of its driver that fails leaves nothing behind") {
  needVulkan();
  FakeCuda& cuda = fake();
  SimulatorOptions options = vulkanOptions();
  options.resultsOnDevice = true;
  Simulator simulator(sceneOf(soup(3, 100, 12, 3)), {gridSensor(16, 4, -10, 10), Effects::none()}, options);
  BatchStream stream(simulator, {2});
  CHECK_THROWS_WITH(stream.cudaAddress(0), ContainsSubstring("it is not a device of CUDA"));
  cuda.uuid = simulator.device().uuid;
  const ptrdiff_t files = openFiles();
  int failed = 0;
  for (cuda.failAt = 1;; ++cuda.failAt) {
    cuda.calls = 0;
    try {
      stream.cudaAddress(0);
      break;
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::device);
      CHECK_THAT(error.what(), ContainsSubstring("gave CUDA_ERROR_UNKNOWN (999)"));
    }
    ++failed;
    INFO("call " << cuda.failAt << " failed");
    checkNothingLives(cuda);
    CHECK(openFiles() == files);
  }
  cuda.failAt = 0;
  CHECK(failed == 8);
  const uint64_t first = stream.cudaAddress(0).address, second = stream.cudaAddress(1).address;
  CHECK(first >= kFakeAddress);
  CHECK(second > first);
  CHECK(stream.cudaAddress(0).address == first);
  CHECK(stream.cudaAddress(0).device == 1);
  CHECK(cuda.mapped == 2);
  CHECK(cuda.imported == 2);
  CHECK(cuda.pushed == 0);
  CHECK(cuda.bytes >= stream.places().bytes);
  CHECK(openFiles() == files);
  CHECK_THROWS_WITH(stream.cudaAddress(2), ContainsSubstring("no result buffer 2"));
  {
    const BatchStream taken = std::move(stream);
    CHECK(cuda.retained == 2);
  }
  checkNothingLives(cuda);
}

}  // namespace gnosphere::test
