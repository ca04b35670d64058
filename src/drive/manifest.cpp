// SPDX-License-Identifier: Apache-2.0
#include "drive/manifest.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/file.hpp"
#include "base/hash.hpp"
#include "base/json_text.hpp"
#include "base/path.hpp"
#include "drive/file_lock.hpp"
#include "drive/fingerprint.hpp"
#include "drive/manifest_file.hpp"
#include "drive/place_in.hpp"
#include "drive/unfinished_files.hpp"

namespace gnosphere::drive {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Whether a file has the size, and if `verify` the hash, of its entry.
bool isWhole(const fs::path& file, const FileEntry& entry, bool verify) {
  std::error_code absent;
  const uintmax_t bytes = fs::file_size(file, absent);
  return !absent && bytes == entry.bytes && (!verify || hashOfFile(file) == entry.hash);
}

/// Returns the sentence that refuses a folder because only the duration of its drive was another one; none if anything
/// else was, too, or if the folder does not tell. `held` is manifest/drive.json of the folder.
std::string durationText(const Drive& drive, const fs::path& manifest, const std::string& held) {
  try {
    nlohmann::json before = parseJson(readWholeFile(manifest / "drive_file.json")), now = parseJson(drive.file);
    // The fingerprint counts every file that is read for a drive. With the drive file of the folder it is the folder's
    // own if all these files are the same.
    if (fingerprintOf(drive, jsonText(before)) != parseJson(held).at("fingerprint")) return "";
    const auto take = [](nlohmann::json& file) {
      const std::string text =
          file.contains("duration") ? gnosphere::numberText(file["duration"].get<double>()) + " s" : "";
      file.erase("duration");
      return text.empty() ? "the duration of the vehicle's trajectory" : "a duration of " + text;
    };
    const std::string old = take(before), wanted = take(now);
    if (before != now) return "";
    return "holds frames of this drive with " + old + ", and it now has " + wanted +
           "; a drive that has begun keeps its duration, so choose another folder or the old duration";
  } catch (const std::exception&) {
    return "";  // the file is absent or damaged
  }
}

/// Returns the text of manifest/drive.json for a drive.
std::string textOf(const Drive& drive) {
  return jsonText(Json{{"drive", drive.name}, {"frames", drive.frameCount()}, {"fingerprint", drive.fingerprint}}, 1) +
         "\n";
}

}  // namespace

Manifest::Manifest(const Drive& drive, const fs::path& out) : drive_(drive), out_(out), folder_(out / "manifest") {
  // A link is refused before anything is removed.
  for (const char* own : {"manifest/frames", "manifest/lock"}) fileIn(out, own);
  UnfinishedFiles::removeAbandoned(folder_, UnfinishedFiles::Of::thisMachine);
  checkDrive();
}

Manifest::~Manifest() = default;

void Manifest::checkDrive() const {
  const fs::path file = folder_ / "drive.json";
  std::error_code absent;
  if (!fs::exists(file, absent)) return;
  const std::string held = readWholeFile(file);
  if (held == textOf(drive_)) return;
  const std::string why = durationText(drive_, folder_, held);
  throw Error(ErrorCode::invalidArgument,
              out_.string() + ": " +
                  (why.empty() ? "holds frames of another drive, or of this one before something of it changed; "
                                 "choose another folder"
                               : why));
}

void Manifest::begin(const std::string& madeBy) const {
  if (!out_.empty()) makeFolder(out_);  // an empty path is the current folder
  makeFolder(fileIn(out_, "manifest/frames"));
  const auto putOnce = [&](const std::string& path, const std::string& text) {
    const fs::path file = placeIn(out_, pathOf(path));
    std::error_code absent;
    if (!fs::exists(file, absent)) put(file, text);
  };
  putOnce("manifest/drive.json", textOf(drive_));
  checkDrive();  // another process may have begun another drive meanwhile
  putOnce("manifest/drive_file.json", drive_.file);
  // The name is that of the content, so that processes which make frames alike share a file, however many they are.
  putOnce("manifest/made_by/" + hashOf(madeBy) + ".json", madeBy);
  reopen();
}

fs::path Manifest::frameFile(uint64_t frame) const {
  return folder_ / "frames" / numberText("%06llu.json", frame);
}

const UnfinishedFiles& Manifest::unfinished() const {
  if (!unfinished_) unfinished_ = std::make_unique<UnfinishedFiles>(folder_);
  return *unfinished_;
}

bool Manifest::hasLocks() const {
  return unfinished().isLocked();
}

void Manifest::put(const fs::path& file, const std::string& bytes) const {
  const fs::path folder = file.parent_path(), parts = unfinished().folder();
  const auto write = [&] {
    makeFolder(folder);
    makeFolder(parts);
    AtomicFile out(file, parts / "file");
    out.write(bytes);
    out.commit();
  };
  try {
    write();
  } catch (const Error&) {
    // A process that has finished the drive meanwhile removes the folder of files that are no longer needed.
    std::error_code absent;
    if (fs::exists(folder, absent) && fs::exists(parts, absent)) throw;
    write();
  }
}

std::optional<FrameSummary> Manifest::summaryOf(uint64_t frame, bool verify) const {
  std::error_code absent;
  if (!fs::exists(frameFile(frame), absent)) return {};
  std::vector<FileEntry> entries;
  FrameSummary summary;
  try {
    const ManifestFile manifest(frameFile(frame));
    entries = manifest.files();
    summary.scans = manifest.scans(scansOf(drive_, frame), drive_.actors.size());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::format) throw;
    return {};  // the frame is made again, and its manifest with it
  }
  for (const FileEntry& entry : entries) {
    const fs::path file = placeIn(out_, entry.path);
    if (!entry.into.empty() && fs::exists(out_ / pathOf(entry.into), absent)) continue;
    // Damage to a part would go into a final file, whose hash is noted then.
    if (!isWhole(file, entry, verify || !entry.into.empty())) return {};
  }
  return summary;
}

void Manifest::write(const FrameRecord& frame, const std::vector<OutputFile>& files) const {
  Json entries = Json::array(), scans = Json::array();
  for (const OutputFile& file : files) {
    put(placeIn(out_, pathOf(file.path)), file.bytes);
    entries.push_back({{"path", file.path}, {"bytes", file.bytes.size()}, {"hash", hashOf(file.bytes)}});
    if (!file.into.empty()) entries.back()["into"] = file.into;
  }
  for (const RecordedScan& scan : frame.scans) {
    Json boxes = Json::array();
    for (const Box& box : scan.boxes) {
      const Quaternion& q = box.inWorld.orientation;
      boxes.push_back({{"actor", box.actor},
                       {"points", box.points},
                       {"position", listOf(box.inWorld.position)},
                       {"orientation", {q.x, q.y, q.z, q.w}},
                       {"size", listOf(box.size)},
                       {"moving", box.moving}});
      if (!std::isnan(box.visibility)) boxes.back()["visibility"] = box.visibility;
    }
    scans.push_back({{"sensor", scan.planned.sensor},
                     {"number", scan.planned.number},
                     {"points", scan.points},
                     {"non_finite", scan.scan.counters.nonFinite},
                     {"lost_echoes", scan.scan.counters.lostEchoes}});
    if (!boxes.empty()) scans.back()["boxes"] = std::move(boxes);
  }
  put(frameFile(frame.frame), jsonText(Json{{"frame", frame.frame}, {"files", entries}, {"scans", scans}}) + "\n");
}

void Manifest::reopen() const {
  std::error_code ignored;
  fs::remove(finishedFile(), ignored);
}

std::vector<std::string> Manifest::removeBroken(bool verify) const {
  const FileLock lock(folder_ / "lock", FileLock::If::waited);
  std::error_code absent, failed;
  if (!fs::exists(finishedFile(), absent)) return {};
  std::vector<std::string> broken;
  try {
    for (const FileEntry& entry : ManifestFile(finishedFile()).files())
      if (!isWhole(placeIn(out_, entry.path), entry, verify)) broken.push_back(entry.path.generic_string());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::format) throw;
    reopen();  // the list of files is damaged, or of a version that had none
    return {};
  }
  for (const std::string& path : broken) {
    fs::remove(out_ / pathOf(path), failed);
    if (failed)
      throw Error(ErrorCode::file, (out_ / pathOf(path)).string() +
                                       ": is not as it was written, and cannot be removed: " + failed.message() +
                                       "; remove it, and the drive makes it again");
  }
  if (!broken.empty()) reopen();
  return broken;
}

Manifest::UsedFiles Manifest::usedFiles() const {
  UsedFiles used;
  for (uint64_t frame = 0; frame < drive_.frameCount(); ++frame)
    for (const FileEntry& entry : ManifestFile(frameFile(frame)).files())
      if (!entry.into.empty()) used[entry.path.parent_path()].push_back(entry.path);
  return used;
}

void Manifest::removeUsed(const UsedFiles& used) const {
  std::error_code ignored;
  for (const auto& [folder, files] : used) {
    for (const fs::path& file : files) fs::remove(placeIn(out_, file), ignored);
    fs::remove(out_ / folder, ignored);  // if it is empty
  }
}

void Manifest::removeLate() const {
  std::error_code absent;
  for (const fs::path& folder : ManifestFile(finishedFile()).partFolders())
    if (fs::exists(out_ / folder, absent)) return removeUsed(usedFiles());
}

void Manifest::putFinished(const std::vector<FinalFile>& files, const UsedFiles& used) const {
  Json entries = Json::array(), folders = Json::array();
  for (const FinalFile& file : files)
    entries.push_back({{"path", file.path}, {"bytes", file.bytes}, {"hash", file.hash}});
  for (const auto& [folder, parts] : used)
    if (!folder.empty()) folders.push_back({{"folder", folder.generic_string()}});
  put(finishedFile(), jsonText(Json{{"files", entries}, {"parts", folders}}, 1) + "\n");
}

MissingFrames Manifest::withoutManifest(uint64_t first) const {
  std::error_code failed;
  uint64_t there = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "frames", failed))
    there += entry.path().extension() == ".json";
  // At least the first was missing, even if other processes have completed frames since.
  return {drive_.frameCount() - std::min(there, drive_.frameCount() - 1), first};
}

MissingFrames Manifest::finish(const Finish& finish) const {
  const FileLock lock(folder_ / "lock", FileLock::If::waited);
  std::error_code absent;
  if (fs::exists(finishedFile(), absent)) {
    removeLate();
    UnfinishedFiles::removeAbandoned(folder_, UnfinishedFiles::Of::allMachines);
    return {};
  }
  for (uint64_t frame = 0; frame < drive_.frameCount(); ++frame)
    if (!fs::exists(frameFile(frame), absent)) return withoutManifest(frame);
  MissingFrames broken;
  std::vector<FrameSummary> frames;
  for (uint64_t frame = 0; frame < drive_.frameCount(); ++frame) {
    if (std::optional<FrameSummary> summary = summaryOf(frame, false))
      frames.push_back(std::move(*summary));
    else if (broken.count++ == 0)
      broken.first = frame;
  }
  if (broken.count > 0) return broken;
  FinalFiles files(out_);
  finish(frames, files);
  const UsedFiles used = usedFiles();
  putFinished(files.noted(), used);
  removeUsed(used);
  UnfinishedFiles::removeAbandoned(folder_, UnfinishedFiles::Of::allMachines);
  return {};
}

}  // namespace gnosphere::drive
