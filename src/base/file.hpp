// SPDX-License-Identifier: Apache-2.0
// Reads whole files, and writes files that appear only when they are complete.
#pragma once

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "base/os.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

/// Returns the content of a file. Throws Error(file) with the system's reason, or Error(format) if it exceeds
/// `maxBytes`. A device that is no terminal, as /dev/zero, may have no end, so it is refused if it has more than a
/// block; pipes are read to their end.
inline std::string readWholeFile(const std::filesystem::path& file, uint64_t maxBytes = UINT64_MAX) {
  const auto refuse = [&] {
    const int reason = errno;
    throw Error(ErrorCode::file, file.string() + ": cannot be read: " + os::reasonText(reason));
  };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(os::openFile(file, "rb"), std::fclose);
  if (!stream) refuse();
  std::string bytes;
  std::error_code unknown;  // a pipe has no size; it is read block by block like the rest
  const std::filesystem::file_type type = std::filesystem::status(file, unknown).type();
  const bool isDevice = (type == std::filesystem::file_type::character || type == std::filesystem::file_type::block) &&
                        !os::isTerminal(stream.get());
  const uint64_t size = std::filesystem::file_size(file, unknown);
  // One byte more than the size, so that the first block shows the end of a file.
  const size_t block = std::max(!unknown && size < maxBytes ? size_t{size} + 1 : 0, size_t{1} << 16);
  size_t count = 0;
  try {
    do {
      const size_t start = bytes.size();
      bytes.resize(start + block);
      count = std::fread(bytes.data() + start, 1, block, stream.get());
      bytes.resize(start + count);
    } while (count == block && bytes.size() <= maxBytes && !isDevice);
  } catch (const std::exception&) {  // bad_alloc, or length_error for the size of a sparse file
    throw Error(ErrorCode::outOfMemory, file.string() + ": does not fit into memory");
  }
  if (std::ferror(stream.get()) != 0) refuse();
  if (isDevice && !std::feof(stream.get()))
    throw Error(ErrorCode::file, file.string() + ": is a device and no file; give a file or a pipe");
  if (bytes.size() > maxBytes) {
    throw Error(ErrorCode::format, file.string() + ": is larger than " + std::to_string(maxBytes >> 20) + " MiB");
  }
  return bytes;
}

/// Where the bytes of an output file go.
struct WritePlace {
  std::filesystem::path file;  ///< the file, or what links from it lead to
  bool inPlace = false;        ///< whether it is a pipe or a device, or an open file that a link of /proc names
};

/// Returns the place to which an output file is written. Links are followed, also to a file that is not there yet.
inline WritePlace writePlaceOf(std::filesystem::path file) {
  constexpr int kMostLinks = 40;  // as in Linux
  std::error_code absent;
  bool inPlace = std::filesystem::exists(file, absent) && !std::filesystem::is_regular_file(file, absent) &&
                 !std::filesystem::is_directory(file, absent);
  for (int i = 0; i < kMostLinks && !inPlace && std::filesystem::is_symlink(file, absent); ++i) {
    inPlace = file.generic_string().starts_with("/proc/");
    if (!inPlace) file = file.parent_path() / std::filesystem::read_symlink(file, absent);
  }
  return {std::move(file), inPlace};
}

/// Returns the name under which a final file of a data set is written until it is complete. One process at a time may
/// write it.
inline std::filesystem::path partOf(const std::filesystem::path& file) {
  return std::filesystem::path(file) += ".part";
}

/// An output file that appears only when it is complete: until then it is written in its folder as .NAME.part, or under
/// a name of its own while another process writes that one. commit() renames it, and the destructor removes what was
/// not committed; what a killed process has left is written over by the next one, and a program may have it removed by
/// os::removeUnfinishedAtEnd(). If the file is a link, the file to which it leads is written so. A file that is
/// replaced hands its permissions on; one that may not be written is not replaced. Pipes and devices are written
/// directly. Every member throws Error(file) with the system's reason.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path file) : file_(std::move(file)), place_(writePlaceOf(file_)) {
    part_ = place_.file;
    checkNoFolder();
    std::error_code absent;
    if (place_.inPlace) {
      stream_ = os::openFile(part_, "wb");
      if (!stream_) refuse(errno);
    } else if (std::filesystem::exists(place_.file, absent) && !os::isWritable(place_.file)) {
      refuse(errno);
    } else {
      if (!openShared()) openUnique();
      unfinished_ = os::addUnfinished(part_);
    }
  }
  /// Writes to `part`, which commit() renames, and follows no link: data sets that are exchanged may have links that
  /// lead out of their folder. A data set that is stopped is resumed, so the part stays then.
  AtomicFile(std::filesystem::path file, std::filesystem::path part)
      : file_(std::move(file)), place_{file_}, part_(std::move(part)) {
    checkNoFolder();
    stream_ = os::openPart(part_, true);
    if (!stream_) refuse(errno);
  }
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile() {
    if (stream_) std::fclose(stream_);
    os::dropUnfinished(unfinished_);
    if (!committed_ && !place_.inPlace) removePart();
    unlock();
  }

  void write(const void* data, size_t bytes) {
    if (bytes > 0 && std::fwrite(data, 1, bytes, stream_) != bytes) refuse(errno);
  }
  void write(const std::string& text) { write(text.data(), text.size()); }

  /// The content reaches the disk before the name does, so that a file that is there is complete after a power failure,
  /// too.
  void commit() {
    if (std::fflush(stream_) != 0) refuse(errno);
    if (!place_.inPlace) os::copyPermissions(place_.file, stream_);
    if (!os::synchronise(stream_)) refuse(errno);
    if (std::fclose(std::exchange(stream_, nullptr)) != 0) refuse(errno);
    os::dropUnfinished(std::exchange(unfinished_, -1));  // as soon as it is renamed, others may use its name
    if (!place_.inPlace && !os::renameFile(part_, place_.file)) refuse(errno);
    unlock();  // a file that is open for its lock cannot be replaced on every system
    committed_ = true;
  }

 private:
  void checkNoFolder() const {
    std::error_code ignored;
    if (std::filesystem::is_directory(place_.file, ignored)) refuse(EISDIR);
  }
  void unlock() {
    if (lock_ >= 0) os::closeFile(std::exchange(lock_, -1));
  }
  void removePart() const { os::removeFile(part_); }
  // Opens .NAME.part, unless another process or user has it, or something else has the name, or the name would be too
  // long, or the file system has no locks.
  // The lock is kept until the file has been renamed, so that nobody writes over it before. The name is made first,
  // because nothing removes the file if there is no memory for its name afterwards.
  bool openShared() {
    part_ = place_.file.parent_path() / ((std::filesystem::path(".") += place_.file.filename()) += ".part");
    stream_ = os::openPart(part_, false);
    const auto isOneOf = [](int reason, auto... others) { return ((reason == others) || ...); };
    if (!stream_ && !isOneOf(errno, ENAMETOOLONG, EISDIR, ELOOP, ENXIO, EACCES, EPERM, EBUSY)) refuse(errno);
    if (!stream_) return false;
    lock_ = os::descriptorOf(stream_);
    const os::Lock lock = lock_ >= 0 ? os::lockFile(lock_, false) : os::Lock::absent;
    if (lock == os::Lock::taken && os::isNamed(lock_, part_) && os::makeEmpty(lock_)) return true;
    if (lock == os::Lock::absent) removePart();  // nobody can use it
    std::fclose(std::exchange(stream_, nullptr));
    unlock();
    return false;
  }
  // Processes may share a number, in containers, so that a name is free only if the system says so.
  void openUnique() {
    static std::atomic<uint64_t> tries = 0;
    while (!stream_) {
      const auto now = static_cast<uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
      char name[64];
      std::snprintf(name, sizeof(name), ".gnosphere-%x-%llx.part", os::processNumber(),
                    static_cast<unsigned long long>(now + tries++));
      part_ = place_.file.parent_path() / name;
      stream_ = os::openFile(part_, "wbx");
      if (!stream_ && errno != EEXIST) refuse(errno);
    }
  }
  [[noreturn]] void refuse(int reason) const {
    std::string text = file_.string() + ": cannot be written: " + os::reasonText(reason);
    const std::filesystem::path folder = place_.file.parent_path();
    const auto lacks = [&](const std::filesystem::path& place) {
      std::error_code ignored;
      return reason == ENOENT && !place.empty() && !std::filesystem::exists(place, ignored);
    };
    const std::string drive = folder.root_name().string();  // of Windows
    if (drive.ends_with(':') && lacks(folder.root_path()))
      text += "; there is no drive '" + drive + "'";
    else if (lacks(folder))
      text += "; there is no folder '" + folder.string() + "', so make it first";
    throw Error(ErrorCode::file, text);
  }

  std::filesystem::path file_;
  WritePlace place_;
  std::filesystem::path part_;
  std::FILE* stream_ = nullptr;
  os::Descriptor lock_ = -1;
  int unfinished_ = -1;  // place among those of os::addUnfinished()
  bool committed_ = false;
};

/// Throws Error(file) if `file` cannot be written, before any work is done for it. No file is left behind. A pipe is
/// not opened, because its reader would see the end of it.
inline void checkWritable(const std::filesystem::path& file) {
  if (!writePlaceOf(file).inPlace) {
    const AtomicFile probe(file);
  } else if (!os::isWritable(file)) {
    throw Error(ErrorCode::file, file.string() + ": cannot be written: " + os::reasonText(errno));
  }
}

}  // namespace gnosphere
