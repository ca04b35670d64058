// SPDX-License-Identifier: Apache-2.0
// The ranges are those of rcl's discovery options, and the texts those of rmw_cyclonedds.
#include "ros2/discovery.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "gnosphere/error.hpp"

namespace gnosphere::ros2 {
namespace {

enum class Range { off, localhost, subnet, systemDefault };

[[noreturn]] void refuseVariable(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, "ros2::Publisher: " + why);
}

std::string valueOf(const char* variable) {
  const char* const value = std::getenv(variable);
  return value ? value : "";
}

/// Whether a distribution of ROS 2 is older than the ranges of discovery, which Iron brought.
bool isBeforeIron(std::string_view distribution) {
  constexpr std::string_view kNames[] = {"ardent",   "bouncy", "crystal",  "dashing",
                                         "eloquent", "foxy",   "galactic", "humble"};
  return std::ranges::find(kNames, distribution) != std::end(kNames);
}

Range rangeNamed(const std::string& name) {
  if (name.empty() || name == "SUBNET") return Range::subnet;
  if (name == "LOCALHOST") return Range::localhost;
  if (name == "OFF") return Range::off;
  if (name == "SYSTEM_DEFAULT") return Range::systemDefault;
  refuseVariable("ROS_AUTOMATIC_DISCOVERY_RANGE is '" + name +
                 "', which is none of SUBNET, LOCALHOST, OFF and SYSTEM_DEFAULT");
}

/// Returns the addresses of a list with semicolons between them.
std::vector<std::string> peersOf(std::string_view list) {
  std::vector<std::string> peers;
  while (!list.empty()) {
    const size_t end = std::min(list.find(';'), list.size());
    if (end > 0) peers.emplace_back(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  for (const std::string& peer : peers)  // it becomes an attribute of XML
    if (peer.find_first_of("<>&\"'") != std::string::npos)
      refuseVariable("ROS_STATIC_PEERS names the peer '" + peer + "', which is no address");
  return peers;
}

std::string domainOf(const std::string& general, const std::string& discovery) {
  return "<CycloneDDS><Domain>" + (general.empty() ? "" : "<General>" + general + "</General>") +
         (discovery.empty() ? "" : "<Discovery>" + discovery + "</Discovery>") + "</Domain></CycloneDDS>";
}

/// Participants have the ports of the first 33 that are free on this machine, at which the peers are asked.
std::string findable(const std::vector<std::string>& peers) {
  std::string text = "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>";
  if (peers.empty()) return text;
  text += "<Peers>";
  for (const std::string& peer : peers) text += "<Peer address=\"" + peer + "\"/>";
  return text + "</Peers>";
}

}  // namespace

DiscoveryVariables discoveryVariables() {
  return {valueOf("ROS_LOCALHOST_ONLY"), valueOf("ROS_AUTOMATIC_DISCOVERY_RANGE"), valueOf("ROS_STATIC_PEERS"),
          valueOf("ROS_DISTRO")};
}

std::string discoveryConfiguration(const DiscoveryVariables& variables, std::optional<bool> localhostOnly,
                                   uint32_t process) {
  constexpr const char* kNoMulticast = "<AllowMulticast>false</AllowMulticast>";
  const bool localhost = localhostOnly.value_or(variables.localhostOnly == "1");
  if (isBeforeIron(variables.distribution))
    return localhost ? domainOf("<Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>", "") : "";
  if (localhost) return domainOf(kNoMulticast, findable({"localhost"}));

  const Range range = localhostOnly ? Range::subnet : rangeNamed(variables.range);
  if (range == Range::systemDefault) return "";
  if (range == Range::off)
    return domainOf(kNoMulticast, "<ParticipantIndex>none</ParticipantIndex><Tag>ros_discovery_off_" +
                                      std::to_string(process) + "</Tag>");
  std::vector<std::string> peers = peersOf(variables.staticPeers);
  if (range == Range::subnet) return domainOf("", findable(peers));
  peers.insert(peers.begin(), "localhost");
  return domainOf(kNoMulticast, findable(peers));
}

}  // namespace gnosphere::ros2
