// SPDX-License-Identifier: Apache-2.0
// Nodes of a graph: rays or points come in, rays or points go out.
#pragma once

#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include "rgl/fields.hpp"
#include "rgl/math.hpp"
#include "rgl/objects.hpp"

namespace gnosphere::rgl {

/// Rays that one node hands to the next. Arrays are shared, because most nodes hand on most of them.
struct Rays {
  std::shared_ptr<const std::vector<Mat>> base;          ///< in the sensor's frame
  uint64_t baseVersion = 0;                              ///< another number for other rays
  Mat transform;                                         ///< from the sensor's frame to the world
  std::shared_ptr<const std::vector<Mat>> world;         ///< in the world frame
  std::shared_ptr<const std::vector<rgl_vec2f>> ranges;  ///< none, one for all, or one per ray
  std::shared_ptr<const std::vector<int32_t>> rings;     ///< none, or repeated
  std::shared_ptr<const std::vector<float>> offsets;     ///< none, or one per ray: milliseconds
  uint64_t offsetsVersion = 0;

  size_t count() const { return base ? base->size() : 0; }
};

/// Points between two nodes: a column per field. Arrays are shared as those of rays are.
struct Cloud {
  struct Column {
    size_t size = 0;  ///< bytes per point
    std::shared_ptr<const std::vector<std::byte>> bytes;
  };
  size_t count = 0;
  Mat sensor;  ///< from the frame of the sensor to that of the points
  std::map<rgl_field_t, Column> columns;

  bool has(rgl_field_t field) const { return columns.contains(field); }
  template <class T>
  const T* values(rgl_field_t field) const {
    return reinterpret_cast<const T*>(columns.at(field).bytes->data());
  }
  /// Replaces a column by new values, which the caller writes.
  template <class T>
  T* write(rgl_field_t field) {
    auto bytes = std::make_shared<std::vector<std::byte>>(count * sizeof(T));
    columns[field] = {sizeof(T), bytes};
    return reinterpret_cast<T*>(bytes->data());
  }
  /// The points with these indices, in this order.
  Cloud select(const std::vector<uint32_t>& indices) const;
};

class GraphNode {
 public:
  virtual ~GraphNode() = default;
  virtual const char* name() const = 0;
  /// Throws Failure(RGL_INVALID_PIPELINE) if the node's inputs do not suit it. Inputs are validated before it.
  virtual void validate() = 0;
  virtual void run() = 0;

  std::vector<GraphNode*> inputs, outputs;
  int32_t priority = 0;
  bool valid = false;  ///< whether the results are those of the parameters and of the graph
};

class RaysNode : public GraphNode {
 public:
  const Rays& rays() const { return rays_; }
  virtual size_t rayCount() const = 0;

 protected:
  Rays rays_;
};

class PointsNode : public GraphNode {
 public:
  static constexpr const char* kName = "IPointsNode";
  const Cloud& cloud() const { return cloud_; }
  /// Whether the points of the next run will have a field.
  virtual bool has(rgl_field_t field) const = 0;
  /// The fields that the node needs of its input.
  virtual Fields required() const { return {}; }
  virtual bool isDense() const { return false; }
  /// The fields of the rows in RGL_FIELD_DYNAMIC_FORMAT; none if there is no such column.
  virtual Fields format() const { return {}; }
  /// Bytes of one value as rgl_graph_get_result_size() tells it.
  virtual size_t sizeOfResult(rgl_field_t field) const { return sizeOf(field); }

 protected:
  Cloud cloud_;
};

/// The one input of a node that gives rays. Throws Failure(RGL_INVALID_PIPELINE) if there is not exactly one.
RaysNode& raysInput(const GraphNode& node);
PointsNode& pointsInput(const GraphNode& node);
/// Throws Failure(RGL_INVALID_PIPELINE) unless the input has all fields that the node requires.
void checkRequired(const PointsNode& node, const PointsNode& input);

/// A node of rays behind another.
class RaysFilter : public RaysNode {
 public:
  void validate() override { input_ = &raysInput(*this); }
  size_t rayCount() const override { return input_->rayCount(); }

 protected:
  RaysNode* input_ = nullptr;
};

/// A node of points behind another.
class PointsFilter : public PointsNode {
 public:
  void validate() override {
    input_ = &pointsInput(*this);
    checkRequired(*this, *input_);
  }
  bool has(rgl_field_t field) const override { return input_ && input_->has(field); }
  bool isDense() const override { return input_->isDense(); }
  size_t sizeOfResult(rgl_field_t field) const override { return input_ ? input_->sizeOfResult(field) : sizeOf(field); }

 protected:
  PointsNode* input_ = nullptr;
};

Objects<rgl_node_t, GraphNode>& nodes();
void clearNodes();
/// A number that is never given twice, for versions of arrays.
uint64_t nextVersion();
/// A source of random numbers for one node: from GNOSPHERE_RGL_SEED and the number of the node, or random.
std::mt19937_64 randomSource();

/// Marks the results of all nodes that are connected with this one as outdated.
void outdate(GraphNode& node);
/// A node and all nodes that its inputs, its outputs or both lead to, each once, however many ways lead to it.
std::vector<GraphNode*> reached(GraphNode& node, std::initializer_list<std::vector<GraphNode*> GraphNode::*> ways);
/// The nodes that are connected with a node, and the node.
std::vector<GraphNode*> connected(GraphNode& node);

template <class T>
T& nodeAs(rgl_node_t handle) {
  GraphNode& node = *nodes().at(handle);
  if (T* typed = dynamic_cast<T*>(&node)) return *typed;
  throw Failure(RGL_INVALID_API_OBJECT,
                std::string("Node type mismatch: expected ") + T::kName + ", got " + node.name());
}

/// A node whose results are those of its last run. Throws Failure(RGL_INVALID_PIPELINE) if it has none.
const PointsNode& resultsOf(rgl_node_t handle);

/// Part of a graph that is outdated when a node gets other parameters.
enum class Affects { node, graph };

/// Creates a node, or gives the one that is there new parameters; set(node) does that, or throws and changes nothing.
template <class T, class Set>
void createOrUpdate(rgl_node_t* node, Affects affects, Set set) {
  if (*node == nullptr) {
    auto created = std::make_shared<T>();
    set(*created);
    *node = nodes().add(std::move(created));
    return;
  }
  T& old = nodeAs<T>(*node);
  const std::vector<GraphNode*> outdated = affects == Affects::graph ? connected(old) : std::vector<GraphNode*>{&old};
  set(old);
  for (GraphNode* each : outdated) each->valid = false;
}

}  // namespace gnosphere::rgl
