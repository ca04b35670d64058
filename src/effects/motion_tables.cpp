// SPDX-License-Identifier: Apache-2.0
#include "effects/motion_tables.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/pose.hpp"

namespace gnosphere {
namespace {

/// A map from a frame to the world: p' = turn p + place.
struct Frame {
  glm::dquat quaternion;
  glm::dmat3 turn;
  glm::dvec3 place;

  explicit Frame(const Pose& pose)
      : quaternion(rotationOf(pose)), turn(glm::mat3_cast(quaternion)), place(positionOf(pose)) {}
};

/// A map between two frames: p' = turn p + shift.
struct Map {
  glm::dmat3 turn = glm::dmat3(1);
  glm::dvec3 shift = glm::dvec3(0);

  Map() = default;
  Map(const Frame& from, const Frame& to)
      : turn(glm::transpose(to.turn) * from.turn), shift(glm::transpose(to.turn) * (from.place - to.place)) {}
};

/// Writes a map between frames as the three rows of its matrix: rotation, then shift.
void write(const Map& map, gpu::vec4& row0, gpu::vec4& row1, gpu::vec4& row2) {
  gpu::vec4* rows[] = {&row0, &row1, &row2};
  for (int r = 0; r < 3; ++r)
    *rows[r] = {static_cast<float>(map.turn[0][r]), static_cast<float>(map.turn[1][r]),
                static_cast<float>(map.turn[2][r]), static_cast<float>(map.shift[r])};
}

/// Writes the map from a frame to a parallel one as three rows.
void write(const Vec3& shift, gpu::vec4& row0, gpu::vec4& row1, gpu::vec4& row2) {
  row0 = {1, 0, 0, static_cast<float>(shift.x)};
  row1 = {0, 1, 0, static_cast<float>(shift.y)};
  row2 = {0, 0, 1, static_cast<float>(shift.z)};
}

}  // namespace

Pose movedTo(const Vec3& point, const Pose& pose) {
  const glm::dvec3 offset = Frame(pose).turn * glm::dvec3(point.x, point.y, point.z);
  return {{pose.position.x + offset.x, pose.position.y + offset.y, pose.position.z + offset.z}, pose.orientation};
}

namespace {

double angleBetween(const Frame& a, const Frame& b) {
  const glm::dquat difference = glm::conjugate(a.quaternion) * b.quaternion;
  return 2 * std::asin(std::min(1.0, glm::length(glm::dvec3(difference.x, difference.y, difference.z))));
}

/// The largest second differences of a series of maps and their sums, with the numbers of the first map and of the one
/// after the last.
class Bend {
 public:
  void add(uint32_t number, const Map& map) {
    if (count_ == 0) first = number;
    end = number + 1;
    if (count_ >= 2) {
      const glm::dmat3 difference = map.turn - 2.0 * last_[1].turn + last_[0].turn;
      double squares = 0;
      for (int c = 0; c < 3; ++c) squares += glm::dot(difference[c], difference[c]);
      const double turned = std::sqrt(squares),
                   shifted = glm::length(map.shift - 2.0 * last_[1].shift + last_[0].shift);
      turn = std::max(turn, turned);
      shift = std::max(shift, shifted);
      allTurns += turned;
      allShifts += shifted;
    }
    last_[0] = last_[1];
    last_[1] = map;
    ++count_;
  }

  double shift = 0, turn = 0;
  double allShifts = 0, allTurns = 0;  // the sums
  uint32_t first = 0, end = 0;

 private:
  Map last_[2];
  size_t count_ = 0;
};

/// A steady motion, and by how much another motion differs from it.
struct Drift {
  glm::dvec3 perColumn = glm::dvec3(0);
  double wander = 0, wanderPerColumn = 0;
};

/// Compares the places of the columns with a steady motion that is at 0 after `toMiddle` columns.
Drift driftOf(const std::vector<glm::dvec3>& places, double toMiddle) {
  Drift drift;
  if (places.size() > 1) drift.perColumn = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
  for (size_t i = 0; i < places.size(); ++i) {
    const glm::dvec3 steady = (static_cast<double>(i) - toMiddle) * drift.perColumn;
    drift.wander = std::max(drift.wander, glm::length(places[i] - steady));
    if (i > 0)
      drift.wanderPerColumn = std::max(drift.wanderPerColumn, glm::length(places[i] - places[i - 1] - drift.perColumn));
  }
  return drift;
}

/// The largest distances and angles between the frames of columns and the middle one, and between consecutive frames.
class Extent {
 public:
  explicit Extent(const Frame& middle) : middle_(middle), before_(middle) {}

  void add(const Frame& frame) {
    shift = std::max(shift, glm::length(frame.place - middle_.place));
    turn = std::max(turn, angleBetween(frame, middle_));
    if (!places.empty()) {
      shiftPerColumn = std::max(shiftPerColumn, glm::length(frame.place - before_.place));
      turnPerColumn = std::max(turnPerColumn, angleBetween(frame, before_));
    }
    places.push_back(frame.place - middle_.place);
    before_ = frame;
  }

  double shift = 0, turn = 0, shiftPerColumn = 0, turnPerColumn = 0;
  std::vector<glm::dvec3> places;  // relative to the middle

 private:
  Frame middle_, before_;
};

/// Writes the velocity and the angular velocity of the lasers' centre at a time, in the frame `now` of its column.
void writeSpeeds(const SensorMotion& motion, const Frame& now, const Vec3& centre, double time,
                 gpu::ColumnMotion& column) {
  const Vec3 v = velocityAt(motion, time), w = angularVelocityAt(motion, time);
  const glm::dvec3 spin(w.x, w.y, w.z);
  const glm::dvec3 velocity =
      glm::transpose(now.turn) * glm::dvec3(v.x, v.y, v.z) + glm::cross(spin, glm::dvec3(centre.x, centre.y, centre.z));
  column.velocity = {static_cast<float>(velocity.x), static_cast<float>(velocity.y), static_cast<float>(velocity.z),
                     static_cast<float>(time)};
  column.spin = {static_cast<float>(spin.x), static_cast<float>(spin.y), static_cast<float>(spin.z), 0};
}

}  // namespace

MotionTables makeMotionTables(const ScanTimes& times, const OriginBounds& lasers, const Shot& shot, bool simulated,
                              bool deskew) {
  const bool moves = simulated && !shot.motion.stamps.empty();
  const auto poseOf = [&](double time) { return moves ? poseAt(shot.motion, shot.pose, time) : shot.pose; };
  MotionTables tables;
  tables.middle = movedTo(lasers.centre, poseOf(times.middle));
  const Frame middle(tables.middle), standing(shot.pose);
  Extent extent(middle);
  Bend bend;
  Frame now = middle;
  gpu::ColumnMotion column = {};
  tables.columns.reserve(times.count);
  for (uint32_t i = 0; i < times.used; ++i) {
    const double time = times.at(i);
    if (!moves && i == 0) {  // without the pose and its rounding, so that all views share the tables
      write({0, 0, 0}, column.row0, column.row1, column.row2);
      write(lasers.centre, column.report0, column.report1, column.report2);
    } else if (moves) {
      const Pose pose = poseOf(time);
      now = Frame(movedTo(lasers.centre, pose));
      const Map seen(middle, now);
      const auto& stamps = shot.motion.stamps;
      if (time >= stamps.front().time && time <= stamps.back().time) bend.add(i, seen);
      write(seen, column.row0, column.row1, column.row2);
      write({now, deskew ? standing : Frame(pose)}, column.report0, column.report1, column.report2);
    }
    writeSpeeds(shot.motion, now, lasers.centre, time, column);
    column.bends = {static_cast<float>(bend.allShifts), static_cast<float>(bend.allTurns), 0, 0};
    tables.columns.push_back(column);
    if (moves) extent.add(now);
  }
  tables.columns.resize(times.count, column);
  const double toMiddle = times.halfway;
  const Drift drift = driftOf(extent.places, toMiddle);
  const double order = times.step < 0 ? -1 : 1;  // a clockwise head fires its last column first
  const glm::dvec3 perColumn = moves ? glm::transpose(middle.turn) * (order * drift.perColumn) : glm::dvec3(0);
  const auto up = [](double value) { return static_cast<float>(value * 1.00001); };
  tables.bounds = {.shift = up(extent.shift + lasers.distance),
                   .turn = up(extent.turn),
                   .shiftPerColumn = up(extent.shiftPerColumn),
                   .turnPerColumn = up(extent.turnPerColumn),
                   .origins = up(lasers.distance),
                   .forward = up(lasers.forward),
                   .left = up(lasers.left),
                   .up = up(lasers.up),
                   .secondsPerColumn = up(std::abs(times.step)),
                   .seconds = up(std::max(times.last, -times.earliest)),
                   .instances = 0,
                   .sensor = moves,
                   .middle = static_cast<float>(times.middle),
                   .columnsToMiddle = static_cast<float>(std::max(toMiddle, times.used - 2.0 - toMiddle)),
                   .drift = glm::vec3(perColumn),
                   .wander = up(drift.wander),
                   .wanderPerColumn = up(drift.wanderPerColumn),
                   .bendShift = up(bend.shift),
                   .bendTurn = up(bend.turn),
                   .bendFirst = bend.first,
                   .bendEnd = bend.end};
  return tables;
}

}  // namespace gnosphere
