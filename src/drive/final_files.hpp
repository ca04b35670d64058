// SPDX-License-Identifier: Apache-2.0
// The files of an output folder that need every frame: tables, bags, traces.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/path.hpp"
#include "drive/place_in.hpp"
#include "drive/unfinished_files.hpp"

namespace gnosphere::drive {

/// A final file as the manifest of its drive notes it.
struct FinalFile {
  std::string path;  ///< in the output folder
  uint64_t bytes = 0;
  std::string hash;
};

/// Writes final files and notes them for the manifest.
class FinalFiles {
 public:
  explicit FinalFiles(std::filesystem::path out) : out_(std::move(out)) {}

  /// Returns the path of a file in the output folder. Throws Error(file) if a link leads out of it.
  std::filesystem::path operator/(const std::string& path) const { return fileIn(out_, pathOf(path)); }
  /// Writes a whole file and its folders. The file appears when it is complete. Throws Error(file) with the
  /// system's reason.
  void write(const std::string& path, const std::string& bytes);
  /// Calls make(), which writes a file, unless the file is there, and notes it.
  template <class Make>
  void addMade(const std::string& path, const Make& make) {
    std::error_code absent;
    if (!std::filesystem::exists(*this / path, absent)) {
      makeFolder((*this / path).parent_path());  // without any part there is no folder
      make();
    }
    add(path);
  }
  /// Notes a file that is there. Throws Error(file) if it cannot be read.
  void add(const std::string& path);
  const std::vector<FinalFile>& noted() const { return noted_; }

 private:
  std::filesystem::path out_;
  std::vector<FinalFile> noted_;
};

/// Returns the hash of a file of any size, as hashOf() has it for its bytes. Throws Error(file) if it cannot be
/// read.
std::string hashOfFile(const std::filesystem::path& file);

}  // namespace gnosphere::drive
