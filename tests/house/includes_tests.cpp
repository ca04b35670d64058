// SPDX-License-Identifier: Apache-2.0
// The headers of the standard library that files of this project use. Which of them include each other differs between
// versions of a compiler, so a file that relies on that builds with one version and not with the next.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;

/// Names in std, by the header that declares them.
const std::map<std::string, Names> kDeclared = {
    {"algorithm",
     {"adjacent_find", "all_of",      "any_of",         "binary_search", "clamp",       "copy",        "copy_if",
      "copy_n",        "count",       "count_if",       "equal",         "equal_range", "fill",        "fill_n",
      "find",          "find_if",     "for_each",       "generate",      "includes",    "is_sorted",   "lower_bound",
      "max",           "max_element", "merge",          "min",           "min_element", "minmax",      "mismatch",
      "none_of",       "nth_element", "partition",      "remove",        "remove_if",   "replace",     "reverse",
      "rotate",        "search",      "shuffle",        "sort",          "stable_sort", "swap_ranges", "transform",
      "unique",        "upper_bound", "minmax_element", "set_difference"}},
    {"any", {"any"}},
    {"array", {"array"}},
    {"atomic", {"atomic"}},
    {"bit", {"bit_cast", "bit_ceil", "bit_width", "countr_zero", "popcount"}},
    {"bitset", {"bitset"}},
    {"cctype", {"isalnum", "isalpha", "isdigit", "isspace", "tolower", "toupper"}},
    {"charconv", {"from_chars", "to_chars"}},
    {"chrono", {"chrono"}},
    {"cmath",
     {"atan2", "ceil", "cos", "exp", "floor", "fma", "hypot", "isfinite", "isnan", "log", "lround", "nextafter", "pow",
      "round", "sin", "sqrt"}},
    {"complex", {"complex"}},
    {"concepts", {"floating_point", "integral", "invocable", "same_as"}},
    {"condition_variable", {"condition_variable"}},
    {"cstdio", {"fflush", "fopen", "fprintf", "fputs", "freopen", "printf", "snprintf", "sscanf"}},
    {"cstdlib", {"getenv", "strtod", "system"}},
    {"cstring", {"memcmp", "memcpy", "memset", "strcmp", "strerror", "strlen"}},
    {"deque", {"deque"}},
    {"exception", {"current_exception", "exception_ptr", "rethrow_exception", "terminate"}},
    {"filesystem", {"filesystem"}},
    {"fstream", {"fstream", "ifstream", "ofstream"}},
    {"functional", {"function", "greater", "less"}},
    {"future", {"async", "future", "promise"}},
    {"initializer_list", {"initializer_list"}},
    {"iomanip", {"setfill", "setprecision", "setw"}},
    {"iostream", {"cerr", "cin", "cout"}},
    {"iterator",
     {"advance", "back_inserter", "distance", "inserter", "istreambuf_iterator", "make_move_iterator", "next", "prev",
      "reverse_iterator"}},
    {"limits", {"numeric_limits"}},
    {"list", {"list"}},
    {"map", {"map", "multimap"}},
    {"memory", {"make_shared", "make_unique", "shared_ptr", "unique_ptr"}},
    {"mutex", {"lock_guard", "mutex", "scoped_lock", "unique_lock"}},
    {"numbers", {"numbers"}},
    {"numeric", {"accumulate", "exclusive_scan", "inner_product", "iota", "partial_sum", "reduce"}},
    {"optional", {"optional"}},
    {"queue", {"priority_queue", "queue"}},
    {"random", {"mt19937", "mt19937_64", "random_device", "uniform_real_distribution"}},
    {"regex", {"regex", "regex_match", "regex_replace", "regex_search", "smatch", "sregex_iterator"}},
    {"set", {"multiset", "set"}},
    {"span", {"span"}},
    {"sstream", {"istringstream", "ostringstream", "stringstream"}},
    {"stdexcept", {"invalid_argument", "logic_error", "runtime_error"}},
    {"string_view", {"string_view"}},
    {"system_error", {"errc", "error_code", "generic_category", "system_category", "system_error"}},
    {"thread", {"thread"}},
    {"tuple", {"tie", "tuple"}},
    {"type_traits", {"is_floating_point_v", "is_same_v", "remove_reference_t"}},
    {"unordered_map", {"unordered_map"}},
    {"unordered_set", {"unordered_set"}},
    {"utility", {"exchange", "forward", "make_pair", "move", "pair", "swap"}},
    {"variant", {"variant", "visit"}},
    {"vector", {"vector"}},
};

struct File {
  Names uses;      // headers that declare the names it uses
  Names includes;  // as it writes them
};

std::map<fs::path, File> readFiles(const fs::path& root) {
  static const Names kEndings = {".cpp", ".hpp", ".h", ".cu", ".cuh"};
  static const std::regex kInclude(R"re(#\s*include\s*["<]([^">]+)[">])re"), kName(R"(\bstd::([a-z_0-9]+))");
  std::map<std::string, std::string> headers;
  for (const auto& [header, names] : kDeclared)
    for (const std::string& name : names) headers[name] = header;
  std::map<fs::path, File> files;
  for (const char* folder :
       {"include", "common", "src", "shaders", "tools", "tests", "bench", "examples", "python/src"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      if (!entry.is_regular_file() || !kEndings.contains(entry.path().extension().string())) continue;
      File& file = files[fs::relative(entry.path(), root)];
      std::ifstream stream(entry.path());
      const std::string text{std::istreambuf_iterator<char>(stream), {}};
      for (std::sregex_iterator match(text.begin(), text.end(), kInclude); match != std::sregex_iterator(); ++match)
        file.includes.insert((*match)[1]);
      for (std::sregex_iterator match(text.begin(), text.end(), kName); match != std::sregex_iterator(); ++match)
        if (const auto header = headers.find((*match)[1]); header != headers.end()) file.uses.insert(header->second);
    }
  return files;
}

/// Collects what a file includes, and what the files of the project that it includes do.
void collect(const std::map<fs::path, File>& files, const fs::path& path, Names& seen, Names& headers) {
  if (!seen.insert(path.generic_string()).second) return;
  for (const std::string& include : files.at(path).includes) {
    headers.insert(include);
    for (const fs::path& folder : {path.parent_path(), fs::path("include"), fs::path("src"), fs::path(),
                                   fs::path("tools"), fs::path("tests"), fs::path("bench")})
      if (const fs::path target = (folder / include).lexically_normal(); files.contains(target))
        collect(files, target, seen, headers);
  }
}

}  // namespace

TEST_CASE("a file includes the standard headers that declare what it uses, or a file of the project that does") {
  const std::map<fs::path, File> files = readFiles(GNOSPHERE_SOURCES);
  CHECK(files.size() > 300);
  for (const auto& [path, file] : files) {
    Names seen, headers;
    collect(files, path, seen, headers);
    for (const std::string& header : file.uses)
      if (!headers.contains(header)) FAIL_CHECK(path.generic_string() << " uses what <" << header << "> declares");
  }
}
