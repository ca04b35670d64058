// SPDX-License-Identifier: Apache-2.0
#include "drive/manifest.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <set>

#include "base/file.hpp"
#include "drive/hash.hpp"

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
  char host[256] = {};
  gethostname(host, sizeof(host) - 1);
  return std::string("parts-") + host + "-";
}

/// Holds a lock on a file. The system releases it when the process ends, however it ends. Other machines respect it,
/// too, if the file system can.
class FileLock {
 public:
  explicit FileLock(const fs::path& file, bool wait = true)
      : descriptor_(open(file.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666)) {
    holds_ = descriptor_ >= 0 && flock(descriptor_, wait ? LOCK_EX : LOCK_EX | LOCK_NB) == 0;
  }
  ~FileLock() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  bool holds() const { return holds_; }

 private:
  int descriptor_;
  bool holds_ = false;
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
    const FileLock lock(file, false);
    if (!lock.holds()) continue;
    fs::remove(file, ignored);
    fs::remove_all(file.replace_extension(), ignored);
  }
}

}  // namespace

/// A folder for unfinished files with a lock beside it, which are removed together.
class Manifest::Parts {
 public:
  explicit Parts(const fs::path& folder) : folder_(folder), lock_(fs::path(folder).concat(".lock")) {
    makeFolder(folder_);
  }
  ~Parts() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    fs::remove(fs::path(folder_).concat(".lock"), ignored);
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
  FileLock lock_;
};

Manifest::Manifest(const Drive& drive, const fs::path& out) : drive_(drive), out_(out), folder_(out / "manifest") {
  makeFolder(folder_ / "frames");
  removeAbandoned(folder_);
  parts_ = std::make_unique<Parts>(folder_ / (partsOfHost() + std::to_string(getpid())));
  const std::string text =
      Json{{"drive", drive.name}, {"frames", drive.frameCount()}, {"fingerprint", drive.fingerprint}}.dump(1) + "\n";
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
  AtomicFile out(file, parts_->folder() / "file");
  out.write(bytes);
  out.commit();
}

bool Manifest::isComplete(uint64_t frame, bool verify) const {
  std::error_code absent;
  if (!fs::exists(frameFile(frame), absent)) return false;
  const Json manifest = Json::parse(readWholeFile(frameFile(frame)), nullptr, false);
  if (manifest.is_discarded()) return false;
  for (const Json& entry : manifest.at("files")) {
    const fs::path file = out_ / entry.at("path").get<std::string>();
    if (entry.contains("into") && fs::exists(out_ / entry.at("into").get<std::string>(), absent)) continue;
    const uintmax_t bytes = fs::file_size(file, absent);
    if (absent || bytes != entry.at("bytes").get<uint64_t>()) return false;
    if (verify && hashOf(readWholeFile(file)) != entry.at("hash").get<std::string>()) return false;
  }
  return true;
}

void Manifest::write(const FrameRecord& frame, const std::vector<OutputFile>& files) const {
  Json entries = Json::array(), scans = Json::array();
  for (const OutputFile& file : files) {
    put(out_ / file.path, file.bytes);
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
  put(frameFile(frame.frame), Json{{"frame", frame.frame}, {"files", entries}, {"scans", scans}}.dump() + "\n");
}

FrameSummary Manifest::summaryOf(uint64_t frame) const {
  const Json manifest = Json::parse(readWholeFile(frameFile(frame)));
  const std::vector<PlannedScan> planned = scansOf(drive_, frame);
  FrameSummary summary;
  for (size_t i = 0; i < planned.size(); ++i) {
    const Json& scan = manifest.at("scans").at(i);
    ScanSummary& entry = summary.scans.emplace_back(ScanSummary{planned[i], scan.at("points").get<uint64_t>(), {}});
    if (!scan.contains("boxes")) continue;
    for (const Json& seen : scan["boxes"]) {
      Box& box = entry.boxes.emplace_back();
      box.actor = seen.at("actor").get<size_t>();
      box.points = seen.at("points").get<uint64_t>();
      box.visibility = seen.at("visibility").get<double>();
    }
  }
  return summary;
}

void Manifest::reopen() const {
  std::error_code ignored;
  fs::remove(folder_ / "finished", ignored);
}

void Manifest::removeUsed() const {
  std::set<fs::path> folders;
  std::error_code ignored;
  for (uint64_t frame = 0; frame < drive_.frameCount(); ++frame) {
    const Json manifest = Json::parse(readWholeFile(frameFile(frame)));
    for (const Json& entry : manifest.at("files")) {
      if (!entry.contains("into")) continue;
      const fs::path file = out_ / entry.at("path").get<std::string>();
      fs::remove(file, ignored);
      folders.insert(file.parent_path());
    }
  }
  for (const fs::path& folder : folders) fs::remove(folder, ignored);  // if it is empty
}

bool Manifest::finish(const std::function<void(const std::vector<FrameSummary>&)>& finish) const {
  const FileLock lock(folder_ / "lock");
  std::error_code absent;
  if (fs::exists(folder_ / "finished", absent)) return true;
  for (uint64_t frame = 0; frame < drive_.frameCount(); ++frame)
    if (!fs::exists(frameFile(frame), absent)) return false;
  std::vector<FrameSummary> frames;
  for (uint64_t frame = 0; frame < drive_.frameCount(); ++frame) {
    if (!isComplete(frame, false)) return false;
    frames.push_back(summaryOf(frame));
  }
  finish(frames);
  put(folder_ / "finished", "");
  removeUsed();
  return true;
}

}  // namespace gnosphere::drive
