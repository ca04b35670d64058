// SPDX-License-Identifier: Apache-2.0
#include "drive/unfinished_files.hpp"

#include <algorithm>
#include <chrono>
#include <random>
#include <string>
#include <system_error>
#include <vector>

#include "base/path.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::drive {
namespace {

namespace fs = std::filesystem;

/// The beginning of the names of all folders of unfinished files, and of their locks.
constexpr const char* kParts = "parts-";

/// The beginning of the names of this machine's folders.
std::string partsOfHost() {
  return kParts + os::machineName() + "-";
}

/// Whether a lock was made, and its folder last changed, more than a day ago.
bool isOld(const fs::path& lock) {
  std::error_code absent;
  const auto latest =
      std::max(fs::last_write_time(lock, absent), fs::last_write_time(fs::path(lock).replace_extension(), absent));
  return latest < fs::file_time_type::clock::now() - std::chrono::hours(24);
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

void UnfinishedFiles::removeAbandoned(const fs::path& in, Of of) {
  const std::string mine = partsOfHost();
  std::error_code ignored;
  std::vector<fs::path> locks;
  for (const auto& entry : fs::directory_iterator(in, ignored)) {
    const fs::path& file = entry.path();
    const std::string name = file.filename().string();
    if (file.extension() != ".lock" || !name.starts_with(kParts)) continue;
    // After the name of the machine come two numbers; the name of another machine may begin with that of this one.
    const bool isMine = name.starts_with(mine) && std::ranges::count(name, '-') == std::ranges::count(mine, '-') + 1;
    if (isMine || (of == Of::allMachines && isOld(file))) locks.push_back(file);
  }
  for (fs::path file : locks) {
    const FileLock lock(file, FileLock::If::free);
    if (!lock.holds()) continue;
    fs::remove_all(fs::path(file).replace_extension(), ignored);
    fs::remove(file, ignored);
  }
}

}  // namespace gnosphere::drive
