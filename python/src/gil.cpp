// SPDX-License-Identifier: Apache-2.0
#include "gil.hpp"

#include <atomic>
#include <chrono>
#include <thread>

namespace gnosphere::python {
namespace {

std::atomic<bool> ending = false;  // the interpreter
std::atomic<int> returning = 0;    // threads that are about to take the GIL back
std::thread::id endingThread;

/// Calls take(), which takes the GIL, or sleeps if the interpreter ends.
template <typename Take>
auto takeBack(const Take& take) {
  ++returning;
  if (ending && std::this_thread::get_id() != endingThread) {
    --returning;
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  struct Returned {
    ~Returned() { --returning; }
  } const returned;
  return take();
}

}  // namespace

ReleasedGil::~ReleasedGil() {
  takeBack([this] { PyEval_RestoreThread(state_); });
}

AcquiredGil::AcquiredGil() : state_(takeBack([] { return PyGILState_Ensure(); })) {}

void watchEnd() {
  nanobind::module_::import_("atexit").attr("register")(nanobind::cpp_function([] {
    endingThread = std::this_thread::get_id();
    ending = true;
    PyThreadState* const state = PyEval_SaveThread();
    while (returning > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    PyEval_RestoreThread(state);
  }));
}

void SeesSignals::operator()(size_t /*done*/) {
  const Clock::time_point now = Clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  const AcquiredGil acquired;
  if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
}

}  // namespace gnosphere::python
