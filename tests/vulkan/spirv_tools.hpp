// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <catch2/catch_test_macros.hpp>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "folder.hpp"

namespace gnosphere::test {

using Words = std::vector<uint32_t>;

inline Words wordsIn(const fs::path& file) {
  const std::string bytes = bytesOf(file);
  Words words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), 4 * words.size());
  return words;
}

/// The programs of SPIRV-Tools and glslang, on files in a folder that goes with the object.
class Tools {
 public:
  void run(const std::string& command) const {
    INFO(command << "\n" << (fs::exists(file("log")) ? bytesOf(file("log")) : ""));
    const bool succeeded = std::system((command + " >" + file("log").string() + " 2>&1").c_str()) == 0;
    INFO(bytesOf(file("log")));
    REQUIRE(succeeded);
  }

  Words compile(const std::string& glsl) const {
    put(file("shader.comp"), glsl);
    run(std::string(GNOSPHERE_GLSLANG) + " --quiet -V --target-env vulkan1.2 -o " + file("shader.spv").string() + " " +
        file("shader.comp").string());
    return wordsIn(file("shader.spv"));
  }

  void validate(const Words& module) const {
    run(std::string(GNOSPHERE_SPIRV_VAL) + " --target-env vulkan1.2 --scalar-block-layout " + stored(module));
  }

  /// Returns how often each operation, by its number, occurs in the functions of a module that spirv-opt has optimised
  /// with `passes` before. Its versions keep different declarations that nothing uses, and load the parts of a
  /// structure one by one or together.
  std::vector<std::string> optimised(const Words& module, const std::string& passes = "") const {
    run(std::string(GNOSPHERE_SPIRV_OPT) + " --target-env=vulkan1.2 --scalar-block-layout --strip-debug " + passes +
        " -O -o " + file("optimised.spv").string() + " " + stored(module));
    const Words words = wordsIn(file("optimised.spv"));
    std::map<uint32_t, int> counts;
    constexpr uint32_t kOpLoad = 61, kOpAccessChain = 65, kOpCompositeExtract = 81, kOpFunction = 54;
    bool inFunctions = false;
    for (size_t at = 5; at < words.size(); at += words[at] >> 16) {
      const uint32_t operation = words[at] & 0xffff;
      inFunctions = inFunctions || operation == kOpFunction;
      if (inFunctions) ++counts[operation];
    }
    for (const uint32_t part : {kOpLoad, kOpAccessChain, kOpCompositeExtract}) counts.erase(part);
    std::vector<std::string> texts;
    for (const auto& [operation, count] : counts)
      texts.push_back(std::to_string(count) + " of " + std::to_string(operation));
    return texts;
  }

  /// Checks that a specialised module is valid, and means what spirv-opt makes of the module after `passes`.
  void checkMeaning(const Words& specialised, const Words& module, const std::string& passes = "") const {
    validate(specialised);
    CHECK(optimised(specialised) == optimised(module, passes));
  }

 private:
  fs::path file(const std::string& name) const { return folder_ / name; }
  std::string stored(const Words& module) const {
    put(file("module.spv"), std::string(reinterpret_cast<const char*>(module.data()), 4 * module.size()));
    return file("module.spv").string();
  }

  Folder folder_;
};

}  // namespace gnosphere::test
