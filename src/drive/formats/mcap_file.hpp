// SPDX-License-Identifier: Apache-2.0
// MCAP (https://mcap.dev/spec): chunks of messages, and the file that is made of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace gnosphere::drive {

struct McapSchema {
  std::string name, text;  ///< a ROS 2 message definition
};
struct McapChannel {
  uint16_t schema = 1;  ///< number of the schema, from 1 on
  std::string topic;
  bool latched = false;  ///< whether late subscribers get the last message, as of /tf_static
};
/// Returns the quality of service of a channel as rosbag2 keeps it, which is YAML.
std::string qosOf(const McapChannel& channel);

struct McapMessage {
  uint16_t channel = 1;  ///< number of the channel, from 1 on
  uint32_t sequence = 0;
  int64_t time = 0;                                  ///< nanoseconds since 1970
  size_t bytes = 0;                                  ///< about the size of the content, for which room is made
  std::function<void(std::string& records)> append;  ///< appends the content, which is CDR
};

/// Returns a chunk and its message indexes. The messages are sorted by time.
std::string mcapChunk(std::vector<McapMessage> messages);

/// Writes a file of the chunks that mcapChunk() has made, each in a file of its own.
void writeMcap(const std::filesystem::path& file, const std::vector<McapSchema>& schemas,
               const std::vector<McapChannel>& channels, const std::vector<std::filesystem::path>& chunks);

}  // namespace gnosphere::drive
