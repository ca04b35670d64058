// SPDX-License-Identifier: Apache-2.0
#include "sensor/files/xml.hpp"

namespace gnosphere {

pugi::xml_document parseXml(const SensorSource& source) {
  pugi::xml_document document;
  const auto result = document.load_buffer(source.bytes.data(), source.bytes.size());
  if (!result)
    source.refuse("line " + std::to_string(lineNumber(source.bytes, result.offset)) +
                  ": is not XML: " + result.description());
  return document;
}

pugi::xml_node chooseXml(SensorSource& source, const std::vector<pugi::xml_node>& nodes, const char* attribute,
                         const std::string& value) {
  std::string names;
  for (const pugi::xml_node& node : nodes) {
    if (!value.empty() && value == node.attribute(attribute).value()) return node;
    names.append(names.empty() ? "" : ", ").append(node.attribute(attribute).value());
  }
  if (!value.empty()) source.refuse("has no lidar '" + value + "', but " + names);
  if (nodes.size() > 1)
    source.assume("the first of the lidars " + names + "; `gnosphere sensors --mode` takes another");
  return nodes[0];
}

}  // namespace gnosphere
