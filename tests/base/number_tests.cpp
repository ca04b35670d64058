// SPDX-License-Identifier: Apache-2.0
// Words and numbers of text formats.
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "base/number.hpp"

using namespace gnosphere;

namespace {

/// Returns the number that a word is, or -1 if the word is no number.
double numberIn(const std::string& word) {
  double value = -1;
  return parseNumber(word, value) ? value : -1;
}

}  // namespace

TEST_CASE("a number that no double can hold is infinite if it is too large, and 0 if it is too small") {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const std::string zeros(400, '0');
  for (const std::string& large :
       {std::string("1e400"), std::string("+1E+400"), std::string("10.0e400"), std::string("0.5e400"),
        std::string("0.001e400"), "1" + zeros, "1" + zeros + ".0", "1" + zeros + "e-5",
        std::string("1e9223372036854775807"), std::string("1e99999999999999999999")}) {
    INFO(large);
    CHECK(numberIn(large) == kInfinite);
    if (large[0] != '+') CHECK(numberIn("-" + large) == -kInfinite);
  }
  for (const std::string& small :
       {std::string("1e-400"), std::string("-1E-400"), std::string("10.0e-400"), std::string("123456e-400"),
        "0." + zeros + "1", "." + zeros + "1", "0." + zeros + "1e5", std::string("0.01e-9223372036854775808"),
        std::string("1e-99999999999999999999")}) {
    INFO(small);
    CHECK(numberIn(small) == 0);
  }
  // Such numbers are within the range of a double, however they are written.
  CHECK(numberIn("1" + zeros + "e-400") == 1);
  CHECK(numberIn("0." + zeros + "1e401") == 1);
  CHECK(numberIn("4.9e-324") == std::numeric_limits<double>::denorm_min());
}

TEST_CASE("a word is a number as C's library reads it, or it is none") {
  for (const char* word : {"0", "-0.0", "1", "+2.5", "-.5", "7.", "1e3", "-12.75E-2", "3.4028236e38", "0.1"}) {
    INFO(word);
    CHECK(numberIn(word) == std::strtod(word, nullptr));
  }
  CHECK(std::isnan(numberIn("nan")));
  CHECK(numberIn("-inf") == -std::numeric_limits<double>::infinity());
  for (const char* word : {"", "+", "-", ".", "1,5", "1 ", "0x10", "1e", "e5", "one", "1.2.3"}) {
    INFO('"' << word << '"');
    CHECK(numberIn(word) == -1);
  }
}

TEST_CASE("words are what blanks part, also those of other systems") {
  std::string_view text = "\t one  two\r\nthree\v\f";
  CHECK(nextWord(text) == "one");
  CHECK(nextWord(text) == "two");
  CHECK(nextWord(text) == "three");
  CHECK(nextWord(text).empty());
  CHECK(nextWord(text).empty());
}
