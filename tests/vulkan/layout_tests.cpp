// SPDX-License-Identifier: Apache-2.0
// Shared structs are compiled as C++ and as GLSL: every member must have the same offset in every SPIR-V module as in
// C++. No module may need a feature that vulkan/device.cpp does not require.
#include <catch2/catch_test_macros.hpp>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/effects/parameters.h"
#include "common/shared.h"
#include "folder.hpp"

namespace {

using namespace gnosphere::gpu;

/// Layout of a struct in one of the two languages.
struct Layout {
  size_t size = 0;  ///< distance of neighbours in an array; 0: no array uses it
  std::map<std::string, size_t> offsets;
};
using Layouts = std::map<std::string, Layout>;

// STRUCT(type, a, b) becomes {"type", {sizeof(type), {{"a", offsetof(type, a)}, {"b", offsetof(type, b)}}}}. A macro
// cannot expand itself, so MEMBER names itself indirectly by AGAIN, and EXPAND rescans the result more than 64 times.
#define NOTHING()
#define MEMBER(type, member, ...) {#member, offsetof(type, member)}, __VA_OPT__(AGAIN NOTHING()()(type, __VA_ARGS__))
#define AGAIN() MEMBER
#define EXPAND(...) EXPAND3(EXPAND3(EXPAND3(EXPAND3(__VA_ARGS__))))
#define EXPAND3(...) EXPAND2(EXPAND2(EXPAND2(EXPAND2(__VA_ARGS__))))
#define EXPAND2(...) EXPAND1(EXPAND1(EXPAND1(EXPAND1(__VA_ARGS__))))
#define EXPAND1(...) __VA_ARGS__
#define STRUCT(type, ...)                 \
  {                                       \
#type, {                              \
      sizeof(type), {                     \
        EXPAND(MEMBER(type, __VA_ARGS__)) \
      }                                   \
    }                                     \
  }

/// Every struct of common/shared.h and common/effects/parameters.h that is stored in buffers. A module with another
/// struct fails the test.
const Layouts kShared = {
    STRUCT(Instance, row0, row1, row2, offset, firstTriangle),
    STRUCT(Deformer, joints, targets, deformed, vertices, vertexFirst, restFirst, offsetFirst, weightFirst, rowFirst,
           clusterFirst, bonesFirst, padding, morphLow, morphHigh),
    STRUCT(ClusterBones, first, count, weightFirst, influences),
    STRUCT(Cluster, low, vertexFirst, high, triangleFirst, coneAxis, cone, vertexCount, triangleCount, doubleSided,
           material),
    STRUCT(Group, low, clusterFirst, high, clusterCount),
    STRUCT(CallerBuffer, memory),
    STRUCT(RecordBuffers, records, header),
    STRUCT(VertexSource, scale, stride, offset, format, numberFirst, vertexFirst),
    STRUCT(TransformSource, row0, row1, row2, row0Low, row1Low, row2Low, shift, shiftLow, stride, byColumns),
    STRUCT(TransformedInstance, origin, originLow, instance, source, number),
    STRUCT(TaggedCorner, corner, tag),
    STRUCT(Cover, farthest, lowRays, highRays, links),
    STRUCT(SurfaceRecord, normal, material),
    STRUCT(SignalRecord, trueRange, width, word),
    STRUCT(Frame, columns, rows, beams, rangeMin, rangeMax, columnsPerRadian, columnSlack, projectedCapacity,
           tileCapacity, candidateCapacity, paperFirstElevation, paperRowsPerRadian, shiftMin, shiftMax, beside,
           momentsBefore, momentsAfter, stretch, footprint, slabShift, cullWorkgroups, triangleWorkgroups,
           shellClusters, shellHint, spreadAcross, spreadUp, hasBeamRanges, hidesNear, steepest, phase, shellCount,
           slabFirst, slabCount, beamColumnFirst, beamColumnCount, views, moments, scanBeams, table, lookupCells),
    STRUCT(Row, angles, channel, azimuths, first, lag, behind),
    STRUCT(Counters, projectedSmall, projectedLarge, tiles, candidates, binnedSmall, binnedTiles, hits, triangles,
           nonFinite, culledByRange, culledByFace, culledBetweenBeams, culledHidden, integerSides, integerRanges,
           causes, lostEchoes, ownLinks, hardBeams, edgeBeams, paneBeams, boxedBeams, tried, alive),
    STRUCT(RecordPlace, first, stride),
    STRUCT(InstanceClass, classId, firstRun, runs),
    STRUCT(ClassRun, firstTriangle, classId),
    STRUCT(RecordPlan, entries, capacity, organised, streams, gaps, classes, directions, frame, continues, firstBeam),
    STRUCT(RecordStream, start, stride, firstValue, values, column),
    STRUCT(RecordValue, value, type, offset),
    STRUCT(Workgroups, x, y, z),
    STRUCT(Shell, end, groups, visible, visibleBehind, nextCluster, nextSlab, laterRowsDown, laterRowsUp, clusterWork,
           triangleWork, binWork),
    STRUCT(Shells, of, clusters),
    STRUCT(Pass, placedFirst, placedCount, shell, last, occluders, table, firstGroup, groups, clusters),
    STRUCT(InstanceMotion, row0, row1, row2, bound),
    STRUCT(ColumnMotion, row0, row1, row2, report0, report1, report2, velocity, spin, bends),
    STRUCT(BeamFrame, forward, left, up),
    STRUCT(MotionBounds, shift, turn, shiftPerColumn, turnPerColumn, origins, forward, left, up, secondsPerColumn,
           seconds, instances, sensor, middle, columnsToMiddle, drift, wander, wanderPerColumn, bendShift, bendTurn,
           bendFirst, bendEnd),
    STRUCT(Particles, countsNear, countsFar, startsNear, startsFar, endsNear, endsFar, firstRange, lastRange, excess,
           reflectance, least, padding0, padding1, padding2),
    STRUCT(EffectParameters, rain, snow, seedLow, seedHigh, sensor, frame, volumeCount, deadBeams, returnsMode,
           returnsPerBeam, intensityModel, intensityScale, angleNoiseAt, attenuation, threshold, softness, dropRate,
           dropLimit, dropSlope, dropAtZero, rangeBias, rangeSigma, rangeSigmaPerMetre, rangeStep, azimuthSigma,
           elevationSigma, intensitySigma, extinction, fogExtinction, fogScatter, separation, pulseWidth,
           cellHorizontal, cellVertical, spreadHorizontal, spreadVertical, rangeMin, rangeMax, hidesNear, speedSigma,
           rangeSigmaPerSquareMetre, rangeSigmaAtThreshold),
    STRUCT(Optics4, reflection, passage, alphaImage),
    STRUCT(VolumeBox, row0, row1, row2, extinction, scatter, padding0, padding1),
    STRUCT(Echo, range, energy, width, light, index),
    STRUCT(Return, range, trueRange, intensity, width, label, echo, number, count, cause),
};

/// The structs that a SPIR-V module stores in buffers, without the enclosing blocks. A module has five header words,
/// then instructions; the first word of each holds its length and its opcode.
Layouts layoutsIn(const std::vector<uint32_t>& words) {
  std::map<uint32_t, std::string> names;
  std::map<uint32_t, std::map<uint32_t, std::string>> members;
  std::map<uint32_t, std::map<uint32_t, uint32_t>> offsets;  // struct -> member -> bytes
  std::map<uint32_t, uint32_t> elements, strides;            // array -> type of its elements, bytes
  std::set<uint32_t> blocks;
  for (size_t at = 5; at < words.size(); at += words[at] >> 16) {
    const uint32_t* word = &words[at];
    const auto text = [&](size_t first) { return std::string(reinterpret_cast<const char*>(word + first)); };
    switch (word[0] & 0xffff) {
      case 5: names[word[1]] = text(2); break;             // OpName
      case 6: members[word[1]][word[2]] = text(3); break;  // OpMemberName
      case 28:                                             // OpTypeArray
      case 29: elements[word[1]] = word[2]; break;         // OpTypeRuntimeArray
      case 71:                                             // OpDecorate
        if (word[2] == 2) blocks.insert(word[1]);          // Block
        if (word[2] == 6) strides[word[1]] = word[3];      // ArrayStride
        break;
      case 72:
        if (word[3] == 35) offsets[word[1]][word[2]] = word[4];  // OpMemberDecorate ... Offset
        break;
      default: break;
    }
  }
  Layouts layouts;
  for (const auto& [type, bytes] : offsets)
    if (!blocks.contains(type))
      for (const auto& [member, offset] : bytes) layouts[names[type]].offsets[members[type][member]] = offset;
  for (const auto& [array, stride] : strides)
    if (const auto found = layouts.find(names[elements[array]]); found != layouts.end()) found->second.size = stride;
  return layouts;
}

/// Lists the differences between a module's struct and C++, one per line.
std::string differences(const Layout& cpp, const Layout& shader) {
  std::string text;
  if (shader.size != 0 && shader.size != cpp.size)
    text += "  its size is " + std::to_string(shader.size) + ", in C++ " + std::to_string(cpp.size) + "\n";
  for (const auto& [member, offset] : shader.offsets) {
    const auto found = cpp.offsets.find(member);
    if (found == cpp.offsets.end())
      text += "  " + member + " is not in the table of layout_tests.cpp\n";
    else if (found->second != offset)
      text +=
          "  " + member + " is at " + std::to_string(offset) + ", in C++ at " + std::to_string(found->second) + "\n";
  }
  for (const auto& [member, offset] : cpp.offsets)
    if (!shader.offsets.contains(member)) text += "  " + member + " is not in the shader\n";
  return text;
}

using Words = std::vector<uint32_t>;

/// Calls use(file, words) for every SPIR-V module of the build.
template <typename Use>
void forEachModule(const Use& use) {
  std::ifstream list(GNOSPHERE_SPIRV_LIST);
  size_t modules = 0;
  for (std::string file; std::getline(list, file); ++modules) {
    const std::string bytes = gnosphere::test::bytesOf(file);
    Words words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), 4 * words.size());
    INFO(file);
    REQUIRE(words.size() > 5);
    REQUIRE(words[0] == 0x07230203);
    use(std::filesystem::path(file).stem().string(), words);
  }
  CHECK(modules > 10);
}

}  // namespace

TEST_CASE("shared structs have the same layout on the host and in every shader") {
  std::set<std::string> seen;
  forEachModule([&](const std::string&, const Words& words) {
    for (const auto& [name, layout] : layoutsIn(words)) {
      seen.insert(name);
      const auto shared = kShared.find(name);
      if (shared == kShared.end()) {
        FAIL_CHECK(name << " is not in the table of layout_tests.cpp");
      } else if (const std::string text = differences(shared->second, layout); !text.empty()) {
        FAIL_CHECK(name << ":\n" << text);
      }
    }
  });
  for (const auto& [name, layout] : kShared) {
    INFO(name << " is in no shader");
    CHECK(seen.contains(name));
  }
}

TEST_CASE("the shaders need only features that a device must have") {
  // The capabilities are Shader; GroupNonUniform with Vote, Arithmetic, Ballot and Shuffle;
  // PhysicalStorageBufferAddresses.
  const std::set<uint32_t> always = {1, 61, 62, 63, 64, 65, 5347};
  const std::set<uint32_t> ofInt64 = {11, 12}, ofFloat64 = {10};
  forEachModule([&](const std::string& name, const Words& words) {
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
  });
}
