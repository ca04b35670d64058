// SPDX-License-Identifier: Apache-2.0
// Binds drive/drive.hpp and drive/run.hpp, as the module gnosphere.drive.
#include <nanobind/stl/function.h>

#include <optional>

#include "bind.hpp"
#include "drive/run.hpp"
#include "options.hpp"

namespace gnosphere::python {

using drive::Drive;
using drive::RunOptions;
using drive::RunReport;
using Progress = std::function<void(uint64_t, uint64_t)>;

namespace {

/// The function that Python gives for `progress`, whose result does not matter.
using ProgressFunction = nb::typed<nb::callable, nb::object(uint64_t, uint64_t)>;

/// The Python function of options; none if they have none.
std::optional<ProgressFunction> progressOf(const RunOptions& options) {
  using Python = nb::detail::type_caster<Progress>::pyfunc_wrapper_t;
  const auto* progress = options.progress.target<Python>();
  if (!progress) return {};
  return nb::borrow<ProgressFunction>(progress->f);
}

void setProgress(RunOptions& options, const std::optional<ProgressFunction>& function) {
  options.progress = function ? nb::cast<Progress>(*function) : nullptr;
}

std::vector<nb::handle> visitedOf(const RunOptions& options) {
  std::vector<nb::handle> functions = handlesOf(functionsOf(options.simulator));
  using Python = nb::detail::type_caster<Progress>::pyfunc_wrapper_t;
  if (const auto* progress = options.progress.target<Python>()) functions.emplace_back(progress->f);
  return functions;
}

void dropFunctionsOfRun(RunOptions& options) {
  options.progress = nullptr;
  dropFunctions(options.simulator);
}

using CollectedRun = Collected<RunOptions, &visitedOf, &dropFunctionsOfRun>;

}  // namespace

void bindDrive(nb::module_& parent) {
  nb::module_ m = parent.def_submodule("drive", "Makes data sets of drive files, as `gnosphere drive` does.");

  nb::class_<Drive> drive(m, "Drive", "What a drive file says, with every file that it names read.");
  drive
      .def_ro("name", &Drive::name,
              "The name of the drive in data sets: what the file or the caller calls it, or else that of the file.")
      .def_ro("seed", &Drive::seed, "Seed of the random numbers of all sensors whose effects state none.")
      .def_ro("rate", &Drive::rate, "Frames per second.")
      .def_ro("start", &Drive::start, "Time of frame 0, in seconds of the trajectories' clock.")
      .def_ro("duration", &Drive::duration, "Length of the drive in seconds.")
      .def_ro("fingerprint", &Drive::fingerprint, "Hash of the drive file and of everything that was read for it.")
      .def("frame_count", &Drive::frameCount, "Number of frames.");
  readTuple(drive, "warnings", &Drive::warnings, "What a user may want to know and is no mistake.");
  m.def(
      "read_drive",
      [](const std::filesystem::path& file, std::optional<uint64_t> seed, const std::optional<std::string>& name) {
        const ReleasedGil released;
        return drive::readDrive(file, seed, name);
      },
      "file"_a, "seed"_a = nb::none(), "name"_a = nb::none(),
      "Reads a drive file and the files that it names. A `seed` and a `name` replace those of the file, as if the file "
      "stated them. Raises Error(format) that lists the mistakes with their JSON paths, or Error(file).");

  nb::class_<RunOptions>(m, "RunOptions", "Which frames of a drive are made, where and how.",
                         nb::type_slots(CollectedRun::slots))
      .def(
          "__init__",
          [](RunOptions* self, std::filesystem::path out, uint64_t first, uint64_t end, uint64_t shard, uint64_t count,
             bool verify, const SimulatorOptions& simulator, const std::optional<ProgressFunction>& progress) {
            new (self) RunOptions{std::move(out), first, end, shard, count, verify, simulator, nullptr};
            setProgress(*self, progress);
            ownFunctions(self->simulator);
          },
          "out"_a, "first_frame"_a = 0, "end_frame"_a = UINT64_MAX, "shard"_a = 0, "shard_count"_a = 1,
          "verify"_a = false, "simulator"_a = newOptions(), "progress"_a = nb::none())
      .def_rw("out", &RunOptions::out, "The folder of the data set; if empty, the current one.")
      .def_rw("first_frame", &RunOptions::firstFrame, "The first frame that is made.")
      .def_rw("end_frame", &RunOptions::endFrame, "The frame after the last one.")
      .def_rw("shard", &RunOptions::shard, "Only frames whose number modulo shard_count is this are made.")
      .def_rw("shard_count", &RunOptions::shardCount, "Into how many shares the frames are divided.")
      .def_rw("verify", &RunOptions::verify, "Whether complete frames are read and their hashes compared.")
      .def_prop_rw(
          "simulator", [](RunOptions& self) -> SimulatorOptions& { return self.simulator; },
          [](RunOptions& self, const SimulatorOptions& options) {
            self.simulator = options;
            ownFunctions(self.simulator);
          },
          nb::rv_policy::reference_internal, "The drive's accuracy and other options replace its own.")
      .def_prop_rw(
          "progress", &progressOf, &setProgress,
          "Called when a frame is complete, with the number of frames made and that of frames to make, on a thread of "
          "the run. What it returns does not matter; an exception of it ends the run.");

  nb::class_<RunReport> report(m, "RunReport", "What was made, and what was there.");
  report.def_ro("chosen", &RunReport::chosen, "Frames of the range and shard.")
      .def_ro("kept", &RunReport::kept, "Chosen frames that were complete before the run.")
      .def_ro("scans", &RunReport::scans, "Scans made in this run.")
      .def_ro("points", &RunReport::points, "Points of the scans of this run.")
      .def_ro("counters", &RunReport::counters, "Counters, summed over the scans of this run.")
      .def_ro("files", &RunReport::files, "Files written in this run.")
      .def_ro("bytes", &RunReport::bytes, "Bytes of the files of this run.")
      .def_ro("finished", &RunReport::finished,
              "Whether all frames of the drive are complete, and the files that need all are written.")
      .def_ro("missing", &RunReport::missing, "Frames of the drive that are not complete, of other shards, too.")
      .def_ro("first_missing", &RunReport::firstMissing, "Number of the first missing frame; 0 if none is missing.")
      .def_ro("device", &RunReport::device, "Name of the device; empty if nothing had to be made.");
  readTuple(report, "broken", &RunReport::broken,
            "Files that need every frame and were not as they had been written; they are removed, and made again with "
            "the last frame.");
  m.def(
      "run",
      [](const Drive& of, const RunOptions& options) {
        RunOptions chosen = options;
        chosen.beforeFrame = SeesSignals();
        const ReleasedGil released;
        return drive::run(of, chosen);
      },
      "drive"_a, "options"_a,
      "Makes the frames that are not complete, without holding the GIL. A frame has the same bytes wherever and "
      "whenever it is made. Ctrl-C ends the run after the frame that is being scanned. If this raises, complete frames "
      "stay, and a later call goes on from there. Raises Error(invalid_argument) for a shard or a range of frames that "
      "there is not.");
}

}  // namespace gnosphere::python
