// SPDX-License-Identifier: Apache-2.0
#include "pipeline/beam_sets.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <utility>

#include "base/limits.hpp"
#include "pipeline/beam_cells.hpp"
#include "pipeline/beam_places.hpp"
#include "pipeline/resolve_words.hpp"

namespace gnosphere {
namespace {

using gpu::Array;

std::vector<BeamTables> tablesOf(const SensorPlan& plan, std::span<const FiredGroup> groups, float steepest) {
  std::vector<BeamTables> all;
  if (plan.listed)
    all = makeListedTables(plan.sensor, groups, !plan.motion());
  else
    all = {plan.rows ? makeRowTables(plan.sensor, *plan.rows, *groups[0].group) : makeBeamTables(plan.sensor)};
  const bool apart = std::ranges::any_of(groups, [](const FiredGroup& of) { return of.group->lasers.distance > 0; });
  for (BeamTables& tables : all) {
    tables.apart = apart;
    tables.frame.footprint = plan.spread.angle;
    tables.frame.spreadAcross = plan.spread.across;
    tables.frame.spreadUp = plan.spread.up;
    tables.frame.steepest = steepest + plan.spread.up + gpu::kKeySlack;
    if (tables.listed || !plan.motion()) continue;
    for (const gpu::Row& row : tables.rows) {
      const Vec3 &at = plan.sensor.channels[row.channel].origin, &centre = groups[0].group->lasers.centre;
      tables.rowOrigins.push_back(
          {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z - centre.z), 0});
    }
  }
  return all;
}

}  // namespace

BeamSets makeBeamSets(const SensorPlan& plan) {
  struct Member {
    size_t pattern;
    OriginGroup group;
  };
  BeamSets result;
  result.patterns.resize(std::max<size_t>(plan.sensor.patterns.size(), 1));
  const double tangent = steepestTangent(plan.sensor);
  const auto steepest = static_cast<float>(tangent / (1 + tangent));  // the largest elevation key
  std::map<size_t, std::vector<Member>> bySize;
  for (size_t i = 0; i < result.patterns.size(); ++i)
    for (OriginGroup& group : originGroups(plan.sensor, i)) {
      const size_t octave = std::bit_width(group.beams.size() + group.silent.size());
      bySize[octave].push_back({i, std::move(group)});
    }
  for (const auto& [octave, members] : bySize) {
    std::vector<FiredGroup> fired;
    for (const Member& member : members) {
      result.patterns[member.pattern].push_back(
          {member.group.lasers, static_cast<uint32_t>(result.sets.size()), static_cast<uint32_t>(fired.size())});
      fired.push_back({member.pattern, &member.group});
    }
    result.sets.push_back(tablesOf(plan, fired, steepest));
  }
  return result;
}

std::vector<ArrayContent> arraysOf(const SensorPlan& plan, std::span<const BeamTables> set) {
  std::vector<ArrayContent> arrays;
  const BeamTables& first = set[0];
  const auto put = [&]<typename T>(Array array, const std::vector<T>& content) {
    if (content.size() > limits::kEntries.most)
      throw Error(ErrorCode::outOfMemory, "the beams of sensor '" + plan.sensor.name +
                                              "' start from too many places: '" + gpu::nameOf(array) +
                                              "' has more entries than kernels can address");
    arrays.push_back(arrayOf(array, content));
  };
  const auto putAll = [&]<typename T>(Array array, std::vector<T> BeamTables::*member) {
    std::vector<T> all;
    for (const BeamTables& tables : set) all.insert(all.end(), (tables.*member).begin(), (tables.*member).end());
    put(array, all);
  };
  // The same for values of beams, of which a table may have fewer than others.
  const auto putBeams = [&]<typename T>(Array array, std::vector<T> BeamTables::*member, const T& none = {}) {
    std::vector<T> all;
    for (const BeamTables& tables : set) {
      all.insert(all.end(), (tables.*member).begin(), (tables.*member).end());
      if (tables.listed) all.resize((size_t{tables.frame.table} + 1) * tables.frame.beams, none);
    }
    put(array, all);
  };
  putAll(Array::rowLookup, &BeamTables::rowLookup);
  put(Array::columns, first.columns);
  put(Array::rows, first.rows);
  if (!first.numbers.empty()) putBeams(Array::beamNumbers, &BeamTables::numbers, gpu::kNone);
  if (!first.ranges.empty()) putBeams(Array::beamRanges, &BeamTables::ranges);
  if (!first.startFarthest.empty() && set.size() == 1) put(Array::startFarthest, first.startFarthest);
  if (first.holes) {
    std::vector<Word> words(first.numbers.size(), {gpu::kNone, gpu::kNone});
    for (size_t i = 0; i < words.size(); ++i)
      if (first.numbers[i] == gpu::kNone) words[i] = {0, 0};
    put(Array::startWords, words);
  }
  if (!first.rowOrigins.empty()) put(Array::rowOrigins, first.rowOrigins);
  if (!first.listed) return arrays;
  putAll(Array::cellStarts, &BeamTables::cellStarts);
  putBeams(Array::beamAngles, &BeamTables::angles);
  if (!plan.motion()) return arrays;
  putBeams(Array::beamOrigins, &BeamTables::origins);
  putAll(Array::sliceMasks, &BeamTables::sliceMasks);
  if (!plan.moves()) return arrays;
  putBeams(Array::timedBeams, &BeamTables::timedBeams);
  putAll(Array::timedStarts, &BeamTables::timedStarts);
  return arrays;
}

ArrayContent viewTables(std::span<const View> views) {
  std::vector<std::array<uint32_t, 2>> content;
  for (const View& view : views)
    content.push_back({view.group->table, static_cast<uint32_t>(view.shot - views[0].shot)});
  return arrayOf(Array::viewTables, content);
}

ArrayContent startFarthest(std::span<const BeamTables* const> views) {
  std::vector<uint32_t> content;
  for (const BeamTables* tables : views)
    content.insert(content.end(), tables->startFarthest.begin(), tables->startFarthest.end());
  return arrayOf(Array::startFarthest, content);
}

}  // namespace gnosphere
