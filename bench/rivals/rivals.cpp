// SPDX-License-Identifier: Apache-2.0
#include "rivals/rivals.hpp"

#include <algorithm>
#include <sstream>

#include "console.hpp"
#include "gnosphere/error.hpp"
#include "rivals/embree.hpp"

namespace gnosphere::bench {
namespace {

using Rivals = std::vector<std::unique_ptr<Rival>>;

/// Beyond this many placed triangles one tree over all of them is not tried: it would take more than 5 GB.
constexpr uint64_t kFlatTriangles = 30'000'000;

void addEmbree(const RivalSetting& setting, Rivals& rivals, std::vector<std::string>& notes) {
  std::vector<EmbreeWay> ways = {EmbreeWay::flat, EmbreeWay::instanced};
  if (setting.motion == Motion::transforms) ways = {EmbreeWay::placed};
  if (setting.motion == Motion::everything) ways = {EmbreeWay::rebuilt, EmbreeWay::refitted, EmbreeWay::placed};
  for (EmbreeWay way : ways) {
    const bool flat = way != EmbreeWay::instanced && way != EmbreeWay::placed;
    if (flat && setting.scene.placedTriangleCount() > kFlatTriangles)
      notes.push_back("embree: one tree over more than " + cli::grouped(kFlatTriangles) + " triangles is not tried");
    else
      rivals.push_back(makeEmbree(setting.scene, setting.origin, way));
  }
}

struct Entry {
  const char* name;
  void (*add)(const RivalSetting&, Rivals&, std::vector<std::string>& notes);
};

constexpr Entry kRivals[] = {{"embree", addEmbree}};

}  // namespace

std::vector<std::string> parseRivals(const std::string& text) {
  std::vector<std::string> known, names;
  for (const Entry& entry : kRivals) known.emplace_back(entry.name);
  if (text == "all") return known;
  if (text == "none") return {};
  std::istringstream stream(text);
  for (std::string name; std::getline(stream, name, ',');) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      std::string list;
      for (const std::string& other : known) list += ", " + other;
      throw Error(ErrorCode::invalidArgument, "--rivals: there is no '" + name + "'; there are all, none" + list);
    }
    names.push_back(name);
  }
  return names;
}

Rivals makeRivals(const std::vector<std::string>& names, const RivalSetting& setting, std::vector<std::string>& notes) {
  Rivals rivals;
  for (const Entry& entry : kRivals) {
    if (std::find(names.begin(), names.end(), entry.name) == names.end()) continue;
    try {
      entry.add(setting, rivals, notes);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::device && error.code() != ErrorCode::outOfMemory) throw;
      notes.emplace_back(error.what());
    }
  }
  return rivals;
}

}  // namespace gnosphere::bench
