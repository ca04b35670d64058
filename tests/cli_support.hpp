// SPDX-License-Identifier: Apache-2.0
// Runs the program as a script would run it.
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace gnosphere::test {

namespace fs = std::filesystem;

struct Result {
  int status;
  std::string out, err;
};

/// A folder to run the program in, with a scene: a floor of 20 m, two triangles.
class Workplace {
 public:
  Workplace() {
    std::string name = (fs::temp_directory_path() / "gnosphere-cli-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
    put("floor.obj", "v -10 -10 0\nv 10 -10 0\nv 10 10 0\nv -10 10 0\nf 1 2 3\nf 1 3 4\n");
  }
  ~Workplace() { fs::remove_all(path_); }

  fs::path operator/(const std::string& name) const { return path_ / name; }
  void put(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
  }
  std::string get(const std::string& name) const {
    std::ifstream stream(path_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  /// Names of the files, without those that run() itself makes.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(path_)) {
      const std::string name = entry.path().filename().string();
      if (name != "out" && name != "err") names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  Result run(const std::string& arguments, const std::string& before = "",
             const std::string& program = GNOSPHERE_BINARY) const {
    const std::string command =
        "cd '" + path_.string() + "' && " + before + " '" + program + "' " + arguments + " >out 2>err </dev/null";
    const int status = std::system(command.c_str());
    REQUIRE(WIFEXITED(status));
    return {WEXITSTATUS(status), get("out"), get("err")};
  }

 private:
  fs::path path_;
};

inline const std::string kQuick = " --device reference --sensor VLP-16 ";

/// The call fails with this status and one line that holds these words, and leaves the folder as it was.
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
