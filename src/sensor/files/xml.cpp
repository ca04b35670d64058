// SPDX-License-Identifier: Apache-2.0
#include "sensor/files/xml.hpp"

#include <set>
#include <string_view>

namespace gnosphere {

pugi::xml_document parseXml(const SensorSource& source) {
  pugi::xml_document document;
  const auto result = document.load_buffer(source.bytes.data(), source.bytes.size());
  if (!result)
    source.refuse("line " + std::to_string(lineNumber(source.bytes, result.offset)) +
                  ": is not XML: " + result.description());
  return document;
}

namespace {

/// Returns the name of a node after those of the models that it is in: "robot::lidar".
std::string scopedName(const pugi::xml_node& node, const char* attribute) {
  std::string name = node.attribute(attribute).value();
  for (pugi::xml_node outer = node.parent(); outer; outer = outer.parent())
    if (std::string_view(outer.name()) == "model") name = outer.attribute("name").value() + ("::" + name);
  return name;
}

}  // namespace

pugi::xml_node chooseXml(SensorSource& source, const std::vector<pugi::xml_node>& nodes, const char* attribute,
                         const std::string& value) {
  std::set<std::string> names;
  for (const pugi::xml_node& node : nodes) names.insert(node.attribute(attribute).value());
  const bool scoped = names.size() < nodes.size();
  std::string listed;
  for (const pugi::xml_node& node : nodes) {
    const std::string name = scoped ? scopedName(node, attribute) : node.attribute(attribute).value();
    if (!value.empty() && value == name) return node;
    listed.append(listed.empty() ? "" : ", ").append(name);
  }
  if (!value.empty()) source.refuse("has no lidar '" + value + "', but " + listed);
  if (nodes.size() > 1)
    source.assume("the first of the lidars " + listed + "; `gnosphere sensors --mode` takes another");
  return nodes[0];
}

}  // namespace gnosphere
