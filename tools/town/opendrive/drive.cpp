// SPDX-License-Identifier: Apache-2.0
#include "town/opendrive/drive.hpp"

#include <algorithm>
#include <cmath>

#include "gnosphere/error.hpp"

namespace gnosphere::town::opendrive {
namespace {

/// A lane of one section, with its driving direction.
struct Stretch {
  const Road* road;
  size_t section;
  int lane;
  bool forward;

  double length() const { return road->sections[section].end - road->sections[section].s; }
  const Lane& get() const { return *road->sections[section].find(lane); }
};

class Search {
 public:
  Search(const Network& network, uint32_t seed, double metres) : network_(network), dice_(seed, 31), metres_(metres) {}

  /// Returns whether a path of that many metres starts here; the longest path found is kept in any case.
  bool from(const Stretch& start) {
    way_ = {start};
    length_ = start.length();
    patience_ = 20'000;
    return goOn();
  }
  const std::vector<Stretch>& longest() const { return longest_; }

 private:
  bool goOn() {
    if (length_ > longestLength_) {
      longestLength_ = length_;
      longest_ = way_;
    }
    if (length_ >= metres_) return true;
    if (--patience_ < 0 || way_.size() > 5'000) return false;
    std::vector<Stretch> choices = next(way_.back());
    while (!choices.empty()) {
      const auto choice = choices.begin() + dice_.below(static_cast<int>(choices.size()));
      way_.push_back(*choice);
      length_ += choice->length();
      choices.erase(choice);
      if (goOn()) return true;
      length_ -= way_.back().length();
      way_.pop_back();
    }
    return false;
  }

  void addIfDriven(std::vector<Stretch>& list, const Road* road, bool atStart, std::optional<int> lane) const {
    if (!road || !lane) return;
    const Stretch stretch = {road, atStart ? 0 : road->sections.size() - 1, *lane, atStart};
    const Lane* found = road->sections[stretch.section].find(*lane);
    if (found && found->driving) list.push_back(stretch);
  }

  std::vector<Stretch> next(const Stretch& here) const {
    std::vector<Stretch> list;
    const Road& road = *here.road;
    const std::optional<int> linked = here.forward ? here.get().successor : here.get().predecessor;
    const bool isLast = here.forward ? here.section + 1 == road.sections.size() : here.section == 0;
    if (!isLast) {
      const size_t section = here.forward ? here.section + 1 : here.section - 1;
      const int lane = linked.value_or(here.lane);
      const Lane* found = road.sections[section].find(lane);
      if (found && found->driving) list.push_back({&road, section, lane, here.forward});
      return list;
    }
    const RoadLink& link = here.forward ? road.successor : road.predecessor;
    if (link.kind == RoadLink::road) addIfDriven(list, network_.road(link.id), link.atStart, linked);
    const Junction* junction = link.kind == RoadLink::junction ? network_.junction(link.id) : nullptr;
    if (!junction) return list;
    for (const Connection& connection : junction->connections)
      for (const LaneLink& lanes : connection.lanes)
        if (connection.incoming == road.id && lanes.from == here.lane)
          addIfDriven(list, network_.road(connection.connecting), connection.atStart, lanes.to);
    return list;
  }

  const Network& network_;
  Dice dice_;
  double metres_;
  std::vector<Stretch> way_, longest_;
  double length_ = 0, longestLength_ = 0;
  int patience_ = 0;
};

WayPoint pointOf(const Stretch& stretch, double s) {
  const LaneSection& section = stretch.road->sections[stretch.section];
  const size_t index = static_cast<size_t>(section.find(stretch.lane) - section.lanes.data());
  const LaneMiddle middle = laneMiddle(*stretch.road, section, index, s);
  return {middle.at, middle.up};
}

void addPoints(const Stretch& stretch, std::vector<WayPoint>& points) {
  constexpr double kStep = 0.5;
  const LaneSection& section = stretch.road->sections[stretch.section];
  const int count = std::max(1, static_cast<int>(std::ceil(stretch.length() / kStep)));
  for (int i = 0; i <= count; ++i) {
    const double share = static_cast<double>(stretch.forward ? i : count - i) / count;
    const WayPoint p = pointOf(stretch, section.s + share * stretch.length());
    if (!points.empty()) {
      const Vec3 step = p.at - points.back().at;
      if (dot(step, step) < 0.01 * kStep * kStep) continue;
    }
    points.push_back(p);
  }
}

/// Returns every drivable lane in the direction of its traffic, the nearest to the origin first.
std::vector<Stretch> starts(const Network& network) {
  std::vector<std::pair<double, Stretch>> list;
  for (const Road& road : network.roads)
    for (size_t i = 0; road.junction.empty() && i < road.sections.size(); ++i)
      for (const Lane& lane : road.sections[i].lanes) {
        const bool forward = road.isForward(lane);
        const Stretch stretch = {&road, i, lane.id, forward};
        if (!lane.driving || stretch.length() <= 0) continue;
        const Vec3 p = pointOf(stretch, forward ? road.sections[i].s : road.sections[i].end).at;
        list.push_back({p.x * p.x + p.y * p.y, stretch});
      }
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Stretch> sorted;
  for (const auto& [distance, stretch] : list) sorted.push_back(stretch);
  return sorted;
}

}  // namespace

Drive planDrive(const Network& network, uint32_t seed, double metres) {
  constexpr int kTries = 50;
  Search search(network, seed, metres);
  int tries = 0;
  for (const Stretch& start : starts(network))
    if (search.from(start) || ++tries == kTries) break;
  Drive drive;
  for (const Stretch& stretch : search.longest()) {
    addPoints(stretch, drive.points);
    drive.lanes.insert({stretch.road->id, stretch.lane});
  }
  if (drive.points.size() < 2)
    throw Error(ErrorCode::format, network.file + ": no road has a driving lane, or none that is 5 cm long");
  return drive;
}

}  // namespace gnosphere::town::opendrive
