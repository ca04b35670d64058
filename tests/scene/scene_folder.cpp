// SPDX-License-Identifier: Apache-2.0
// scene_folder FOLDER...: scans every scene in the folders from poses inside it with VLP-16 and HDL-64E, on the Vulkan
// device and by the reference; prints a row per scene and fails on any difference except ties.
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <set>

#include "support.hpp"

using namespace gnosphere;

namespace {

constexpr int kPoses = 4;

struct Row {
  uint64_t beams = 0, hits = 0, missed = 0, falseHits = 0, wrongOwner = 0, wrongRange = 0, ties = 0;
  double worst = 0;
  void add(const Comparison& c) {
    beams += c.beams, hits += c.hits, missed += c.missed, falseHits += c.falseHits, wrongOwner += c.wrongOwner;
    wrongRange += c.wrongRange, ties += c.ties, worst = std::max(worst, c.rangeErrorMax);
  }
  bool same() const { return missed + falseHits + wrongOwner + wrongRange == 0; }
  void print(const std::string& name, uint64_t triangles) const {
    std::printf("%-60.60s %10llu %10llu %10llu %6llu %6llu %6llu %6llu %8llu %10.2e%s\n", name.c_str(),
                static_cast<unsigned long long>(triangles), static_cast<unsigned long long>(beams),
                static_cast<unsigned long long>(hits), static_cast<unsigned long long>(missed),
                static_cast<unsigned long long>(falseHits), static_cast<unsigned long long>(wrongOwner),
                static_cast<unsigned long long>(wrongRange), static_cast<unsigned long long>(ties), worst,
                same() ? "" : "  DIFFERS");
    std::fflush(stdout);
  }
};

// A pose near the middle of the scene, or at a random place in its box with a random rotation. The box of a flat scene
// is extended, because a sensor in the plane of all triangles would see only ties.
Pose poseInside(Bounds box, int number) {
  test::Random random(static_cast<uint32_t>(number));
  const double depth = 0.05 * std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
  box.min = {box.min.x - depth, box.min.y - depth, box.min.z - depth};
  const auto within = [&](double low, double high) { return low + (high - low) * (0.5 + 0.4 * random()); };
  if (number == 0) return {{(box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2, (box.min.z + box.max.z) / 2}, {}};
  const Vec3 place = {within(box.min.x, box.max.x), within(box.min.y, box.max.y), within(box.min.z, box.max.z)};
  return {place, {0.1 * random(), 0.1 * random(), random(), 1}};
}

Row compareScene(const Scene& scene) {
  const std::vector<Sensor> sensors = {builtinSensor("VLP-16"), builtinSensor("HDL-64E")};
  test::TestOptions reference;
  reference.device = DeviceChoice::Kind::reference;
  Simulator truth = test::makeSimulator(scene, sensors, reference), device = test::makeSimulator(scene, sensors);
  const Bounds box = worldBounds(scene);
  Row row;
  for (int k = 0; k < (box.empty() ? 1 : kPoses); ++k)
    for (size_t s = 0; s < sensors.size(); ++s) {
      const Pose pose = box.empty() ? Pose{} : poseInside(box, k);
      const Scan expected = truth.scan(pose, s), got = device.scan(pose, s);
      const Comparison difference = compare(expected, got);
      if (!difference.same())
        std::printf("  pose %d, %s: %s\n", k, sensors[s].name.c_str(), test::firstDifference(expected, got).c_str());
      row.add(difference);
    }
  return row;
}

std::set<std::filesystem::path> scenesBelow(const char* folder) {
  const std::set<std::string> endings = {".gltf", ".glb", ".obj", ".ply", ".stl"};
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
    if (entry.is_regular_file() && endings.count(ending)) files.insert(entry.path());
  }
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: scene_folder FOLDER...\n"), 2;
  std::printf("%-60s %10s %10s %10s %6s %6s %6s %6s %8s %10s\n", "scene", "triangles", "beams", "hits", "missed",
              "false", "owner", "range", "ties", "worst m");
  Row total;
  int scenes = 0, refused = 0;
  uint64_t triangles = 0;
  for (int i = 1; i < argc; ++i)
    for (const auto& file : scenesBelow(argv[i])) {
      const std::string name = std::filesystem::relative(file, argv[i]).string();
      try {
        const Scene scene = loadScene(file);
        const Row row = compareScene(scene);
        row.print(name, scene.placedTriangleCount());
        total.beams += row.beams, total.hits += row.hits, total.missed += row.missed, total.ties += row.ties;
        total.falseHits += row.falseHits, total.wrongOwner += row.wrongOwner, total.wrongRange += row.wrongRange;
        total.worst = std::max(total.worst, row.worst);
        triangles += scene.placedTriangleCount();
        ++scenes;
      } catch (const Error& error) {
        if (error.code() != ErrorCode::format && error.code() != ErrorCode::file) throw;
        std::printf("%-60.60s refused: %s\n", name.c_str(), error.what());
        ++refused;
      }
    }
  total.print(std::to_string(scenes) + " scenes, " + std::to_string(refused) + " refused", triangles);
  return total.same() && scenes > 0 ? 0 : 1;
}
