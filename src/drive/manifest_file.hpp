// SPDX-License-Identifier: Apache-2.0
// Reads the manifests that Manifest writes.
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "drive/record.hpp"

namespace gnosphere::drive {

/// An entry of a manifest, which describes one file.
struct FileEntry {
  std::filesystem::path path;  // within the folder of the drive
  std::string into, hash;
  uint64_t bytes = 0;
};

/// The manifest of a frame or of a finished drive. Data sets are exchanged, so nothing in it is trusted: every member
/// throws Error(format) that names the file if it is not what Manifest writes.
class ManifestFile {
 public:
  /// Throws Error(file) if the file cannot be read.
  explicit ManifestFile(const std::filesystem::path& file);

  std::vector<FileEntry> files() const;
  /// Returns the folders of the files of which final files were made.
  std::vector<std::filesystem::path> partFolders() const;
  /// Returns the scans of a frame, which must be as many as were planned. `actors` is the number of actors of the
  /// drive.
  std::vector<ScanSummary> scans(const std::vector<PlannedScan>& planned, size_t actors) const;

 private:
  using Json = nlohmann::ordered_json;

  [[noreturn]] void refuse(const std::string& why) const;
  const Json& member(const Json& object, const char* key, bool (Json::*is)() const noexcept) const;
  const Json& list(const Json& object, const char* key) const { return member(object, key, &Json::is_array); }
  std::string text(const Json& object, const char* key) const;
  uint64_t count(const Json& object, const char* key) const;
  double number(const Json& object, const char* key) const;
  template <size_t N>
  std::array<double, N> numbers(const Json& object, const char* key) const;
  std::filesystem::path pathIn(const Json& object, const char* key) const;

  std::filesystem::path file_;
  Json content_;
};

}  // namespace gnosphere::drive
