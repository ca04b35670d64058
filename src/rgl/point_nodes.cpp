// SPDX-License-Identifier: Apache-2.0
// Nodes that make, choose, move and pack points.
#include <algorithm>
#include <set>

#include "rgl/node.hpp"

namespace gnosphere::rgl {
namespace {

bool contains(const Fields& fields, rgl_field_t field) {
  return std::find(fields.begin(), fields.end(), field) != fields.end();
}

size_t rowSize(const Fields& fields) {
  size_t bytes = 0;
  for (const rgl_field_t field : fields) bytes += sizeOf(field);
  return bytes;
}

/// Copies each field between its column and its place in packed rows.
template <class Copy>
void eachValue(const Fields& fields, size_t count, Copy copy) {
  const size_t stride = rowSize(fields);
  size_t offset = 0;
  for (size_t k = 0; k < fields.size(); offset += sizeOf(fields[k]), ++k) {
    if (isPadding(fields[k])) continue;
    for (size_t i = 0; i < count; ++i) copy(fields[k], i, i * stride + offset);
  }
}

class TransformPointsNode : public PointsFilter {
 public:
  static constexpr const char* kName = "TransformPointsNode";
  const char* name() const override { return kName; }
  void set(const Mat& transform) { transform_ = transform; }
  Fields required() const override { return {RGL_FIELD_XYZ_VEC3_F32}; }
  void run() override {
    cloud_ = input_->cloud();
    const Vec* from = input_->cloud().values<Vec>(RGL_FIELD_XYZ_VEC3_F32);
    Vec* to = cloud_.write<Vec>(RGL_FIELD_XYZ_VEC3_F32);
    std::transform(from, from + cloud_.count, to, [&](const Vec& point) { return transform_ * point; });
    cloud_.sensor = transform_ * cloud_.sensor;
  }

 private:
  Mat transform_;
};

class FormatNode : public PointsFilter {
 public:
  static constexpr const char* kName = "FormatPointsNode";
  const char* name() const override { return kName; }
  void set(Fields fields) { fields_ = std::move(fields); }
  Fields required() const override { return fields_; }
  Fields format() const override { return fields_; }
  bool has(rgl_field_t field) const override { return field == RGL_FIELD_DYNAMIC_FORMAT || PointsFilter::has(field); }
  size_t sizeOfResult(rgl_field_t field) const override {
    return field == RGL_FIELD_DYNAMIC_FORMAT ? rowSize(fields_) : PointsFilter::sizeOfResult(field);
  }
  void run() override {
    cloud_ = input_->cloud();
    auto rows = std::make_shared<std::vector<std::byte>>(cloud_.count * rowSize(fields_));
    eachValue(fields_, cloud_.count, [&](rgl_field_t field, size_t i, size_t place) {
      const Cloud::Column& column = cloud_.columns.at(field);
      std::memcpy(rows->data() + place, column.bytes->data() + i * column.size, column.size);
    });
    cloud_.columns[RGL_FIELD_DYNAMIC_FORMAT] = {rowSize(fields_), rows};
  }

 private:
  Fields fields_;
};

class YieldNode : public PointsFilter {
 public:
  static constexpr const char* kName = "YieldPointsNode";
  const char* name() const override { return kName; }
  void set(Fields fields) { fields_ = std::move(fields); }
  Fields required() const override { return fields_; }
  void run() override { cloud_ = input_->cloud(); }

 private:
  Fields fields_;
};

class CompactNode : public PointsFilter {
 public:
  static constexpr const char* kName = "CompactByFieldPointsNode";
  const char* name() const override { return kName; }
  void set(rgl_field_t field) { field_ = field; }
  Fields required() const override { return {field_}; }
  bool isDense() const override { return field_ == RGL_FIELD_IS_HIT_I32 || PointsFilter::isDense(); }
  void run() override {
    std::vector<uint32_t> kept;
    const int32_t* values = input_->cloud().values<int32_t>(field_);
    for (size_t i = 0; i < input_->cloud().count; ++i)
      if (values[i] != 0) kept.push_back(static_cast<uint32_t>(i));
    cloud_ = input_->cloud().select(kept);
  }

 private:
  rgl_field_t field_ = RGL_FIELD_IS_HIT_I32;
};

class FromArrayNode : public PointsNode {
 public:
  static constexpr const char* kName = "FromArrayPointsNode";
  const char* name() const override { return kName; }
  void set(const void* points, int32_t count, const Fields& fields) {
    Cloud cloud;
    cloud.count = count;
    std::map<rgl_field_t, std::byte*> columns;
    for (const rgl_field_t field : fields) {
      if (isPadding(field)) continue;
      auto bytes = std::make_shared<std::vector<std::byte>>(count * sizeOf(field));
      columns[field] = bytes->data();
      cloud.columns[field] = {sizeOf(field), bytes};
    }
    eachValue(fields, count, [&](rgl_field_t field, size_t i, size_t place) {
      std::memcpy(columns[field] + i * sizeOf(field), static_cast<const std::byte*>(points) + place, sizeOf(field));
    });
    cloud_ = std::move(cloud);
  }
  void validate() override {}
  void run() override {}
  bool has(rgl_field_t field) const override { return cloud_.has(field); }
  bool isDense() const override { return true; }
};

/// Appends the points of a cloud to columns.
class Collector {
 public:
  void add(const Cloud& cloud, const Fields& fields) {
    for (const rgl_field_t field : std::set<rgl_field_t>(fields.begin(), fields.end())) {
      if (isPadding(field)) continue;
      const auto& bytes = *cloud.columns.at(field).bytes;
      columns_[field].insert(columns_[field].end(), bytes.begin(), bytes.end());
    }
    count_ += cloud.count;
  }
  /// The collected points; the collector is empty afterwards.
  Cloud take() {
    Cloud result;
    result.count = count_;
    for (auto& [field, bytes] : columns_)
      result.columns[field] = {sizeOf(field), std::make_shared<std::vector<std::byte>>(std::move(bytes))};
    *this = {};
    return result;
  }

 private:
  std::map<rgl_field_t, std::vector<std::byte>> columns_;
  size_t count_ = 0;
};

class SpatialMergeNode : public PointsNode {
 public:
  static constexpr const char* kName = "SpatialMergePointsNode";
  const char* name() const override { return kName; }
  void set(Fields fields) { fields_ = std::move(fields); }
  Fields required() const override { return fields_; }
  bool has(rgl_field_t field) const override { return contains(fields_, field); }
  bool isDense() const override { return dense_; }
  void validate() override {
    sources_.clear();
    for (GraphNode* input : inputs)
      if (auto* points = dynamic_cast<PointsNode*>(input)) sources_.push_back(points);
    if (sources_.size() < 2 || sources_.size() != inputs.size())
      throw Failure(RGL_INVALID_PIPELINE, std::string(kName) + ": looked for IPointsNode, at least two, but found " +
                                              std::to_string(sources_.size()) + " among " +
                                              std::to_string(inputs.size()) + " inputs");
    dense_ = true;
    for (const PointsNode* source : sources_) {
      checkRequired(*this, *source);
      dense_ = dense_ && source->isDense();
    }
  }
  void run() override {
    Collector all;
    for (const PointsNode* source : sources_) all.add(source->cloud(), fields_);
    cloud_ = all.take();
    cloud_.sensor = sources_[0]->cloud().sensor;
  }

 private:
  Fields fields_;
  std::vector<PointsNode*> sources_;
  bool dense_ = false;
};

/// Keeps the points of all runs.
class TemporalMergeNode : public PointsFilter {
 public:
  static constexpr const char* kName = "TemporalMergePointsNode";
  const char* name() const override { return kName; }
  void set(Fields fields) {
    fields_ = std::move(fields);
    cloud_ = {};
  }
  Fields required() const override { return fields_; }
  bool has(rgl_field_t field) const override { return contains(fields_, field); }
  void run() override {
    Collector all;
    if (cloud_.count > 0) all.add(cloud_, fields_);
    all.add(input_->cloud(), fields_);
    cloud_ = all.take();
    cloud_.sensor = input_->cloud().sensor;
  }

 private:
  Fields fields_;
};

/// Marks the points of surfaces that are not level: 1 in IS_GROUND is a point that is not ground.
class FilterGroundNode : public PointsFilter {
 public:
  static constexpr const char* kName = "FilterGroundPointsNode";
  const char* name() const override { return kName; }
  void set(const Vec& up, float angle) {
    up_ = up;
    angle_ = angle;
  }
  Fields required() const override { return {RGL_FIELD_XYZ_VEC3_F32, RGL_FIELD_NORMAL_VEC3_F32}; }
  bool has(rgl_field_t field) const override { return field == RGL_FIELD_IS_GROUND_I32 || PointsFilter::has(field); }
  void run() override {
    cloud_ = input_->cloud();
    const Vec* normals = cloud_.values<Vec>(RGL_FIELD_NORMAL_VEC3_F32);
    auto* marks = cloud_.write<int32_t>(RGL_FIELD_IS_GROUND_I32);
    for (size_t i = 0; i < cloud_.count; ++i)
      marks[i] = std::acos(std::min(1.0f, std::abs(dot(normals[i], up_)))) > angle_;
  }

 private:
  Vec up_;
  float angle_ = 0;
};

/// Runs a function that gives a node a list of fields; `verb` is what the node does with each.
template <class T>
rgl_status_t withFields(const char* name, const char* verb, rgl_node_t* node, const rgl_field_t* fields,
                        int32_t field_count) {
  return call(name, taped(out(node), arrayOf(fields, field_count), field_count), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(fields != nullptr);
    RGL_CHECK(field_count > 0);
    Fields wanted;
    for (int32_t i = 0; i < field_count; ++i) {
      if (fields[i] == RGL_FIELD_DYNAMIC_FORMAT)
        throw Failure(RGL_INVALID_ARGUMENT, std::string("cannot ") + verb + " field 'RGL_FIELD_DYNAMIC_FORMAT'");
      wanted.push_back(fieldOf(fields[i]));
    }
    createOrUpdate<T>(node, Affects::graph, [&](auto& made) { made.set(std::move(wanted)); });
  });
}

}  // namespace
}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_node_points_transform(rgl_node_t* node, const rgl_mat3x4f* transform) {
  return call(__func__, taped(out(node), arrayOf(transform, 1)), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(transform != nullptr);
    RGL_CHECK(isFinite(*transform));
    createOrUpdate<TransformPointsNode>(node, Affects::node, [&](auto& made) { made.set(matOf(*transform)); });
  });
}

RGL_API rgl_status_t rgl_node_points_format(rgl_node_t* node, const rgl_field_t* fields, int32_t field_count) {
  return withFields<FormatNode>("rgl_node_points_format", "format", node, fields, field_count);
}

RGL_API rgl_status_t rgl_node_points_yield(rgl_node_t* node, const rgl_field_t* fields, int32_t field_count) {
  return withFields<YieldNode>("rgl_node_points_yield", "yield", node, fields, field_count);
}

RGL_API rgl_status_t rgl_node_points_spatial_merge(rgl_node_t* node, const rgl_field_t* fields, int32_t field_count) {
  return withFields<SpatialMergeNode>("rgl_node_points_spatial_merge", "perform spatial merge on", node, fields,
                                      field_count);
}

RGL_API rgl_status_t rgl_node_points_temporal_merge(rgl_node_t* node, const rgl_field_t* fields, int32_t field_count) {
  return withFields<TemporalMergeNode>("rgl_node_points_temporal_merge", "perform temporal merge on", node, fields,
                                       field_count);
}

RGL_API rgl_status_t rgl_node_points_compact_by_field(rgl_node_t* node, rgl_field_t field) {
  return call(__func__, taped(out(node), field), [&] {
    RGL_CHECK(node != nullptr);
    const rgl_field_t wanted = fieldOf(field);
    RGL_CHECK(wanted == RGL_FIELD_IS_HIT_I32 || wanted == RGL_FIELD_IS_GROUND_I32);
    createOrUpdate<CompactNode>(node, Affects::graph, [&](auto& made) { made.set(wanted); });
  });
}

RGL_API rgl_status_t rgl_node_points_from_array(rgl_node_t* node, const void* points, int32_t points_count,
                                                const rgl_field_t* fields, int32_t field_count) {
  size_t stride = 0;
  return call(
      __func__,
      taped(out(node), RowArray{points, points_count, stride}, points_count, arrayOf(fields, field_count), field_count),
      [&] {
        RGL_CHECK(node != nullptr);
        RGL_CHECK(points != nullptr);
        RGL_CHECK(points_count > 0);
        RGL_CHECK(fields != nullptr);
        RGL_CHECK(field_count > 0);
        const Fields wanted = fieldsOf(fields, field_count);
        stride = rowSize(wanted);
        createOrUpdate<FromArrayNode>(node, Affects::graph,
                                      [&](auto& made) { made.set(points, points_count, wanted); });
      });
}

RGL_API rgl_status_t rgl_node_points_filter_ground(rgl_node_t* node, const rgl_vec3f* sensor_up_vector,
                                                   float ground_angle_threshold) {
  return call(__func__, taped(out(node), arrayOf(sensor_up_vector, 1), ground_angle_threshold), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(sensor_up_vector != nullptr);
    RGL_CHECK(ground_angle_threshold >= 0);
    const float* const up = sensor_up_vector->value;
    createOrUpdate<FilterGroundNode>(node, Affects::graph, [&](auto& made) {
      made.set({up[0], up[1], up[2]}, ground_angle_threshold);
    });
  });
}
