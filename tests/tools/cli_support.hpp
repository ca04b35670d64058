// SPDX-License-Identifier: Apache-2.0
// Runs the program as a script would.
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "folder.hpp"

namespace gnosphere::test {

struct Result {
  int status;
  std::string out, err;
};

/// A temporary folder in which the program runs, with a scene: a floor of 20 m, made of two triangles.
class Workplace {
 public:
  Workplace() { put("floor.obj", "v -10 -10 0\nv 10 -10 0\nv 10 10 0\nv -10 10 0\nf 1 2 3\nf 1 3 4\n"); }

  fs::path operator/(const std::string& name) const { return folder_ / name; }
  void put(const std::string& name, const std::string& bytes) const { test::put(folder_ / name, bytes); }
  std::string get(const std::string& name) const { return bytesOf(folder_ / name); }
  /// Names of the files, except those that run() itself writes.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      const std::string name = entry.path().filename().string();
      if (name != "out" && name != "err") names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  Result run(const std::string& arguments, const std::string& before = "",
             const std::string& program = GNOSPHERE_BINARY) const {
    const std::string command = "cd '" + folder_.path().string() + "' && " + before + " '" + program + "' " +
                                arguments + " >out 2>err </dev/null";
    const int status = std::system(command.c_str());
    REQUIRE(WIFEXITED(status));
    return {WEXITSTATUS(status), get("out"), get("err")};
  }
  /// Runs a call that must succeed, and parses its output as JSON.
  nlohmann::json runJson(const std::string& arguments, const std::string& before = "",
                         const std::string& program = GNOSPHERE_BINARY) const {
    const Result result = run(arguments, before, program);
    INFO(arguments << ": " << result.err);
    REQUIRE(result.status == 0);
    return nlohmann::json::parse(result.out);
  }
  nlohmann::json json(const std::string& name) const { return nlohmann::json::parse(get(name)); }

 private:
  Folder folder_;
};

inline const std::string kQuick = " --device reference --sensor VLP-16 ";

/// Characters of the longest line.
inline size_t longestLine(const std::string& text) {
  size_t longest = 0;
  for (size_t begin = 0; begin < text.size(); begin = text.find('\n', begin) + 1)
    longest = std::max(longest, text.find('\n', begin) - begin);
  return longest;
}

/// Checks that the call fails with this status and a single line that contains these words, and leaves no files.
inline void checkRefused(const std::string& arguments, int status, const std::string& words) {
  INFO("gnosphere " << arguments);
  const Workplace place;
  const Result result = place.run(arguments);
  CHECK(result.status == status);
  CHECK_THAT(result.err, Catch::Matchers::StartsWith("gnosphere: ") && Catch::Matchers::ContainsSubstring(words));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK(result.out.empty());
  CHECK(place.files() == std::vector<std::string>{"floor.obj"});
}

}  // namespace gnosphere::test
