// SPDX-License-Identifier: Apache-2.0
#include "view/series.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <system_error>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/path.hpp"
#include "base/text.hpp"
#include "drive/formats/format.hpp"
#include "output/cloud_format.hpp"

namespace gnosphere::cli {
namespace {

namespace fs = std::filesystem;

bool endsWith(const fs::path& file, const char* ending) {
  return lower(file.string()).ends_with(ending);
}

/// Formats that can be shown, the ones with more fields first.
enum class Kind { rows, labelled, nuscenes, kitti };

/// The files of one sensor in one of a drive's outputs.
struct Candidate {
  Kind kind;
  std::string sensor;  ///< empty if the format does not tell it
  std::vector<SeriesFrame> frames;
  std::vector<fs::path> paths;  ///< in the output folder
};

/// Whether this is a cloud of the format `openpcdet`, which tells neither its sensor nor the frame of its boxes.
bool isOpenPcdet(const fs::path& path, const std::set<fs::path>& all) {
  const fs::path boxes = path.parent_path().parent_path() / "labels" / path.filename().replace_extension(".txt");
  return endsWith(path, ".npy") && all.contains(boxes);
}

std::optional<Kind> kindOf(const fs::path& path, const std::set<fs::path>& all) {
  if (isOpenPcdet(path, all)) return std::nullopt;
  if (endsWith(path, ".pcd") || endsWith(path, ".npy")) return Kind::rows;
  if (endsWith(path, ".pcd.bin")) return Kind::nuscenes;
  if (!endsWith(path, ".bin")) return std::nullopt;
  const fs::path label = path.parent_path().parent_path() / "labels" / path.filename().replace_extension(".label");
  return all.contains(label) ? Kind::labelled : Kind::kitti;
}

/// A sensor's folder in an output. nuScenes has two, for samples and sweeps.
std::string keyOf(const fs::path& path) {
  std::string key;
  for (const fs::path& part : path.parent_path())
    if (part != "samples" && part != "sweeps") key += part.string() + "/";
  return key;
}

/// Passes a JSON file that a drive has written to a function. Values of unexpected types are one error for the whole
/// file.
template <typename Read>
void readManifest(const fs::path& file, Read read) {
  try {
    read(readJson(file));
  } catch (const nlohmann::json::exception&) {
    throw Error(ErrorCode::format, file.string() + ": is not a file that gnosphere drive has written");
  }
}

/// The output folder of a drive, as its manifest describes it.
class DriveOutput {
 public:
  explicit DriveOutput(const fs::path& folder) : folder_(folder) {
    std::vector<fs::path> frames;
    std::error_code absent;
    for (const auto& entry : fs::directory_iterator(folder / "manifest" / "frames", absent))
      if (entry.path().extension() == ".json") frames.push_back(entry.path());
    std::sort(frames.begin(), frames.end());
    for (const fs::path& frame : frames) readFrame(frame);
    complete_ = frames.size();
  }

  Series choose(const std::string& sensor) {
    Candidate* best = nullptr;
    for (const std::string& key : order_) {
      Candidate& candidate = candidates_.at(key);
      if (!sensor.empty() && candidate.sensor != sensor) continue;
      if (!best || candidate.kind < best->kind) best = &candidate;
    }
    if (!best) refuse(sensor);
    Series series;
    series.frames = std::move(best->frames);
    uint64_t frames = 0;
    readManifest(folder_ / "manifest" / "drive.json", [&](const nlohmann::json& drive) {
      series.name = drive.value("drive", "");
      frames = drive.value("frames", uint64_t{0});
    });
    size_t unknown = 0;
    std::map<std::pair<uint64_t, std::string>, size_t> used;  // a frame may have several scans of a sensor
    for (size_t i = 0; i < series.frames.size(); ++i) {
      const std::string owner = best->sensor.empty() ? ownerOf(series.frames[i], best->paths[i]) : best->sensor;
      const auto boxes = boxes_.find({series.frames[i].number, owner});
      const size_t scan = used[{series.frames[i].number, owner}]++;
      if (boxes != boxes_.end() && scan < boxes->second.size()) series.frames[i].boxes = boxes->second[scan];
      unknown += owner.empty() && !boxes_.empty();
    }
    if (!best->sensor.empty()) series.name += ", " + best->sensor;
    if (unknown > 0)
      series.notes.push_back("boxes are left out, because the format does not tell the sensor of its clouds");
    if (complete_ < frames)
      series.notes.push_back("the drive is not complete: it has " + std::to_string(complete_) + " of " +
                             std::to_string(frames) + " frames");
    addNames(*best, series);
    return series;
  }

 private:
  void readFrame(const fs::path& file) {
    readManifest(file, [&](const nlohmann::json& frame) {
      std::set<fs::path> all;
      for (const nlohmann::json& entry : frame.at("files")) all.insert(pathOf(entry.at("path").get<std::string>()));
      const uint64_t number = frame.at("frame").get<uint64_t>();
      std::vector<std::string> boxed;  // sensors with boxes, in the order of the scans
      for (const nlohmann::json& entry : frame.at("files")) {
        const fs::path path = pathOf(entry.at("path").get<std::string>());
        addFile(number, path, kindOf(path, all));
        if (isOpenPcdet(path, all)) others_.insert("openpcdet");
        if (endsWith(entry.value("into", ""), ".mcap")) others_.insert("mcap");
        if (endsWith(entry.value("into", ""), ".osi")) others_.insert("osi");
        if (endsWith(path, ".jsonl")) boxed.push_back(path.parent_path().filename().string());
      }
      if (boxed.size() != frame.at("scans").size()) return;
      for (size_t i = 0; i < boxed.size(); ++i)
        scans_[number].push_back({boxed[i], frame["scans"][i].at("points").get<uint64_t>()});
    });
  }

  void addFile(uint64_t number, const fs::path& path, std::optional<Kind> kind) {
    const std::string parent = path.parent_path().filename().string();
    if (endsWith(path, ".jsonl")) boxes_[{number, parent}].push_back(folder_ / path);
    if (endsWith(path, ".las")) others_.insert("las");
    if (!kind) return;
    const auto [entry, isNew] = candidates_.try_emplace(keyOf(path));
    Candidate& candidate = entry->second;
    if (isNew) {
      order_.push_back(entry->first);
      candidate.kind = *kind;
      if (*kind == Kind::rows || *kind == Kind::nuscenes) candidate.sensor = parent;
    }
    candidate.frames.push_back({number, folder_ / path, {}});
    candidate.paths.push_back(path);
  }

  /// The sensor of a KITTI cloud: the only one with boxes whose scan has as many points.
  std::string ownerOf(const SeriesFrame& frame, const fs::path& path) const {
    const auto scans = scans_.find(frame.number);
    if (scans == scans_.end()) return "";
    std::error_code absent;
    const uintmax_t bytes = fs::file_size(folder_ / path, absent);
    std::string owner;
    for (const auto& [sensor, points] : scans->second) {
      if (absent || points * 4 * sizeof(float) != bytes) continue;
      if (!owner.empty() && owner != sensor) return "";
      owner = sensor;
    }
    return owner;
  }

  void addNames(const Candidate& chosen, Series& series) const {
    series.names["class"] = classNames(folder_);
    std::error_code absent;
    if (!fs::exists(folder_ / "objects.json", absent)) return;
    uint32_t actors = 0;
    readManifest(folder_ / "objects.json", [&](const nlohmann::json& objects) {
      for (const nlohmann::json& object : objects) {
        const std::string name = object.value("name", "");
        if (chosen.kind == Kind::rows) series.names["instance"][object.value("object", 0u)] = name;
        // SemanticKITTI's labels number the actors from 1 on.
        if (chosen.kind == Kind::labelled && object.value("actor", false)) series.names["instance"][++actors] = name;
      }
    });
  }

  [[noreturn]] void refuse(const std::string& sensor) const {
    std::string known;
    for (const auto& [key, candidate] : candidates_)
      if (!candidate.sensor.empty() && known.find(candidate.sensor) == known.npos)
        known += (known.empty() ? "" : ", ") + candidate.sensor;
    if (!sensor.empty() && !candidates_.empty())
      throw Error(ErrorCode::invalidArgument,
                  "--sensor: " + folder_.string() + " has no clouds of '" + sensor + "' that can be shown; " +
                      (known.empty() ? "its formats do not tell the sensor, as pcd and npy do; leave out --sensor"
                                     : "there are those of " + known));
    std::string others;
    for (const std::string& format : others_) others += (others.empty() ? "" : " and ") + format;
    throw Error(ErrorCode::invalidArgument,
                folder_.string() + ": holds " + (others.empty() ? "no clouds" : "clouds as " + others + " only") +
                    "; gnosphere view shows " + drive::formatNames([](const drive::FormatInfo& f) { return f.shown; }));
  }

  fs::path folder_;
  uint64_t complete_ = 0;  // frames
  std::map<std::string, Candidate> candidates_;
  std::vector<std::string> order_;
  std::map<std::pair<uint64_t, std::string>, std::vector<fs::path>> boxes_;  // by frame and sensor
  std::map<uint64_t, std::vector<std::pair<std::string, uint64_t>>> scans_;  // sensor and points, by frame
  std::set<std::string> others_;                                             // formats that cannot be shown
};

Series filesOf(const fs::path& folder) {
  Series series;
  series.name = folder.filename().empty() ? folder.parent_path().filename().string() : folder.filename().string();
  std::error_code failed;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, failed))
    for (const CloudFormat& format : cloudFormats())
      if (endsWith(entry.path(), format.ending)) files.push_back(entry.path());
  if (failed) throw Error(ErrorCode::file, folder.string() + ": cannot be read: " + failed.message());
  if (files.empty())
    throw Error(ErrorCode::invalidArgument, folder.string() +
                                                ": is neither the output of gnosphere drive nor a folder with " +
                                                cloudEndings("or") + " files");
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) series.frames.push_back({series.frames.size(), file, {}});
  return series;
}

}  // namespace

Series findSeries(const fs::path& folder, const std::string& sensor) {
  std::error_code absent;
  if (fs::exists(folder / "manifest" / "drive.json", absent)) return DriveOutput(folder).choose(sensor);
  if (!sensor.empty())
    throw Error(ErrorCode::invalidArgument,
                "--sensor: " + folder.string() + " is not the output of gnosphere drive, which has sensors");
  return filesOf(folder);
}

}  // namespace gnosphere::cli
