// SPDX-License-Identifier: Apache-2.0
// Complete frames of an output folder: a file per frame, manifest/frames/000000.json, which is written when all files
// of the frame are there. Several processes may work in one folder, on one machine or on many.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "drive/formats/format.hpp"

namespace gnosphere::drive {

class Manifest {
 public:
  /// Opens or makes the folder. Throws Error(invalidArgument) if it holds another drive, and Error(file).
  Manifest(const Drive& drive, const std::filesystem::path& out);
  /// Removes the folder of unfinished files.
  ~Manifest();
  Manifest(const Manifest&) = delete;
  Manifest& operator=(const Manifest&) = delete;

  /// Whether all files of the frame are there in their size, and if `verify`, with their hash.
  bool isComplete(uint64_t frame, bool verify) const;
  /// Writes the files of a frame, then its manifest.
  void write(const FrameRecord& frame, const std::vector<OutputFile>& files) const;

  /// If all frames are complete, runs finish(summaries) unless another process has done so, and removes the files that
  /// others were made of. Returns whether the drive is finished.
  bool finish(const std::function<void(const std::vector<FrameSummary>&)>& finish) const;
  /// Says that frames will be made, so the drive has to be finished again.
  void reopen() const;

 private:
  class Parts;

  std::filesystem::path frameFile(uint64_t frame) const;
  void put(const std::filesystem::path& file, const std::string& bytes) const;
  FrameSummary summaryOf(uint64_t frame) const;
  void removeUsed() const;

  const Drive& drive_;
  std::filesystem::path out_, folder_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gnosphere::drive
