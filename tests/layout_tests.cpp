// SPDX-License-Identifier: Apache-2.0
// shared.h is compiled as C++ and as GLSL: the offsets that the SPIR-V carries must be those of the C++ structs. And
// the SPIR-V must not need what vulkan/device.cpp does not ask a device for.
#include <catch2/catch_test_macros.hpp>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "bin.spv.h"
#include "effects/parameters.h"
#include "every_formula.spv.h"
#include "project_clusters.spv.h"
#include "project_groups.spv.h"
#include "project_triangles.spv.h"
#include "resolve.spv.h"
#include "shared.h"

namespace {

using Offsets = std::map<std::string, uint32_t>;  // "Struct.member" -> bytes

// SPIR-V: five header words, then instructions; the first word of each is its length above its opcode.
Offsets offsetsIn(std::span<const uint32_t> words) {
  std::map<uint32_t, std::string> types;
  std::map<std::pair<uint32_t, uint32_t>, std::string> members;
  Offsets offsets;
  for (size_t at = 5; at < words.size(); at += words[at] >> 16) {
    const uint32_t* word = &words[at];
    const auto text = [&](size_t first) { return std::string(reinterpret_cast<const char*>(word + first)); };
    switch (word[0] & 0xffff) {
      case 5: types[word[1]] = text(2); break;               // OpName
      case 6: members[{word[1], word[2]}] = text(3); break;  // OpMemberName
      case 72:                                               // OpMemberDecorate ... Offset
        if (word[3] == 35) offsets[types[word[1]] + "." + members[{word[1], word[2]}]] = word[4];
        break;
      default: break;
    }
  }
  return offsets;
}

}  // namespace

TEST_CASE("the structs of shared.h have the same layout on the host and in every shader") {
  using namespace gnosphere::gpu;
  const Offsets expected = {
      {"Instance.row0", offsetof(Instance, row0)},
      {"Instance.row2", offsetof(Instance, row2)},
      {"Instance.offset", offsetof(Instance, offset)},
      {"Cluster.low", offsetof(Cluster, low)},
      {"Cluster.high", offsetof(Cluster, high)},
      {"Frame.beams", offsetof(Frame, beams)},
      {"Frame.rangeMin", offsetof(Frame, rangeMin)},
      {"Frame.columnSlack", offsetof(Frame, columnSlack)},
      {"Frame.projectedCapacity", offsetof(Frame, projectedCapacity)},
      {"Frame.candidateCapacity", offsetof(Frame, candidateCapacity)},
      {"Frame.paperRowsPerRadian", offsetof(Frame, paperRowsPerRadian)},
      {"Row.angles", offsetof(Row, angles)},
      {"Row.offset", offsetof(Row, offset)},
      {"Counters.projectedSmall", offsetof(Counters, projectedSmall)},
      {"Counters.tiles", offsetof(Counters, tiles)},
      {"Counters.candidates", offsetof(Counters, candidates)},
      {"Counters.hits", offsetof(Counters, hits)},
      {"Counters.culledBetweenBeams", offsetof(Counters, culledBetweenBeams)},
      {"Group.high", offsetof(Group, high)},
      {"Frame.shiftMax", offsetof(Frame, shiftMax)},
      {"Counters.visibleGroups", offsetof(Counters, visibleGroups)},
      {"Counters.nextSlab", offsetof(Counters, nextSlab)},
      {"Pass.placedFirst", offsetof(Pass, placedFirst)},
      {"Pass.placedCount", offsetof(Pass, placedCount)},
      {"Pass.occluders", offsetof(Pass, occluders)},
      {"Particles.slope", offsetof(Particles, slope)},
      {"EffectParameters.snow", offsetof(EffectParameters, snow)},
      {"EffectParameters.seedLow", offsetof(EffectParameters, seedLow)},
      {"EffectParameters.returnsMode", offsetof(EffectParameters, returnsMode)},
      {"EffectParameters.dropRate", offsetof(EffectParameters, dropRate)},
      {"EffectParameters.fogExtinction", offsetof(EffectParameters, fogExtinction)},
      {"EffectParameters.rangeMax", offsetof(EffectParameters, rangeMax)},
      {"Optics4.passage", offsetof(Optics4, passage)},
      {"VolumeBox.extinction", offsetof(VolumeBox, extinction)},
      {"Echo.index", offsetof(Echo, index)},
      {"Return.count", offsetof(Return, count)},
  };
  std::map<std::string, int> seen;
  for (const Offsets& offsets : {offsetsIn(project_groups), offsetsIn(project_clusters), offsetsIn(project_triangles),
                                 offsetsIn(bin), offsetsIn(resolve), offsetsIn(every_formula)})
    for (const auto& [member, offset] : offsets)
      if (const auto found = expected.find(member); found != expected.end()) {
        INFO(member);
        CHECK(offset == found->second);
        ++seen[member];
      }
  for (const auto& [member, offset] : expected) {
    INFO(member << " is in no shader");
    CHECK(seen[member] > 0);
  }
}

TEST_CASE("the shaders need nothing that a device is not asked for") {
  // Shader, GroupNonUniform with Vote, Arithmetic, Ballot and Shuffle.
  const std::set<uint32_t> always = {1, 61, 62, 63, 64, 65};
  const std::set<uint32_t> ofInt64 = {11, 12}, ofFloat64 = {10};
  size_t modules = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GNOSPHERE_SHADERS)) {
    if (entry.path().extension() != ".spv") continue;
    const std::string name = entry.path().stem().string();
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    std::vector<uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), 4 * words.size());
    ++modules;
    for (size_t at = 5; at < words.size(); at += words[at] >> 16) {
      const uint32_t* word = &words[at];
      if ((word[0] & 0xffff) == 17) {  // OpCapability
        INFO(name << " needs capability " << word[1]);
        CHECK((always.contains(word[1]) || (name.find("int64") != name.npos && ofInt64.contains(word[1])) ||
               (name.find("float64") != name.npos && ofFloat64.contains(word[1]))));
      }
      if ((word[0] & 0xffff) == 16 && word[2] == 17) {  // OpExecutionMode ... LocalSize
        INFO(name << " has workgroups of " << word[3] << " x " << word[4] << " x " << word[5]);
        CHECK((word[3] == 64 && word[4] == 1 && word[5] == 1));
      }
    }
  }
  CHECK(modules > 10);
}
