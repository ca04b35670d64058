// SPDX-License-Identifier: Apache-2.0
#include "poses.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "base/vector.hpp"

namespace gnosphere::bench {
namespace {

constexpr size_t kPlacesPerPose = 16;       ///< places that are compared for each pose
constexpr size_t kDrawsPerPlace = 16;       ///< draws for each place, most of which may be unfit
constexpr double kClearance = 0.25;         ///< least distance to anything, and least height, in standing heights
constexpr double kOffset = 5;               ///< largest distance from the drawn triangle, in standing heights
constexpr double kLeastSpacing = 1.0 / 32;  ///< between two poses, in diagonals of the scene's box seen from above

struct Place {
  Pose pose;
  double score = 0;
};

/// Height of the sensor above the surface on which it stands.
double heightIn(const Bounds& box) {
  return std::min(kFullHeight, 0.1 * std::max(box.max.x - box.min.x, box.max.y - box.min.y));
}

/// Two beams, straight down and straight up.
Sensor plumb(const Bounds& box) {
  Sensor sensor = {"plumb", 1, {{-90, 0}, {90, 0}}};
  sensor.rangeMax = 2 * (box.max.z - box.min.z + heightIn(box));
  return sensor;
}

/// A coarse grid over the vertical field of view of the hypothetical sensors, with the range of an HDL-64E.
Sensor coarse() {
  Sensor sensor = {"coarse", 180, {}};
  for (double elevation = -45; elevation <= 45; elevation += 3) sensor.channels.push_back({elevation, 0});
  sensor.rangeMax = 120;
  return sensor;
}

Vec3 cornerOf(const Mesh& mesh, size_t triangle, size_t corner) {
  const float* p = &mesh.positions[3 * size_t{mesh.indices[3 * triangle + corner]}];
  return mesh.origin + Vec3{p[0], p[1], p[2]};
}

/// Whether `from` is in front of a triangle. A transform that mirrors leaves the front where it was in the mesh.
bool seesFront(const Vec3& from, const Scene& scene, const Instance& instance, size_t triangle) {
  Vec3 corners[3];
  for (size_t corner = 0; corner < 3; ++corner)
    corners[corner] = instance.transform * cornerOf(scene.meshes[instance.mesh], triangle, corner);
  const auto& m = instance.transform.rows;
  const double mirrored = dot(cross({m[0], m[4], m[8]}, {m[1], m[5], m[9]}), {m[2], m[6], m[10]});
  return mirrored * dot(cross(corners[1] - corners[0], corners[2] - corners[0]), from - corners[0]) > 0;
}

/// The number of different triangles that the scan sees from the front, times the share of its beams that do. Backs are
/// seen from within solids.
double scoreOf(const Scan& scan, const Scene& scene) {
  std::vector<uint64_t> seen;
  for (size_t beam = 0; beam < scan.beamCount(); ++beam) {
    if (!scan.hit(beam)) continue;
    const uint32_t instance = scan.instances[beam], triangle = scan.triangles[beam];
    if (seesFront(scan.pose.position, scene, scene.instances[instance], triangle))
      seen.push_back(uint64_t{instance} << 32 | triangle);
  }
  const double share = static_cast<double>(seen.size()) / static_cast<double>(scan.beamCount());
  std::sort(seen.begin(), seen.end());
  return share * static_cast<double>(std::unique(seen.begin(), seen.end()) - seen.begin());
}

class Search {
 public:
  Search(const Scene& scene, uint64_t seed, const SimulatorOptions& options)
      : scene_(scene),
        box_(worldBounds(scene)),
        height_(heightIn(box_)),
        random_(seed),
        simulator_(scene, {{plumb(box_), Effects::none()}, {coarse(), Effects::none()}}, options) {
    uint64_t end = 0;
    for (const Instance& instance : scene.instances)
      ends_.push_back(end += instance.mesh == kNoMesh ? 0 : scene.meshes[instance.mesh].triangleCount());
  }

  std::vector<Place> places(size_t count) {
    std::vector<Place> found;
    for (size_t draw = 0; draw < count * kDrawsPerPlace && found.size() < count; ++draw)
      if (const std::optional<Place> place = placeNear(drawPoint())) found.push_back(*place);
    return found;
  }

 private:
  /// Uniform from 0 to 1. The distributions of the standard library differ between its implementations.
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  /// A point beside and above the middle of a random triangle, so that there are most where the most detail is.
  Vec3 drawPoint() {
    const uint64_t drawn = random_() % ends_.back();
    const size_t instance = static_cast<size_t>(std::upper_bound(ends_.begin(), ends_.end(), drawn) - ends_.begin());
    const Mesh& mesh = scene_.meshes[scene_.instances[instance].mesh];
    const size_t triangle = mesh.triangleCount() - (ends_[instance] - drawn);
    const Vec3 middle =
        1.0 / 3 * (cornerOf(mesh, triangle, 0) + cornerOf(mesh, triangle, 1) + cornerOf(mesh, triangle, 2));
    const double along = kOffset * (2 * uniform() - 1), across = kOffset * (2 * uniform() - 1), up = uniform();
    return scene_.instances[instance].transform * middle + height_ * Vec3{along, across, up};
  }

  std::optional<Place> placeNear(const Vec3& point) {
    const auto inside = [](double value, double low, double high) { return value >= low && value <= high; };
    if (!inside(point.x, box_.min.x, box_.max.x) || !inside(point.y, box_.min.y, box_.max.y) || !std::isfinite(point.z))
      return {};
    const Scan vertical = simulator_.scan({point, {}});
    if (!vertical.hit(0)) return {};
    const double floor = point.z - vertical.ranges[0];
    double height = height_;
    if (vertical.hit(1)) height = std::min(height, 0.5 * (point.z + vertical.ranges[1] - floor));
    if (height < kClearance * height_) return {};

    Place place;
    const double half = std::numbers::pi * uniform();
    place.pose = {{point.x, point.y, floor + height}, {0, 0, std::sin(half), std::cos(half)}};
    const Scan scan = simulator_.scan(place.pose, 1);
    for (float range : scan.ranges)
      if (range < kClearance * height_) return {};
    place.score = scoreOf(scan, scene_);
    return place;
  }

  const Scene& scene_;
  Bounds box_;
  double height_;
  std::mt19937_64 random_;
  Simulator simulator_;
  std::vector<uint64_t> ends_;  ///< by instance: number of placed triangles up to its last
};

double distance(const Place& a, const Place& b) {
  return lengthOf(a.pose.position - b.pose.position);
}

/// Takes the best places that are at least `spacing` apart, until there are `count`.
std::vector<Place> best(const std::vector<Place>& places, size_t count, double spacing) {
  std::vector<Place> taken;
  for (const Place& place : places) {
    const auto tooClose = [&](const Place& other) { return distance(place, other) < spacing; };
    if (taken.size() < count && std::none_of(taken.begin(), taken.end(), tooClose)) taken.push_back(place);
  }
  return taken;
}

}  // namespace

double standingHeight(const Scene& scene) {
  return heightIn(worldBounds(scene));
}

std::vector<Pose> detailedPoses(const Scene& scene, size_t count, uint64_t seed, const DeviceChoice& device) {
  if (scene.placedTriangleCount() == 0) return {};
  SimulatorOptions options;
  options.device = device;
  options.accuracy = Accuracy::exact;
  std::vector<Place> places = Search(scene, seed, options).places(count * kPlacesPerPose);
  std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.score > b.score; });

  const Bounds box = worldBounds(scene);
  double spacing = kLeastSpacing * std::hypot(box.max.x - box.min.x, box.max.y - box.min.y);
  std::vector<Place> taken = best(places, count, spacing);
  for (; taken.size() < std::min(count, places.size()); spacing /= 2) taken = best(places, count, spacing);
  std::vector<Pose> poses;
  for (const Place& place : taken) poses.push_back(place.pose);
  return poses;
}

}  // namespace gnosphere::bench
