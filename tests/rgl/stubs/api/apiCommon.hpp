// SPDX-License-Identifier: Apache-2.0
// Stands in for RGL's internal way to create a node. The tests make one kind of node by it: one that gives no points
// but has every field. Here it is a compact node behind a point that is no hit.
#pragma once

#include <Logger.hpp>
#include <RGLFields.hpp>
#include <graph/Node.hpp>
#include <vector>

template <typename NodeType>
void createOrUpdateNode(rgl_node_t* node) {
  const std::vector<rgl_field_t> fields(getAllRealFields().begin(), getAllRealFields().end());
  const std::vector<char> point(getPointSize(fields), 0);
  rgl_node_t source = nullptr;
  rgl_node_points_from_array(&source, point.data(), 1, fields.data(), static_cast<int32_t>(fields.size()));
  rgl_node_points_compact_by_field(node, RGL_FIELD_IS_HIT_I32);
  rgl_graph_node_add_child(source, *node);
}
