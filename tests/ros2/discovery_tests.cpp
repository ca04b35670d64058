// SPDX-License-Identifier: Apache-2.0
// Tests of who finds whom: the variables of ROS 2 that say so, and listeners with the configuration of rmw_cyclonedds.
#include <catch2/matchers/catch_matchers_string.hpp>

#include "gnosphere/error.hpp"
#include "gnosphere/ros2.hpp"
#include "ros2/discovery.hpp"
#include "ros2/listening.hpp"

using namespace gnosphere;
using namespace gnosphere::ros2;
using namespace gnosphere::test;
using Catch::Matchers::ContainsSubstring;

namespace {

// The texts that rmw_cyclonedds of Iron, Jazzy and Rolling puts before CYCLONEDDS_URI.
constexpr const char* kLocalhost =
    "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    "<Peers><Peer address=\"localhost\"/></Peers></Discovery></Domain></CycloneDDS>";
constexpr const char* kSubnet =
    "<CycloneDDS><Domain><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex></Discovery></Domain></CycloneDDS>";
constexpr const char* kOff =
    "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>none</ParticipantIndex><Tag>ros_discovery_off_77</Tag></Discovery></Domain></CycloneDDS>";
constexpr const char* kHumbleLocalhost =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces></General>"
    "</Domain></CycloneDDS>";

std::string textOf(const DiscoveryVariables& variables, std::optional<bool> localhostOnly = {}) {
  return discoveryConfiguration(variables, localhostOnly, 77);
}

/// An environment variable with another value for a while.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* const before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~Variable() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

}  // namespace

TEST_CASE("ROS 2: the range of discovery is configured as rmw_cyclonedds does it") {
  CHECK(textOf({}) == kSubnet);
  CHECK(textOf({.range = "SUBNET"}) == kSubnet);
  CHECK(textOf({.range = "LOCALHOST"}) == kLocalhost);
  CHECK(textOf({.range = "OFF"}) == kOff);
  CHECK(textOf({.range = "SYSTEM_DEFAULT"}).empty());
  CHECK(textOf({.localhostOnly = "1"}) == kLocalhost);
  CHECK(textOf({.localhostOnly = "0"}) == kSubnet);
  CHECK(textOf({.localhostOnly = "1", .range = "OFF", .staticPeers = "10.0.0.1"}) == kLocalhost);
  CHECK(textOf({.localhostOnly = "1", .range = "nonsense"}) == kLocalhost);
  for (const char* name : {"localhost", "nonsense", " SUBNET"})
    CHECK_THROWS_WITH(textOf({.range = name}), "ros2::Publisher: ROS_AUTOMATIC_DISCOVERY_RANGE is '" +
                                                   std::string(name) +
                                                   "', which is none of SUBNET, LOCALHOST, OFF and SYSTEM_DEFAULT");
  // The choice of a program goes before the environment.
  CHECK(textOf({.range = "OFF", .staticPeers = "10.0.0.1"}, true) == kLocalhost);
  CHECK(textOf({.localhostOnly = "1", .range = "OFF"}, false) == kSubnet);
}

TEST_CASE("ROS 2: static peers are asked on this machine and on the network") {
  const std::string listed = "<Peer address=\"192.0.2.2\"/><Peer address=\"robot\"/></Peers>";
  for (const char* list : {"192.0.2.2;robot", ";192.0.2.2;;robot;"}) {
    CHECK_THAT(textOf({.range = "LOCALHOST", .staticPeers = list}),
               ContainsSubstring("<Peers><Peer address=\"localhost\"/>" + listed));
    CHECK_THAT(textOf({.staticPeers = list}), ContainsSubstring("<Peers>" + listed));
    CHECK_THAT(textOf({.staticPeers = list}, false), ContainsSubstring("<Peers>" + listed));
    CHECK(textOf({.range = "OFF", .staticPeers = list}) == kOff);
    CHECK(textOf({.range = "SYSTEM_DEFAULT", .staticPeers = list}).empty());
  }
  for (const char* peer : {"a<b", "a>b", "a&b", "a\"b", "a'b"})
    CHECK_THROWS_WITH(textOf({.staticPeers = std::string("10.0.0.1;") + peer}),
                      ContainsSubstring("the peer '" + std::string(peer) + "', which is no address"));
}

TEST_CASE("ROS 2: Humble and older distributions know this machine only, or nothing") {
  for (const char* name : {"humble", "galactic", "foxy"}) {
    CHECK(textOf({.localhostOnly = "1", .distribution = name}) == kHumbleLocalhost);
    CHECK(textOf({.distribution = name}, true) == kHumbleLocalhost);
    CHECK(textOf({.distribution = name}).empty());
    CHECK(textOf({.range = "LOCALHOST", .staticPeers = "10.0.0.1", .distribution = name}).empty());
    CHECK(textOf({.localhostOnly = "1", .distribution = name}, false).empty());
  }
  for (const char* name : {"iron", "jazzy", "kilted", "rolling"})
    CHECK(textOf({.localhostOnly = "1", .distribution = name}) == kLocalhost);
}

TEST_CASE("ROS 2: a node on this machine hears a publisher on this machine, and none whose discovery is off") {
  loopbackDomain();
  const Variable configuration("CYCLONEDDS_URI", std::string(kLocalhost) + ",");
  const auto heard = [](const char* variable, const char* value) {
    PublisherOptions options;
    options.qos = {.durability = Qos::Durability::transientLocal, .depth = 1};
    std::optional<Publisher> publisher;
    {
      const Variable none("CYCLONEDDS_URI", ""), chosen(variable, value);
      publisher.emplace(MessageType::clock, "time", options);
    }
    publisher->publish(Clock{5});
    REQUIRE(publisher->flush(10));
    const bool expected = value != std::string("OFF");
    Listener listener({.type = "clock", .qos = "latched", .seconds = expected ? 20 : 2}, {"rt/time"});
    return listener.lines();
  };
  const std::vector<std::string> wanted = {"rt/time 0.000000005"};
  CHECK(heard("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST") == wanted);
  CHECK(heard("ROS_LOCALHOST_ONLY", "1") == wanted);
  CHECK(heard("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET") == wanted);
  CHECK(heard("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF").empty());
}

TEST_CASE("ROS 2: topics of a domain look for subscribers in one way") {
  loopbackDomain();
  PublisherOptions options;
  options.localhostOnly = true;
  const Publisher first(MessageType::clock, "first", options);
  options.localhostOnly = false;
  CHECK_THROWS_WITH(Publisher(MessageType::clock, "second", options),
                    ContainsSubstring("other topics of the domain") && ContainsSubstring("another range of discovery"));
  const Variable range("ROS_AUTOMATIC_DISCOVERY_RANGE", "everywhere");
  CHECK_THROWS_WITH(Publisher(MessageType::clock, "third"), ContainsSubstring("is 'everywhere', which is none of"));
}
