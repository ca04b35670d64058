// SPDX-License-Identifier: Apache-2.0
// Files in a folder of their own, and a cloud small enough to count by hand.
#pragma once

#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "gnosphere/gnosphere.hpp"

namespace gnosphere {

namespace fs = std::filesystem;

/// A folder of its own for each test, gone afterwards.
struct Folder {
  fs::path path;
  Folder() {
    std::string name = (fs::temp_directory_path() / "gnosphere-output-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~Folder() { fs::remove_all(path); }
  fs::path operator/(const std::string& name) const { return path / name; }
  size_t fileCount() const { return static_cast<size_t>(std::distance(fs::directory_iterator(path), {})); }
};

inline std::string bytesOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline void put(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

template <class T>
T at(const std::string& bytes, size_t offset) {
  T value;
  REQUIRE(offset + sizeof(T) <= bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

/// Three columns, two channels, one miss; every array filled.
inline Scan tiny() {
  Scan scan;
  scan.sensor = "tiny";
  scan.columns = 3;
  scan.channels = 2;
  for (uint32_t beam = 0; beam < 6; ++beam) {
    const auto f = static_cast<float>(beam);
    const bool hit = beam != 4;
    const float nan = -std::nanf("");  // with a sign, as some machines make them
    for (float value : {f + 0.1f, -f, f * 1e-20f}) scan.points.push_back(hit ? value : nan);
    scan.ranges.push_back(hit ? f + 1 : nan);
    scan.triangles.push_back(hit ? 100 + beam : kNoTriangle);
    scan.instances.push_back(hit ? 7 : kNoTriangle);
    scan.ties.push_back(beam == 2);
    scan.tolerances.push_back(hit ? 1e-5f : nan);
  }
  return scan;
}

}  // namespace gnosphere
