// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch_test_macros.hpp>
#include <fstream>
#include <iterator>
#include <string>

#include "effects/effect_table.hpp"
#include "pipeline/kernels.hpp"

using namespace gnosphere;

namespace {

std::string textOf(const std::string& file) {
  std::ifstream in(GNOSPHERE_DOCS "/" + file);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("every effect has a page, and the index links it") {
  const std::string index = textOf("effects/README.md");
  for (const EffectInfo& effect : effectTable()) {
    const std::string name = effect.name, page = textOf("effects/" + name + ".md");
    INFO(name);
    CHECK(page.substr(0, 2 + name.size()) == "# " + name);
    CHECK(index.find("[" + name + "](" + name + ".md)") != std::string::npos);
  }
}

TEST_CASE("docs/architecture.md names every kernel") {
  const std::string page = textOf("architecture.md");
  for (size_t i = 0; i < kKernelCount; ++i) {
    const std::string name = nameOf(static_cast<Kernel>(i));
    INFO(name);
    CHECK(page.find("| `" + name + "` |") != std::string::npos);
  }
}
