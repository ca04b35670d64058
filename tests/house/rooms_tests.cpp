// SPDX-License-Identifier: Apache-2.0
// The folders ("rooms") of src, checked by their #include lines: each includes only those below it.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;

/// Files that each room may include besides its own, by the table of CONTRIBUTING.md: other rooms, single files of
/// other rooms, and `common`, which is the folder of headers that GLSL and C++ share.
const std::map<std::string, Names>& rooms() {
  static const std::map<std::string, Names> kRooms = [] {
    static const std::regex kRow(R"(\| `(\w+)` \|.*\| ([^|]*) \|)"), kName("`([^`]+)`");
    std::map<std::string, Names> rooms;
    std::ifstream page(fs::path(GNOSPHERE_SOURCES) / "CONTRIBUTING.md");
    std::string line;
    while (std::getline(page, line) && line != "| room | contents | may include |") continue;
    std::getline(page, line);
    for (std::smatch row; std::getline(page, line) && std::regex_match(line, row, kRow);) {
      const std::string allowed = row[2];
      Names& names = rooms[row[1]];
      for (std::sregex_iterator name(allowed.begin(), allowed.end(), kName); name != std::sregex_iterator(); ++name)
        names.insert((*name)[1]);
    }
    return rooms;
  }();
  return kRooms;
}

/// Files of src outside rooms. Loose files are above all rooms and may include any of them.
const Names kLoose = {
    "batch_stream.cpp",     "exports.map",           "kept_scene.cpp",         "kept_scene.hpp",
    "option_table.cpp",     "option_table.hpp",      "shot_checks.cpp",        "shot_checks.hpp",
    "simulator.cpp",        "simulator_options.cpp", "simulator_warnings.cpp", "simulator_warnings.hpp",
    "third_party_files.cpp"};

/// Quoted includes that the build generates: compiled shaders, the shaders translated to CUDA, the schema of drive
/// files.
const std::map<std::string, std::regex> kGenerated = {{"vulkan", std::regex(R"([a-z0-9_]+\.spv\.h)")},
                                                      {"cuda", std::regex(R"(glsl/[a-z0-9_/]+\.(h|comp))")},
                                                      {"drive", std::regex(R"(drive_schema\.h)")},
                                                      {"ros2", std::regex(R"(messages\.h)")}};

struct Tree {
  Names sources, shaders, common;  // paths relative to src, to shaders and to the root
};

std::string list(const Names& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "nothing" : text;
}

/// Returns the rule that an include violates, or an empty text. `file` is relative to src; `system` is true for <...>.
std::string brokenRule(const Tree& tree, const std::string& file, const std::string& include, bool system) {
  const size_t slash = file.find('/');
  const std::string room = slash == std::string::npos ? "" : file.substr(0, slash);
  if (include.starts_with("gnosphere/")) return "";
  if (tree.sources.contains(include)) {
    if (system) return "headers of src are included with quotes";
    if (room.empty() && kLoose.contains(file)) return "";
    const std::string target = include.substr(0, include.find('/'));
    const Names& allowed = rooms().at(room);
    if (target == room || allowed.contains(target) || allowed.contains(include)) return "";
    return room + " may include " + list(allowed);
  }
  if (system) return "";
  if (tree.common.contains(include)) {
    if (room.empty() || rooms().at(room).contains("common")) return "";
    return room + " may include " + list(rooms().at(room));
  }
  const auto generated = kGenerated.find(room);
  if (generated != kGenerated.end() && std::regex_match(include, generated->second)) return "";
  return "an include in quotes is a path below include or src, one that begins with common/, or a file that the build "
         "writes";
}

Tree readTree(const fs::path& root) {
  const auto filesIn = [&](const char* folder, const fs::path& base) {
    Names names;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder))
      if (entry.is_regular_file()) names.insert(fs::relative(entry.path(), base).generic_string());
    return names;
  };
  return {filesIn("src", root / "src"), filesIn("shaders", root / "shaders"), filesIn("common", root)};
}

/// Calls callback(file, number, line) for every line of C++ and CUDA in src.
template <class Callback>
void eachLine(const Tree& tree, Callback callback) {
  static const Names kEndings = {".cpp", ".hpp", ".h", ".cu", ".cuh"};
  for (const std::string& file : tree.sources) {
    if (!kEndings.contains(fs::path(file).extension().string())) continue;
    std::ifstream stream(fs::path(GNOSPHERE_SOURCES) / "src" / file);
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) callback(file, number, line);
  }
}

}  // namespace

TEST_CASE("every file of src lies in a room or is an allowed exception") {
  for (const std::string& file : readTree(GNOSPHERE_SOURCES).sources) {
    const size_t slash = file.find('/');
    if (slash == std::string::npos ? kLoose.contains(file) : rooms().contains(file.substr(0, slash))) continue;
    FAIL_CHECK("src/" << file << " lies in no room of this test; loose in src may lie " << list(kLoose));
  }
}

TEST_CASE("a room includes only the rooms below it") {
  const Tree tree = readTree(GNOSPHERE_SOURCES);
  static const std::regex kInclude(R"re(\s*#\s*include\s*(["<])([^">]+)[">].*)re");
  int count = 0;
  eachLine(tree, [&](const std::string& file, int number, const std::string& line) {
    std::smatch match;
    if (!std::regex_match(line, match, kInclude)) return;
    ++count;
    const std::string rule = brokenRule(tree, file, match[2], match[1] == "<");
    if (!rule.empty()) FAIL_CHECK("src/" << file << ":" << number << ": includes " << match[2] << ", but " << rule);
  });
  CHECK(count > 500);  // fails if the pattern matches nothing
}

TEST_CASE("names of Vulkan's API occur only in src/vulkan, and in the C interface to it") {
  static const std::regex kWords(R"(\b(Vk[A-Z]|volk))");
  const Tree tree = readTree(GNOSPHERE_SOURCES);
  eachLine(tree, [&](const std::string& file, int number, const std::string& line) {
    std::smatch match;
    if (file.starts_with("vulkan/") || file == "c/vulkan.cpp" || !std::regex_search(line, match, kWords)) return;
    FAIL_CHECK("src/" << file << ":" << number << ": says " << match[0]
                      << ", but only src/vulkan and src/c/vulkan.cpp may know Vulkan's API");
  });
}

TEST_CASE("only pictures use hypot(), which C libraries round differently on arm64 and on x86-64") {
  const Tree tree = readTree(GNOSPHERE_SOURCES);
  eachLine(tree, [&](const std::string& file, int number, const std::string& line) {
    const bool draws = file == "output/picture.cpp" || file == "output/canvas.cpp";
    if (draws || line.find("hypot(") == line.npos || line.find("///") != line.npos) return;
    FAIL_CHECK("src/" << file << ":" << number
                      << ": uses hypot(); lengthOf() of base/vector.hpp has the same bits everywhere");
  });
}

TEST_CASE("no two files of src and shaders have the same path") {
  const Tree tree = readTree(GNOSPHERE_SOURCES);
  std::map<std::string, std::string> shaders;  // path without its ending -> path
  for (const std::string& file : tree.shaders) shaders[fs::path(file).replace_extension().generic_string()] = file;
  for (const std::string& file : tree.sources) {
    const auto twin = shaders.find(fs::path(file).replace_extension().generic_string());
    if (twin != shaders.end())
      FAIL_CHECK("src/" << file << " and shaders/" << twin->second << " have one name: rename either");
  }
}

TEST_CASE("an include of a higher room is reported with the rule") {
  const Tree tree = {{"geometry/cone.hpp", "pipeline/backend.hpp", "pipeline/results.hpp"}, {}, {"common/shared.h"}};
  const auto rule = [&](const std::string& file, const std::string& include, bool system = false) {
    return brokenRule(tree, file, include, system);
  };
  CHECK(rule("geometry/flatten.cpp", "geometry/cone.hpp").empty());
  CHECK(rule("geometry/flatten.cpp", "gnosphere/scan.hpp").empty());
  CHECK(rule("geometry/flatten.cpp", "common/shared.h").empty());
  CHECK(rule("base/file.hpp", "common/shared.h") == "base may include nothing");
  CHECK(rule("geometry/flatten.cpp", "algorithm", true).empty());
  CHECK(rule("geometry/flatten.cpp", "pipeline/results.hpp") == "geometry may include base, common");
  CHECK(rule("base/file.hpp", "geometry/cone.hpp") == "base may include nothing");
  CHECK(rule("reference/beam.cpp", "pipeline/backend.hpp").empty());
  CHECK(rule("reference/beam.cpp", "pipeline/results.hpp") ==
        "reference may include base, common, effects, pipeline/backend.hpp, scan, sensor");
  CHECK(rule("vulkan/kernels.cpp", "bin.spv.h").empty());
  CHECK_FALSE(rule("effects/setup.cpp", "bin.spv.h").empty());
  CHECK_FALSE(rule("geometry/flatten.cpp", "cone.hpp").empty());
  CHECK_FALSE(rule("geometry/flatten.cpp", "geometry/cone.hpp", true).empty());
  CHECK(rule("simulator.cpp", "pipeline/results.hpp").empty());
}
