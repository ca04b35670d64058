// SPDX-License-Identifier: Apache-2.0
#include "drive/unfinished_files.hpp"

#include <random>
#include <string>
#include <vector>

#include "base/path.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::drive {
namespace {

namespace fs = std::filesystem;

/// Folders of unfinished files, and their locks, begin with the name of the machine.
std::string partsOfHost() {
  return "parts-" + os::machineName() + "-";
}

}  // namespace

void makeFolder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw Error(ErrorCode::file, folder.string() + ": cannot be made: " + failed.message());
}

UnfinishedFiles::UnfinishedFiles(const fs::path& in) {
  // Processes in containers may have the same number and the same name of the machine, so the name is random.
  std::random_device random;
  for (int tries = 0; tries < 100 && (!lock_ || lock_->lost()); ++tries) {
    folder_ = in / pathOf(partsOfHost() + std::to_string(random()) + "-" + std::to_string(random()));
    lock_ = std::make_unique<FileLock>(lockFile(), FileLock::If::made);
  }
  makeFolder(folder_);
}

UnfinishedFiles::~UnfinishedFiles() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
  fs::remove(lockFile(), ignored);
}

void UnfinishedFiles::removeAbandoned(const fs::path& in) {
  const std::string mine = partsOfHost();
  std::error_code ignored;
  std::vector<fs::path> locks;
  for (const auto& entry : fs::directory_iterator(in, ignored)) {
    const fs::path& file = entry.path();
    if (file.filename().string().starts_with(mine) && file.extension() == ".lock") locks.push_back(file);
  }
  for (fs::path file : locks) {
    const FileLock lock(file, FileLock::If::free);
    if (!lock.holds()) continue;
    fs::remove_all(fs::path(file).replace_extension(), ignored);
    fs::remove(file, ignored);
  }
}

}  // namespace gnosphere::drive
