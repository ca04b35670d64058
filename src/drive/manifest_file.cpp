// SPDX-License-Identifier: Apache-2.0
#include "drive/manifest_file.hpp"

#include <algorithm>
#include <cmath>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/path.hpp"

namespace gnosphere::drive {

namespace fs = std::filesystem;

ManifestFile::ManifestFile(const fs::path& file) : file_(file), content_(parseJson<Json>(readWholeFile(file), false)) {
  if (!content_.is_object()) refuse("is not a manifest");
}

std::vector<FileEntry> ManifestFile::files() const {
  std::vector<FileEntry> entries;
  for (const Json& from : list(content_, "files")) {
    FileEntry& entry = entries.emplace_back();
    entry.path = pathIn(from, "path");
    if (from.contains("into")) entry.into = pathIn(from, "into").generic_string();
    entry.hash = text(from, "hash");
    entry.bytes = count(from, "bytes");
  }
  return entries;
}

std::vector<fs::path> ManifestFile::partFolders() const {
  std::vector<fs::path> folders;
  for (const Json& from : list(content_, "parts")) folders.push_back(pathIn(from, "folder"));
  return folders;
}

std::vector<ScanSummary> ManifestFile::scans(const std::vector<PlannedScan>& planned, size_t actors) const {
  const Json& scans = list(content_, "scans");
  if (scans.size() != planned.size())
    refuse("has " + std::to_string(scans.size()) + " scans instead of " + std::to_string(planned.size()));
  std::vector<ScanSummary> result;
  for (size_t i = 0; i < planned.size(); ++i) {
    ScanSummary& entry = result.emplace_back(ScanSummary{planned[i], count(scans[i], "points"), {}});
    if (!scans[i].contains("boxes")) continue;
    for (const Json& seen : list(scans[i], "boxes")) {
      Box& box = entry.boxes.emplace_back();
      box.actor = count(seen, "actor");
      if (box.actor >= actors)
        refuse("has a box of actor " + std::to_string(box.actor) + ", but the drive has " + std::to_string(actors));
      box.points = count(seen, "points");
      box.visibility = seen.contains("visibility") ? number(seen, "visibility") : NAN;
      const auto [x, y, z] = numbers<3>(seen, "position");
      const auto [qx, qy, qz, qw] = numbers<4>(seen, "orientation");
      const auto [length, width, height] = numbers<3>(seen, "size");
      box.inWorld = {{x, y, z}, {qx, qy, qz, qw}};
      box.size = {length, width, height};
      box.moving = member(seen, "moving", &Json::is_boolean).get<bool>();
    }
  }
  return result;
}

void ManifestFile::refuse(const std::string& why) const {
  throw Error(ErrorCode::format, file_.string() + ": " + why);
}

const ManifestFile::Json& ManifestFile::member(const Json& object, const char* key,
                                               bool (Json::*is)() const noexcept) const {
  const auto found = object.is_object() ? object.find(key) : object.end();
  if (found == object.end() || !((*found).*is)()) refuse(std::string("lacks '") + key + "', or it is of another type");
  return *found;
}

std::string ManifestFile::text(const Json& object, const char* key) const {
  return member(object, key, &Json::is_string).get<std::string>();
}

uint64_t ManifestFile::count(const Json& object, const char* key) const {
  return member(object, key, &Json::is_number_unsigned).get<uint64_t>();
}

double ManifestFile::number(const Json& object, const char* key) const {
  return member(object, key, &Json::is_number).get<double>();
}

template <size_t N>
std::array<double, N> ManifestFile::numbers(const Json& object, const char* key) const {
  const Json& from = list(object, key);
  if (from.size() != N || !std::all_of(from.begin(), from.end(), [](const Json& n) { return n.is_number(); }))
    refuse(std::string("lacks '") + key + "', or it is not a list of " + std::to_string(N) + " numbers");
  return from.get<std::array<double, N>>();
}

// Returns a path that cannot lead out of the folder of the drive.
fs::path ManifestFile::pathIn(const Json& object, const char* key) const {
  const fs::path path = pathOf(text(object, key));
  if (path.empty() || path.has_root_path() || std::find(path.begin(), path.end(), "..") != path.end())
    refuse("has the path '" + path.string() + "', which leads out of the folder");
  return path;
}

}  // namespace gnosphere::drive
