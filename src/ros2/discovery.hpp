// SPDX-License-Identifier: Apache-2.0
// Where publishers look for subscribers, as ROS 2 lets its nodes be told by environment variables.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace gnosphere::ros2 {

/// The values of the environment variables that say where nodes look for each other; a variable that is not set is "".
struct DiscoveryVariables {
  std::string localhostOnly;  ///< ROS_LOCALHOST_ONLY
  std::string range;          ///< ROS_AUTOMATIC_DISCOVERY_RANGE
  std::string staticPeers;    ///< ROS_STATIC_PEERS
  std::string distribution;   ///< ROS_DISTRO
};

DiscoveryVariables discoveryVariables();

/// Returns the configuration of Cyclone DDS with which nodes of ROS 2 that have these variables find each other: that
/// of rmw_cyclonedds, since participants with another one may not answer where its nodes ask. `localhostOnly` replaces
/// the range of the variables by LOCALHOST without peers, or by SUBNET. `process` is the number of this process. Throws
/// Error(invalidArgument) for a range that ROS does not know, and for a peer that is no address.
std::string discoveryConfiguration(const DiscoveryVariables& variables, std::optional<bool> localhostOnly,
                                   uint32_t process);

}  // namespace gnosphere::ros2
