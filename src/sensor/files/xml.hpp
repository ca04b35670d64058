// SPDX-License-Identifier: Apache-2.0
// Steps that the readers of XML share.
#pragma once

#include <pugixml.hpp>
#include <string>
#include <vector>

#include "sensor/files/source.hpp"

namespace gnosphere {

/// Parses a file, or refuses it with the line of the mistake.
pugi::xml_document parseXml(const SensorSource& source);
/// Returns the node whose attribute has this value; if the value is empty, the first node, and several are noted as
/// assumed. Where names repeat, as in a fleet of robots, a name is after those of the models that it is in.
pugi::xml_node chooseXml(SensorSource& source, const std::vector<pugi::xml_node>& nodes, const char* attribute,
                         const std::string& value);

}  // namespace gnosphere
