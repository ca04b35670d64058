// SPDX-License-Identifier: Apache-2.0
// Nodes that RGL implements by PCL: point cloud files, voxels, and the removal of the ground plane.
#include <rgl/api/extensions/pcl.h>

#include <algorithm>
#include <array>
#include <map>

#include "base/file.hpp"
#include "base/path.hpp"
#include "rgl/node.hpp"

namespace gnosphere::rgl {
namespace {

/// One point per voxel: the centroid of its points; other fields are those of the first point of the voxel.
class DownsampleNode : public PointsFilter {
 public:
  static constexpr const char* kName = "DownSamplePointsNode";
  const char* name() const override { return kName; }
  void set(const Vec& leaf) { leaf_ = leaf; }
  Fields required() const override { return {RGL_FIELD_XYZ_VEC3_F32}; }
  void run() override {
    const Cloud& from = input_->cloud();
    const Vec* points = from.values<Vec>(RGL_FIELD_XYZ_VEC3_F32);
    struct Voxel {
      uint32_t first;
      double x = 0, y = 0, z = 0;
      uint32_t count = 0;
    };
    // Voxels are ordered by z, y and x, as PCL lists them. Their numbers are floats, because the numbers of far voxels
    // are too large for any integer.
    std::map<std::array<float, 3>, Voxel> voxels;
    for (uint32_t i = 0; i < from.count; ++i) {
      const Vec& p = points[i];
      if (!std::isfinite(p.x + p.y + p.z)) continue;
      const auto cell = [](float value, float leaf) { return std::floor(value / leaf); };
      Voxel& voxel =
          voxels.try_emplace({cell(p.z, leaf_.z), cell(p.y, leaf_.y), cell(p.x, leaf_.x)}, Voxel{i}).first->second;
      voxel.x += p.x, voxel.y += p.y, voxel.z += p.z;
      ++voxel.count;
    }
    std::vector<uint32_t> firsts;
    for (const auto& [cell, voxel] : voxels) firsts.push_back(voxel.first);
    cloud_ = from.select(firsts);
    Vec* to = cloud_.write<Vec>(RGL_FIELD_XYZ_VEC3_F32);
    for (const auto& [cell, voxel] : voxels)
      *to++ = {static_cast<float>(voxel.x / voxel.count), static_cast<float>(voxel.y / voxel.count),
               static_cast<float>(voxel.z / voxel.count)};
  }

 private:
  Vec leaf_;
};

/// Removes the points near the plane that most of the low points agree on.
class RemoveGroundNode : public PointsFilter {
 public:
  static constexpr const char* kName = "RemoveGroundPointsNode";
  const char* name() const override { return kName; }
  void set(rgl_axis_t up, float angle, float distance, float filterDistance) {
    up_ = up == RGL_AXIS_X ? Vec{1, 0, 0} : up == RGL_AXIS_Y ? Vec{0, 1, 0} : Vec{0, 0, 1};
    angle_ = angle;
    distance_ = distance;
    filterDistance_ = filterDistance;
  }
  Fields required() const override { return {RGL_FIELD_XYZ_VEC3_F32}; }
  void run() override {
    const Cloud& from = input_->cloud();
    const Vec* points = from.values<Vec>(RGL_FIELD_XYZ_VEC3_F32);
    const Plane ground = findPlane(points, from.count);
    std::vector<uint32_t> kept;
    for (uint32_t i = 0; i < from.count; ++i)
      if (ground.size == 0 || std::abs(ground.height(points[i])) > filterDistance_) kept.push_back(i);
    cloud_ = from.select(kept);
  }

 private:
  struct Plane {
    Vec normal;
    float offset = 0;
    size_t size = 0;  ///< number of points near it
    float height(const Vec& p) const { return dot(normal, p) - offset; }
  };

  // RANSAC: of the planes through three points each, the level one with most points near it.
  Plane findPlane(const Vec* points, size_t count) {
    constexpr int kTrials = 500;
    Plane best;
    if (count < 3) return best;
    std::uniform_int_distribution<size_t> any(0, count - 1);
    for (int trial = 0; trial < kTrials; ++trial) {
      const Vec &a = points[any(random_)], &b = points[any(random_)], &c = points[any(random_)];
      Plane plane;
      plane.normal = unit(cross(b - a, c - a));
      if (!(std::acos(std::min(1.0f, std::abs(dot(plane.normal, up_)))) <= angle_)) continue;
      plane.offset = dot(plane.normal, a);
      for (size_t i = 0; i < count; ++i) plane.size += std::abs(plane.height(points[i])) <= distance_;
      if (plane.size > best.size) best = plane;
    }
    return best;
  }

  Vec up_;
  float angle_ = 0, distance_ = 0, filterDistance_ = 0;
  std::mt19937_64 random_ = randomSource();
};

void writePcd(const PointsNode& node, const char* path) {
  const Cloud& cloud = node.cloud();
  if (!cloud.has(RGL_FIELD_XYZ_VEC3_F32))
    throw Failure(RGL_INVALID_PIPELINE, std::string(node.name()) + " requires XYZ_VEC3_F32 to be present");
  AtomicFile file(pathOf(path));
  const std::string count = std::to_string(cloud.count);
  file.write(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
      "WIDTH " +
      count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n");
  file.write(cloud.values<Vec>(RGL_FIELD_XYZ_VEC3_F32), sizeof(Vec) * cloud.count);
  file.commit();
}

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_graph_write_pcd_file(rgl_node_t node, const char* file_path) {
  return call(__func__, taped(node, std::string(file_path ? file_path : "")), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(file_path != nullptr);
    RGL_CHECK(file_path[0] != '\0');
    writePcd(resultsOf(node), file_path);
  });
}

RGL_API rgl_status_t rgl_node_points_downsample(rgl_node_t* node, float leaf_size_x, float leaf_size_y,
                                                float leaf_size_z) {
  return call(__func__, taped(out(node), leaf_size_x, leaf_size_y, leaf_size_z), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(leaf_size_x > 0.0f);
    RGL_CHECK(leaf_size_y > 0.0f);
    RGL_CHECK(leaf_size_z > 0.0f);
    createOrUpdate<DownsampleNode>(node, Affects::node, [&](auto& made) {
      made.set({leaf_size_x, leaf_size_y, leaf_size_z});
    });
  });
}

RGL_API rgl_status_t rgl_node_points_remove_ground(rgl_node_t* node, rgl_axis_t sensor_up_axis,
                                                   float ground_angle_threshold, float ground_distance_threshold,
                                                   float ground_filter_distance) {
  return call(
      __func__,
      taped(out(node), sensor_up_axis, ground_angle_threshold, ground_distance_threshold, ground_filter_distance), [&] {
        RGL_CHECK(node != nullptr);
        RGL_CHECK((sensor_up_axis == RGL_AXIS_X) || (sensor_up_axis == RGL_AXIS_Y) || (sensor_up_axis == RGL_AXIS_Z));
        RGL_CHECK(ground_angle_threshold >= 0.0f);
        RGL_CHECK(ground_distance_threshold > 0.0f);
        RGL_CHECK(ground_filter_distance > 0.0f);
        createOrUpdate<RemoveGroundNode>(node, Affects::node, [&](auto& made) {
          made.set(sensor_up_axis, ground_angle_threshold, ground_distance_threshold, ground_filter_distance);
        });
      });
}
