// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch_test_macros.hpp>
#include <fstream>
#include <iterator>
#include <string>

#include "effects/effect_table.hpp"

using namespace gnosphere;

namespace {

std::string textOf(const std::string& file) {
  std::ifstream in(GNOSPHERE_DOCS "/effects/" + file);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("every effect has a page with each of its parameters, and the index links the page") {
  const std::string index = textOf("README.md");
  for (const EffectInfo& effect : effectTable()) {
    const std::string name = effect.name, page = textOf(name + ".md");
    INFO(name);
    CHECK(page.substr(0, 2 + name.size()) == "# " + name);
    CHECK(index.find("[" + name + "](" + name + ".md)") != std::string::npos);
    for (const Parameter& parameter : effect.parameters) {
      INFO(parameter.name);
      CHECK(page.find("| `" + std::string(parameter.name) + "` |") != std::string::npos);
    }
  }
}
