// SPDX-License-Identifier: Apache-2.0
#include "drive/manifest.hpp"

#include <algorithm>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <random>

#include "base/file.hpp"
#include "base/hash.hpp"
#include "base/json_text.hpp"
#include "base/os.hpp"
#include "base/path.hpp"

namespace gnosphere::drive {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Throws Error(file) with the reason.
void makeFolder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw Error(ErrorCode::file, folder.string() + ": cannot be made: " + failed.message());
}

/// The folders of unfinished files, and their locks, begin with the name of the machine.
std::string partsOfHost() {
  return "parts-" + os::machineName() + "-";
}

/// Holds a lock on a file. The system releases it when the process ends, however it ends.
class FileLock {
 public:
  enum class If { free, waited, made };

  /// Takes the lock if it is free, or waits for it, or makes the file, which must not be there.
  FileLock(const fs::path& file, If taken) : descriptor_(os::openForLock(file, taken == If::made)) {
    if (descriptor_ < 0)
      lost_ = errno == EEXIST;
    else if (const os::Lock lock = os::lockFile(descriptor_, taken == If::waited); lock != os::Lock::taken)
      lost_ = lock == os::Lock::busy;
    else
      lost_ = !(holds_ = os::isNamed(descriptor_, file));
  }
  ~FileLock() {
    if (descriptor_ >= 0) os::closeFile(descriptor_);
  }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  bool holds() const { return holds_; }
  /// Whether another process has the lock, rather than that there is none, for example in a read-only folder.
  bool lost() const { return lost_; }

 private:
  os::Descriptor descriptor_;
  bool holds_ = false, lost_ = false;
};

/// Removes what processes of this machine have left half written when they were killed: their locks are free.
void removeAbandoned(const fs::path& folder) {
  const std::string mine = partsOfHost();
  std::error_code ignored;
  std::vector<fs::path> locks;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
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

}  // namespace

namespace {

/// An entry of a manifest, which describes one file.
struct FileEntry {
  fs::path path;  // within the folder of the drive
  std::string into, hash;
  uint64_t bytes = 0;
};

/// The manifest of a frame or of a finished drive. Data sets are exchanged, so nothing in it is trusted: every member
/// throws Error(format) that names the file if it is not what Manifest writes.
class ManifestFile {
 public:
  explicit ManifestFile(const fs::path& file) : file_(file), content_(parseJson<Json>(readWholeFile(file), false)) {
    if (!content_.is_object()) refuse("is not a manifest");
  }

  std::vector<FileEntry> files() const {
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

  /// Returns the folders of the files of which final files were made.
  std::vector<fs::path> partFolders() const {
    std::vector<fs::path> folders;
    for (const Json& from : list(content_, "parts")) folders.push_back(pathIn(from, "folder"));
    return folders;
  }

  std::vector<ScanSummary> scans(const std::vector<PlannedScan>& planned, size_t actors) const {
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
        box.visibility = number(seen, "visibility");
      }
    }
    return result;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw Error(ErrorCode::format, file_.string() + ": " + why);
  }
  const Json& member(const Json& object, const char* key, bool (Json::*is)() const noexcept) const {
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (found == object.end() || !((*found).*is)())
      refuse(std::string("lacks '") + key + "', or it is of another type");
    return *found;
  }
  const Json& list(const Json& object, const char* key) const { return member(object, key, &Json::is_array); }
  std::string text(const Json& object, const char* key) const {
    return member(object, key, &Json::is_string).get<std::string>();
  }
  uint64_t count(const Json& object, const char* key) const {
    return member(object, key, &Json::is_number_unsigned).get<uint64_t>();
  }
  double number(const Json& object, const char* key) const {
    return member(object, key, &Json::is_number).get<double>();
  }
  /// A path that cannot lead out of the folder of the drive.
  fs::path pathIn(const Json& object, const char* key) const {
    const fs::path path = pathOf(text(object, key));
    if (path.empty() || path.has_root_path() || std::find(path.begin(), path.end(), "..") != path.end())
      refuse("has the path '" + path.string() + "', which leads out of the folder");
    return path;
  }

  fs::path file_;
  Json content_;
};

/// Whether a file has the size, and if `verify` the hash, of its entry.
bool isWhole(const fs::path& file, const FileEntry& entry, bool verify) {
  std::error_code absent;
  const uintmax_t bytes = fs::file_size(file, absent);
  return !absent && bytes == entry.bytes && (!verify || hashOfFile(file) == entry.hash);
}

}  // namespace

/// A folder for unfinished files with a lock beside it, which are removed together.
class Manifest::Parts {
 public:
  explicit Parts(const fs::path& manifest) {
    // Processes in containers may have the same number and the same name of the machine, so the name is random.
    std::random_device random;
    for (int tries = 0; tries < 100 && (!lock_ || lock_->lost()); ++tries) {
      const std::string name = numberText("%08llx", random()) + numberText("%08llx", random());
      folder_ = manifest / pathOf(partsOfHost() + name);
      lock_ = std::make_unique<FileLock>(lockFile(), FileLock::If::made);
    }
    makeFolder(folder_);
  }
  ~Parts() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    fs::remove(lockFile(), ignored);
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  const fs::path& folder() const { return folder_; }

 private:
  fs::path lockFile() const { return fs::path(folder_).concat(".lock"); }

  fs::path folder_;
  std::unique_ptr<FileLock> lock_;
};

Manifest::Manifest(const Drive& drive, const fs::path& out) : drive_(drive), out_(out), folder_(out / "manifest") {
  makeFolder(folder_ / "frames");
  removeAbandoned(folder_);
  const std::string text =
      jsonText(Json{{"drive", drive.name}, {"frames", drive.frameCount()}, {"fingerprint", drive.fingerprint}}, 1) +
      "\n";
  const fs::path file = folder_ / "drive.json";
  std::error_code absent;
  if (!fs::exists(file, absent)) put(file, text);
  if (readWholeFile(file) != text)
    throw Error(ErrorCode::invalidArgument,
                out.string() +
                    ": holds frames of another drive, or of this one before something of it changed; choose "
                    "another folder");
}

Manifest::~Manifest() = default;

fs::path Manifest::frameFile(uint64_t frame) const {
  return folder_ / "frames" / numberText("%06llu.json", frame);
}

void Manifest::put(const fs::path& file, const std::string& bytes) const {
  makeFolder(file.parent_path());
  if (!parts_) parts_ = std::make_unique<Parts>(folder_);
  AtomicFile out(file, parts_->folder() / "file");
  out.write(bytes);
  out.commit();
}

bool Manifest::isComplete(uint64_t frame, bool verify) const {
  std::error_code absent;
  if (!fs::exists(frameFile(frame), absent)) return false;
  std::vector<FileEntry> entries;
  try {
    const ManifestFile manifest(frameFile(frame));
    entries = manifest.files();
    manifest.scans(scansOf(drive_, frame), drive_.actors.size());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::format) throw;
    return false;  // the frame is made again, and its manifest with it
  }
  for (const FileEntry& entry : entries) {
    const fs::path file = out_ / entry.path;
    if (!entry.into.empty() && fs::exists(out_ / pathOf(entry.into), absent)) continue;
    if (!isWhole(file, entry, verify)) return false;
  }
  return true;
}

void Manifest::write(const FrameRecord& frame, const std::vector<OutputFile>& files) const {
  Json entries = Json::array(), scans = Json::array();
  for (const OutputFile& file : files) {
    put(out_ / pathOf(file.path), file.bytes);
    entries.push_back({{"path", file.path}, {"bytes", file.bytes.size()}, {"hash", hashOf(file.bytes)}});
    if (!file.into.empty()) entries.back()["into"] = file.into;
  }
  for (const RecordedScan& scan : frame.scans) {
    Json boxes = Json::array();
    for (const Box& box : scan.boxes)
      boxes.push_back({{"actor", box.actor}, {"points", box.points}, {"visibility", box.visibility}});
    scans.push_back({{"sensor", scan.planned.sensor}, {"number", scan.planned.number}, {"points", scan.points}});
    if (!boxes.empty()) scans.back()["boxes"] = std::move(boxes);
  }
  put(frameFile(frame.frame), jsonText(Json{{"frame", frame.frame}, {"files", entries}, {"scans", scans}}) + "\n");
}

FrameSummary Manifest::summaryOf(uint64_t frame) const {
  return {ManifestFile(frameFile(frame)).scans(scansOf(drive_, frame), drive_.actors.size())};
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
      if (!isWhole(out_ / entry.path, entry, verify)) broken.push_back(entry.path.generic_string());
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

std::map<fs::path, std::vector<fs::path>> Manifest::usedFiles() const {
  std::map<fs::path, std::vector<fs::path>> used;
  for (uint64_t frame = 0; frame < drive_.frameCount(); ++frame)
    for (const FileEntry& entry : ManifestFile(frameFile(frame)).files())
      if (!entry.into.empty()) used[entry.path.parent_path()].push_back(entry.path);
  return used;
}

void Manifest::removeUsed() const {
  std::error_code ignored;
  for (const auto& [folder, files] : usedFiles()) {
    for (const fs::path& file : files) fs::remove(out_ / file, ignored);
    fs::remove(out_ / folder, ignored);  // if it is empty
  }
}

void Manifest::removeLate() const {
  std::error_code absent;
  for (const fs::path& folder : ManifestFile(finishedFile()).partFolders())
    if (fs::exists(out_ / folder, absent)) return removeUsed();
}

void Manifest::putFinished(const std::vector<FinalFile>& files) const {
  Json entries = Json::array(), folders = Json::array();
  for (const FinalFile& file : files)
    entries.push_back({{"path", file.path}, {"bytes", file.bytes}, {"hash", file.hash}});
  for (const auto& [folder, used] : usedFiles())
    if (!folder.empty()) folders.push_back({{"folder", folder.generic_string()}});
  put(finishedFile(), jsonText(Json{{"files", entries}, {"parts", folders}}, 1) + "\n");
}

bool Manifest::finish(const Finish& finish) const {
  const FileLock lock(folder_ / "lock", FileLock::If::waited);
  std::error_code absent;
  if (fs::exists(finishedFile(), absent)) {
    removeLate();
    return true;
  }
  for (uint64_t frame = 0; frame < drive_.frameCount(); ++frame)
    if (!fs::exists(frameFile(frame), absent)) return false;
  std::vector<FrameSummary> frames;
  for (uint64_t frame = 0; frame < drive_.frameCount(); ++frame) {
    if (!isComplete(frame, false)) return false;
    frames.push_back(summaryOf(frame));
  }
  FinalFiles files(out_);
  finish(frames, files);
  putFinished(files.noted());
  removeUsed();
  return true;
}

}  // namespace gnosphere::drive
