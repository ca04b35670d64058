// SPDX-License-Identifier: Apache-2.0
// Memory of the host or of the device runs out at every place of batches whose results stay on the device.
#include <optional>

#include "failure/injection.hpp"
#include "problem.hpp"
#include "support.hpp"
#include "vulkan/device_functions.hpp"
#include "vulkan/ready_device.hpp"

namespace gnosphere::test {
namespace {

/// A scene whose only mesh has two shapes in turn, so that every batch has something to upload.
class StreamSubject {
 public:
  explicit StreamSubject(uint64_t mostWork = 0)
      : scene_(sceneOf(soup(5, 60, 12, 6))), simulator(scene_, request(), options(true, mostWork)) {
    shapes_ = {scene_.meshes[0].positions, scene_.meshes[0].positions};
    for (float& value : shapes_[1]) value *= 0.8f;
    Simulator host(scene_, request(), options(false));
    for (size_t shape = 0; shape < 2; ++shape) {
      host.setPositions(0, shapes_[shape]);
      const Batch batch = host.scanBatch(shots);
      expected_[shape] = {batch.ranges().begin(), batch.ranges().end()};
    }
    REQUIRE(expected_[0] != expected_[1]);
  }
  static SensorRequest request() { return {gridSensor(48, 4, -20, 20, 60), Effects::none()}; }
  static SimulatorOptions options(bool onDevice, uint64_t mostWork = 0) {
    SimulatorOptions options;
    options.tuning.maxSubmissionWork = mostWork;
    options.cache = "off";
    options.resultsOnDevice = onDevice;
    return options;
  }

  void makeStream() { stream.emplace(simulator, BatchStreamOptions{4, 2, true}); }
  void take(size_t shape) { simulator.setPositions(0, shapes_[shape]); }
  void check(size_t shape) {
    if (!stream) makeStream();
    const StreamedBatch batch = stream->wait(stream->submit(shots));
    REQUIRE(batch.complete);
    const ResultPlaces places = stream->places();
    size_t wrong = 0;
    for (size_t view = 0; view < shots.size(); ++view)
      wrong += std::memcmp(batch.records.data() + view * places.bytesPerView,
                           expected_[shape].data() + view * places.rowsPerView, places.rowsPerView * 4) != 0;
    CHECK(wrong == 0);
  }

 private:
  Scene scene_;

 public:
  Simulator simulator;
  std::optional<BatchStream> stream;
  std::vector<Shot> shots = std::vector<Shot>(3);

 private:
  std::array<std::vector<float>, 2> shapes_;
  std::array<std::vector<float>, 2> expected_;
};

}  // namespace

TEST_CASE("a stream that cannot be made leaves the simulator free for the next one") {
  needVulkan();
  StreamSubject subject;
  subject.take(0);
  const auto drop = [&] { subject.stream.reset(); };
  const auto check = [&] {
    subject.check(0);
    subject.stream.reset();
  };
  CHECK(failEach("stream: create", Fails::memory, {[&] { subject.makeStream(); }, drop, check}) > 0);
  CHECK(failEach("stream: create", Fails::device, {[&] { subject.makeStream(); }, drop, check}) > 0);
}

TEST_CASE("a batch that fails for lack of memory loses no upload, and the next ones are right") {
  needVulkan();
  StreamSubject subject;
  subject.makeStream();
  size_t shape = 0;
  subject.take(shape);
  const auto check = [&] {
    subject.check(shape);
    shape = 1 - shape;
    subject.take(shape);
  };
  const auto submit = [&] { subject.stream->submit(subject.shots); };
  CHECK(failEach("stream: submit", Fails::memory, {submit, {}, check}) > 0);
  // The first batch of a stream needs room on the device.
  subject.stream.reset();
  CHECK(failEach("stream: first batch", Fails::device,
                 {[&] {
                    subject.makeStream();
                    submit();
                  },
                  {},
                  [&] {
                    check();
                    subject.stream.reset();
                  }}) > 0);
}

TEST_CASE("a batch that cannot be submitted takes the results that its buffer had with it") {
  needVulkan();
  StreamSubject subject;
  subject.take(0);
  subject.stream.emplace(subject.simulator, BatchStreamOptions{4, 1, true});
  const uint64_t first = subject.stream->submit(subject.shots);
  CHECK(subject.stream->wait(first).number == first);
  const vulkan::LentDevice device = vulkan::lendDevice(StreamSubject::options(true));  // that of the simulator
  vulkan::DeviceFunctions& vk = functionsOf(device->device);
  const PFN_vkQueueSubmit submit = vk.vkQueueSubmit;
  vk.vkQueueSubmit = [](VkQueue, uint32_t, const VkSubmitInfo*, VkFence) { return VK_ERROR_OUT_OF_HOST_MEMORY; };
  CHECK_THROWS_AS(subject.stream->submit(subject.shots), Error);
  vk.vkQueueSubmit = submit;
  CHECK(problemOf([&] { subject.stream->wait(first); }).find("are gone") != std::string::npos);
  subject.check(0);
}

TEST_CASE("a batch of more than the most work of a submission is several, with the same results") {
  needVulkan();
  long made[2] = {};
  for (const uint64_t work : {0, 0, 500}) {  // the first one compiles the kernels
    StreamSubject subject(work);
    subject.makeStream();
    subject.take(1);
    {
      const Injection none(Fails::device, 0);
      subject.stream->wait(subject.stream->submit(subject.shots));
      made[work > 0] = none.count();
    }
    subject.check(1);
  }
  CHECK(made[1] > made[0]);  // by the command buffers of the other submissions
}

}  // namespace gnosphere::test
