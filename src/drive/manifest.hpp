// SPDX-License-Identifier: Apache-2.0
// Complete frames of an output folder: a file per frame, manifest/frames/000000.json, which is written when all files
// of the frame are there. Several processes may work in one folder, on one machine or on many.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drive/formats/format.hpp"

namespace gnosphere::drive {

class UnfinishedFiles;

/// Frames of a drive that are not complete.
struct MissingFrames {
  uint64_t count = 0;
  uint64_t first = 0;  ///< the number of the first one; 0 if none is missing
};

class Manifest {
 public:
  /// Opens the folder, which need not be there. Throws Error(invalidArgument) if it holds another drive, and
  /// Error(file).
  Manifest(const Drive& drive, const std::filesystem::path& out);
  /// Removes the folder of unfinished files.
  ~Manifest();
  Manifest(const Manifest&) = delete;
  Manifest& operator=(const Manifest&) = delete;

  /// Returns the summary of a frame if all its files are there in their size, and if `verify`, with their hash; none
  /// otherwise. Files that go into a final file always need their hash, until that is made.
  std::optional<FrameSummary> summaryOf(uint64_t frame, bool verify) const;
  /// Whether processes that work in this folder know of each other. If not, its file system has no locks.
  bool hasLocks() const;
  /// Makes the folder, unless it is there, and says that frames will be made, so the drive has to be finished again.
  /// Keeps the drive file, and notes what makes the frames, unless another run has noted the same. Throws as the
  /// constructor does.
  void begin(const std::string& madeBy) const;
  /// Writes the files of a frame, then its manifest.
  void write(const FrameRecord& frame, const std::vector<OutputFile>& files) const;

  using Finish = std::function<void(const std::vector<FrameSummary>&, FinalFiles&)>;

  /// Removes final files of a finished drive that do not have the size, or if `verify` the hash, with which they were
  /// written, and returns their paths; the drive has to be finished again then. Throws Error(file) if one cannot be
  /// read or removed.
  std::vector<std::string> removeBroken(bool verify) const;
  /// If all frames are complete, runs `finish` unless another process has done so, notes the files that it has written,
  /// and removes their parts and the unfinished files of killed processes. Returns the frames that are missing: none if
  /// the drive is finished.
  MissingFrames finish(const Finish& finish) const;

 private:
  std::filesystem::path frameFile(uint64_t frame) const;
  std::filesystem::path finishedFile() const { return folder_ / "finished"; }
  const UnfinishedFiles& unfinished() const;
  void put(const std::filesystem::path& file, const std::string& bytes) const;
  /// Throws Error(invalidArgument) if the folder holds another drive.
  void checkDrive() const;
  /// Says that the drive has to be finished again.
  void reopen() const;
  /// Counts the frames without a manifest; `first` is one of them.
  MissingFrames withoutManifest(uint64_t first) const;
  /// Files of which final files are made, by their folders.
  using UsedFiles = std::map<std::filesystem::path, std::vector<std::filesystem::path>>;
  /// Notes that the drive is finished, with which files, and of which folders these were made.
  void putFinished(const std::vector<FinalFile>& files, const UsedFiles& used) const;
  /// Returns the used files that the manifests of all frames name.
  UsedFiles usedFiles() const;
  void removeUsed(const UsedFiles& used) const;
  /// Removes parts that a process has written after another one, which made the same frames, had finished the drive.
  void removeLate() const;

  const Drive& drive_;
  std::filesystem::path out_, folder_;
  mutable std::unique_ptr<UnfinishedFiles>
      unfinished_;  // made when something is written, so that a read-only folder can be checked
};

}  // namespace gnosphere::drive
