// SPDX-License-Identifier: Apache-2.0
// Memory runs out in the thread that writes the frames of a drive.
#include <catch2/catch_test_macros.hpp>

#include "drive/frame_queue.hpp"
#include "failure/injection.hpp"

namespace gnosphere::test {

TEST_CASE("without memory the thread that writes frames reports it, and does not end the process") {
  bool lost = false;
  const auto call = [&] {
    uint64_t written = 0;
    drive::FrameQueue queue([&](drive::FrameRecord&) { ++written; });
    constexpr uint64_t kFrames = 100;  // its lists ask for memory now and then
    queue.run(std::vector<uint64_t>(kFrames), [](drive::FrameRecord&) {});
    lost |= written != kFrames;
  };
  CHECK(failEach("FrameQueue", Fails::memory, {call, {}, {}}) > 0);
  CHECK_FALSE(lost);
}

}  // namespace gnosphere::test
