// SPDX-License-Identifier: Apache-2.0
// The folder in which a process writes files until they are whole.
#pragma once

#include <filesystem>
#include <memory>

#include "drive/file_lock.hpp"

namespace gnosphere::drive {

/// Makes a folder and its parents. Throws Error(file) with the reason.
void makeFolder(const std::filesystem::path& folder);

/// A folder for unfinished files with a lock beside it, which are removed together.
class UnfinishedFiles {
 public:
  /// Makes the folder in another one, or throws Error(file).
  explicit UnfinishedFiles(const std::filesystem::path& in);
  ~UnfinishedFiles();
  UnfinishedFiles(const UnfinishedFiles&) = delete;
  UnfinishedFiles& operator=(const UnfinishedFiles&) = delete;
  const std::filesystem::path& folder() const { return folder_; }
  /// Whether other processes see that the folder is in use. If not, its file system has no locks.
  bool isLocked() const { return lock_->holds(); }

  enum class Of { thisMachine, allMachines };
  /// Removes the unfinished files of killed processes from a folder: their locks are free. Files of other machines
  /// must be older than a day as well, because a file system may keep locks from other machines.
  static void removeAbandoned(const std::filesystem::path& in, Of of);

 private:
  std::filesystem::path lockFile() const { return std::filesystem::path(folder_).concat(".lock"); }

  std::filesystem::path folder_;
  std::unique_ptr<FileLock> lock_;
};

}  // namespace gnosphere::drive
