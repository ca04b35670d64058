// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "gnosphere/error.hpp"
#include "readers.hpp"

namespace gnosphere {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& file, std::string_view content) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << content;
}

/// Calls gnosphere view, which may refuse what it reads with an Error.
void view(const fs::path& folder, std::vector<std::string> clouds) {
  CLI::App app;
  const cli::Action action = cli::addView(app);
  clouds.insert(clouds.end(), {"-o", (folder / "page.html").string(), "--three", (folder / "three").string()});
  std::reverse(clouds.begin(), clouds.end());  // as CLI11 takes them
  app.parse(clouds);
  try {
    action();
  } catch (const Error&) {
  }
}

/// A file of a drive's output, with its content unless the input replaces it.
struct DriveFile {
  const char* path;
  std::string content;
};

const std::map<char, DriveFile>& driveFiles() {
  static const std::map<char, DriveFile> files = {
      {'d', {"manifest/drive.json", R"({"drive": "town", "frames": 1})"}},
      {'f',
       {"manifest/frames/000000.json",
        R"({"frame": 0, "scans": [{"points": 2}], "files": [{"path": "00/velodyne/000000.bin"},
        {"path": "00/labels/000000.label"}, {"path": "boxes/top/000000.jsonl"}]})"}},
      {'o', {"objects.json", R"([{"name": "car", "object": 1, "actor": true}])"}},
      {'c', {"00/velodyne/classes.json", R"({"car": 10, "ground": 40})"}},
      {'b',
       {"boxes/top/000000.jsonl",
        R"({"name": "car", "class": "car", "points": 1, "moving": true, "size": [4, 2, 1], "sensor_frame": {"position": [1, 2, 0], "orientation": [0, 0, 0, 1]}})"}},
      {'l', {"00/labels/000000.label", std::string("\x0a\0\x01\0\x28\0\0\0", 8)}},
      {'k', {"00/velodyne/000000.bin", std::string(32, '\x3f')}},
  };
  return files;
}

}  // namespace

void fuzzView(std::span<const uint8_t> input) {
  if (input.empty()) return;
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  const std::string_view content = text.substr(1);
  const fs::path folder = fs::temp_directory_path() / ("gnosphere-fuzz-view-" + std::to_string(::getpid()));
  write(folder / "three/build/three.min.js", "");
  write(folder / "three/examples/js/controls/OrbitControls.js", "");
  if (driveFiles().contains(text[0])) {
    for (const auto& [letter, file] : driveFiles())
      write(folder / "drive" / file.path, letter == text[0] ? content : std::string_view(file.content));
    view(folder, {(folder / "drive").string()});
  } else {
    constexpr const char* kEndings[] = {".pcd", ".ply", ".npy", ".csv", ".bin", ".pcd.bin"};
    const fs::path a = folder / (std::string("a") + kEndings[input[0] % std::size(kEndings)]), b = folder / "b.csv";
    write(a, content);
    write(b, "x,y,z,beam\n1,2,3,4\n-1,0,0,5\n");
    view(folder, {a.string()});
    view(folder, {a.string(), b.string()});
  }
  fs::remove_all(folder);
}

}  // namespace gnosphere
