// SPDX-License-Identifier: Apache-2.0
// Graphs: their edges, their runs and their results.
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <set>

#include "base/room.hpp"
#include "rgl/node.hpp"

namespace gnosphere::rgl {
namespace {

uint64_t randomSources = 0;  // made since the last rgl_cleanup()

template <class T>
T& onlyInput(const GraphNode& node, const char* wanted) {
  T* found = nullptr;
  size_t count = 0;
  std::string names;
  for (GraphNode* input : node.inputs) {
    if (auto* typed = dynamic_cast<T*>(input)) {
      found = typed;
      ++count;
    }
    names += (names.empty() ? "" : ", ") + std::string(input->name());
  }
  if (count != 1)
    throw Failure(RGL_INVALID_PIPELINE,
                  std::string(node.name()) + ": looked for " + wanted + ", but found [" + names + "]");
  return *found;
}

void sortOutputs(GraphNode& node) {
  std::stable_sort(node.outputs.begin(), node.outputs.end(),
                   [](const GraphNode* a, const GraphNode* b) { return a->priority > b->priority; });
}

void setPriority(GraphNode& node, int32_t priority) {
  if (!node.outputs.empty() && node.outputs.front()->priority > priority)
    throw Failure(RGL_INVALID_PIPELINE, std::string("cannot set priority of ") + node.name() + " to " +
                                            std::to_string(priority) + ": its child " + node.outputs.front()->name() +
                                            " has " + std::to_string(node.outputs.front()->priority));
  node.priority = priority;
  for (GraphNode* input : node.inputs) {
    sortOutputs(*input);
    if (input->priority < priority) setPriority(*input, priority);
  }
}

bool isAncestor(const GraphNode& node, GraphNode& of) {
  const std::vector<GraphNode*> all = reached(of, {&GraphNode::inputs});
  return std::find(all.begin() + 1, all.end(), &node) != all.end();
}

void addChild(GraphNode& parent, GraphNode& child) {
  if (std::find(parent.outputs.begin(), parent.outputs.end(), &child) != parent.outputs.end())
    throw Failure(RGL_INVALID_PIPELINE,
                  std::string("attempted to add child ") + child.name() + " to parent " + parent.name() + " twice");
  if (isAncestor(child, parent))
    throw Failure(RGL_INVALID_PIPELINE, std::string("adding child ") + child.name() + " to parent " + parent.name() +
                                            " would close a circle");
  makeRoom(parent.outputs, parent.outputs.size() + 1);
  makeRoom(child.inputs, child.inputs.size() + 1);
  outdate(parent);
  outdate(child);
  parent.outputs.push_back(&child);
  child.inputs.push_back(&parent);
  sortOutputs(parent);
  if (parent.outputs.front()->priority > parent.priority) setPriority(parent, parent.outputs.front()->priority);
}

void removeChild(GraphNode& parent, GraphNode& child) {
  const auto output = std::find(parent.outputs.begin(), parent.outputs.end(), &child);
  if (output == parent.outputs.end())
    throw Failure(RGL_INVALID_PIPELINE, std::string("attempted to remove child ") + child.name() + " from " +
                                            parent.name() + ", but it was not found");
  outdate(parent);
  parent.outputs.erase(output);
  child.inputs.erase(std::find(child.inputs.begin(), child.inputs.end(), &parent));
}

/// Returns the nodes in the order in which they run: a node after its inputs, and among the nodes whose inputs have
/// run, the one of the highest priority first.
std::vector<GraphNode*> inOrder(std::vector<GraphNode*> waiting) {
  std::stable_sort(waiting.begin(), waiting.end(),
                   [](const GraphNode* a, const GraphNode* b) { return a->priority > b->priority; });
  std::vector<GraphNode*> order;
  std::set<const GraphNode*> done;
  while (!waiting.empty()) {
    const auto next = std::find_if(waiting.begin(), waiting.end(), [&](const GraphNode* node) {
      return std::all_of(node->inputs.begin(), node->inputs.end(),
                         [&](const GraphNode* input) { return done.contains(input); });
    });
    done.insert(*next);
    order.push_back(*next);
    waiting.erase(next);
  }
  return order;
}

void runGraph(GraphNode& start) {
  const std::vector<GraphNode*> order = inOrder(connected(start));
  for (GraphNode* node : order) node->validate();
  for (GraphNode* node : order) node->valid = false;
  for (GraphNode* node : order) {
    node->run();
    node->valid = true;
  }
}

}  // namespace

Objects<rgl_node_t, GraphNode>& nodes() {
  static auto* const all = new Objects<rgl_node_t, GraphNode>("Node");
  return *all;
}

void clearNodes() {
  nodes().clear();
  randomSources = 0;
}

uint64_t nextVersion() {
  static uint64_t next = 0;
  return ++next;
}

std::mt19937_64 randomSource() {
  std::seed_seq seed{uint64_t{std::random_device()()}, uint64_t{std::random_device()()}};
  if (const char* text = std::getenv("GNOSPHERE_RGL_SEED")) {
    char* end = nullptr;
    errno = 0;
    const uint64_t number = std::strtoull(text, &end, 0);
    if (end == text || *end != '\0' || errno != 0 || std::strchr(text, '-') != nullptr)
      log(RGL_LOG_LEVEL_WARN, std::string("GNOSPHERE_RGL_SEED is '") + text +
                                  "', which is no whole number of 64 bits; " + std::to_string(number) + " is used");
    std::seed_seq fixed{number & 0xffffffff, number >> 32, ++randomSources};  // it takes 32 bits of each
    return std::mt19937_64(fixed);
  }
  return std::mt19937_64(seed);
}

RaysNode& raysInput(const GraphNode& node) {
  return onlyInput<RaysNode>(node, "IRaysNode");
}
PointsNode& pointsInput(const GraphNode& node) {
  return onlyInput<PointsNode>(node, "IPointsNode");
}

void checkRequired(const PointsNode& node, const PointsNode& input) {
  for (const rgl_field_t field : node.required())
    if (!isPadding(field) && !input.has(field))
      throw Failure(RGL_INVALID_PIPELINE, std::string(node.name()) + " requires " + nameOf(field) + " to be present");
}

std::vector<GraphNode*> reached(GraphNode& node, std::initializer_list<std::vector<GraphNode*> GraphNode::*> ways) {
  std::vector<GraphNode*> found = {&node};
  for (size_t i = 0; i < found.size(); ++i)
    for (const auto way : ways)
      for (GraphNode* next : found[i]->*way)
        if (std::find(found.begin(), found.end(), next) == found.end()) found.push_back(next);
  return found;
}

std::vector<GraphNode*> connected(GraphNode& node) {
  return reached(node, {&GraphNode::outputs, &GraphNode::inputs});
}

const PointsNode& resultsOf(rgl_node_t handle) {
  const auto& points = nodeAs<PointsNode>(handle);
  if (!points.valid)
    throw Failure(RGL_INVALID_PIPELINE, std::string("Cannot get results from ") + points.name() +
                                            "; it hasn't been run yet, or the run has failed");
  return points;
}

void outdate(GraphNode& node) {
  for (GraphNode* each : connected(node)) each->valid = false;
}

Cloud Cloud::select(const std::vector<uint32_t>& indices) const {
  Cloud result;
  result.count = indices.size();
  result.sensor = sensor;
  for (const auto& [field, column] : columns) {
    auto bytes = std::make_shared<std::vector<std::byte>>(indices.size() * column.size);
    for (size_t i = 0; i < indices.size(); ++i)
      std::memcpy(bytes->data() + i * column.size, column.bytes->data() + indices[i] * column.size, column.size);
    result.columns[field] = {column.size, bytes};
  }
  return result;
}

}  // namespace gnosphere::rgl

using namespace gnosphere::rgl;

RGL_API rgl_status_t rgl_node_is_alive(rgl_node_t node, bool* out_alive) {
  return call(__func__, taped(node, false), [&] {
    RGL_CHECK(out_alive != nullptr);
    *out_alive = nodes().has(node);
  });
}

RGL_API rgl_status_t rgl_graph_run(rgl_node_t node) {
  return call(__func__, taped(node), [&] {
    RGL_CHECK(node != nullptr);
    runGraph(*nodes().at(node));
  });
}

RGL_API rgl_status_t rgl_graph_destroy(rgl_node_t node) {
  return call(__func__, taped(node), [&] {
    RGL_CHECK(node != nullptr);
    const std::vector<GraphNode*> all = connected(*nodes().at(node));
    nodes().removeIf([&](const GraphNode* each) { return std::find(all.begin(), all.end(), each) != all.end(); });
  });
}

RGL_API rgl_status_t rgl_graph_get_result_size(rgl_node_t node, rgl_field_t field, int32_t* out_count,
                                               int32_t* out_size_of) {
  int32_t count = 0, size = 0;
  return call(__func__, taped(node, field, count, size), [&] {
    RGL_CHECK(node != nullptr);
    const PointsNode& points = resultsOf(node);
    count = static_cast<int32_t>(points.cloud().count);
    size = static_cast<int32_t>(points.sizeOfResult(fieldOf(field)));
    if (out_count) *out_count = count;
    if (out_size_of) *out_size_of = size;
  });
}

RGL_API rgl_status_t rgl_graph_get_result_data(rgl_node_t node, rgl_field_t field, void* data) {
  return call(__func__, taped(node, field, 0), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(data != nullptr);
    const PointsNode& points = resultsOf(node);
    const rgl_field_t wanted = fieldOf(field);
    const auto column = points.cloud().columns.find(wanted);
    if (column == points.cloud().columns.end())
      throw Failure(RGL_INVALID_PIPELINE, std::string("the field ") + nameOf(wanted) + " is not in the results of " +
                                              points.name() + "; a yield or format node behind it asks for it");
    if (points.cloud().count > 0) std::memcpy(data, column->second.bytes->data(), column->second.bytes->size());
  });
}

RGL_API rgl_status_t rgl_graph_node_add_child(rgl_node_t parent, rgl_node_t child) {
  return call(__func__, taped(parent, child), [&] {
    RGL_CHECK(parent != nullptr);
    RGL_CHECK(child != nullptr);
    RGL_CHECK(parent != child);
    addChild(*nodes().at(parent), *nodes().at(child));
  });
}

RGL_API rgl_status_t rgl_graph_node_remove_child(rgl_node_t parent, rgl_node_t child) {
  return call(__func__, taped(parent, child), [&] {
    RGL_CHECK(parent != nullptr);
    RGL_CHECK(child != nullptr);
    removeChild(*nodes().at(parent), *nodes().at(child));
  });
}

RGL_API rgl_status_t rgl_graph_node_set_priority(rgl_node_t node, int32_t priority) {
  return call(__func__, taped(node, priority), [&] {
    RGL_CHECK(node != nullptr);
    setPriority(*nodes().at(node), priority);
  });
}

RGL_API rgl_status_t rgl_graph_node_get_priority(rgl_node_t node, int32_t* out_priority) {
  int32_t told = 0;
  return call(__func__, taped(node, told), [&] {
    RGL_CHECK(node != nullptr);
    RGL_CHECK(out_priority != nullptr);
    *out_priority = told = nodes().at(node)->priority;
  });
}
