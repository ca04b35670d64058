// SPDX-License-Identifier: Apache-2.0
// A clock that measures the wall time and the CPU time of frames.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <vector>

namespace gnosphere::test {

/// Wall time and CPU time of this process per frame, in ms. The CPU time says more where the machine is shared; that of
/// a software device is in it.
struct Times {
  std::vector<double> wall, cpu;

  template <class Frame>
  void add(Frame frame) {
    const double w = wallMs(), c = processMs();
    frame();
    wall.push_back(wallMs() - w);
    cpu.push_back(processMs() - c);
  }
  void print(const char* name) const {
    std::printf("%-28s wall median %8.2f, min %8.2f ms; CPU median %8.2f, min %8.2f ms\n", name, median(wall),
                std::ranges::min(wall), median(cpu), std::ranges::min(cpu));
  }

 private:
  static double wallMs() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
  static double processMs() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
  }
  static double median(std::vector<double> values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
  }
};

}  // namespace gnosphere::test
