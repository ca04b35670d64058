// SPDX-License-Identifier: Apache-2.0
// Records are an opcode, a length of 8 bytes, and their content. Texts and lists begin with their size in 4 bytes. A
// checksum of 0 means that there is none.
#include "drive/formats/mcap_file.hpp"

#include <algorithm>
#include <map>

#include "base/file.hpp"
#include "drive/bytes.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere::drive {
namespace {

enum Opcode : uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd
};

constexpr char kMagic[] = "\x89MCAP0\r\n";
constexpr size_t kMagicBytes = 8, kRecordHead = 9;

void appendText(std::string& bytes, const std::string& text) {
  append(bytes, static_cast<uint32_t>(text.size()));
  bytes += text;
}

std::string recordOf(Opcode opcode, const std::string& content) {
  std::string record;
  record.reserve(kRecordHead + content.size());
  append(record, static_cast<uint8_t>(opcode));
  append(record, static_cast<uint64_t>(content.size()));
  return record += content;
}

template <typename T>
T numberAt(const std::string& bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

std::string schemaRecord(const McapSchema& schema, uint16_t number) {
  std::string content;
  append(content, number);
  appendText(content, schema.name);
  appendText(content, "ros2msg");
  appendText(content, schema.text);
  return recordOf(kSchema, content);
}

std::string channelRecord(const McapChannel& channel, uint16_t number) {
  std::string content, metadata;
  append(content, number);
  append(content, channel.schema);
  appendText(content, channel.topic);
  appendText(content, "cdr");
  appendText(metadata, "offered_qos_profiles");
  appendText(metadata, qosOf(channel));
  appendText(content, metadata);
  return recordOf(kChannel, content);
}

/// Entries of the file's summary for a chunk.
struct ChunkSummary {
  uint64_t begin = 0, end = 0;  ///< times of its first and last message
  uint64_t offset = 0, bytes = 0, indexBytes = 0, contentBytes = 0;
  std::map<uint16_t, uint64_t> indexOffsets;  ///< by channel
};

/// Returns where the record at `at` of a chunk ends, which has `least` bytes behind its head. Data sets are exchanged,
/// so a chunk may be none that mcapChunk() has made: then it throws Error(format).
uint64_t endOfRecord(const std::filesystem::path& chunk, const std::string& bytes, uint64_t at, uint64_t least) {
  const uint64_t left = bytes.size() - at, length = left < kRecordHead ? 0 : numberAt<uint64_t>(bytes, at + 1);
  if (length < least || length > left - kRecordHead)
    throw Error(ErrorCode::format, chunk.string() + ": is no chunk of a bag; remove it, and its frame is made again");
  return at + kRecordHead + length;
}

/// Reads the records of a chunk, which lie at `offset` of the file, and counts the messages.
ChunkSummary summaryOf(const std::filesystem::path& chunk, const std::string& bytes, uint64_t offset,
                       std::map<uint16_t, uint64_t>& counts) {
  constexpr uint64_t kChunkNumbers = 24, kIndexNumbers = 6;  // bytes that are read of a record
  ChunkSummary summary;
  summary.bytes = endOfRecord(chunk, bytes, 0, kChunkNumbers);
  summary.begin = numberAt<uint64_t>(bytes, kRecordHead);
  summary.end = numberAt<uint64_t>(bytes, kRecordHead + 8);
  summary.contentBytes = numberAt<uint64_t>(bytes, kRecordHead + 16);
  summary.offset = offset;
  summary.indexBytes = bytes.size() - summary.bytes;
  for (uint64_t at = summary.bytes, end = 0; at < bytes.size(); at = end) {
    end = endOfRecord(chunk, bytes, at, kIndexNumbers);
    const auto channel = numberAt<uint16_t>(bytes, at + kRecordHead);
    summary.indexOffsets[channel] = offset + at;
    counts[channel] += numberAt<uint32_t>(bytes, at + kRecordHead + 2) / 16;
  }
  return summary;
}

void appendMap(std::string& bytes, const std::map<uint16_t, uint64_t>& map) {
  append(bytes, static_cast<uint32_t>(map.size() * 10));
  for (const auto& [key, value] : map) {
    append(bytes, key);
    append(bytes, value);
  }
}

std::string chunkIndexRecord(const ChunkSummary& chunk) {
  std::string content;
  for (uint64_t number : {chunk.begin, chunk.end, chunk.offset, chunk.bytes}) append(content, number);
  appendMap(content, chunk.indexOffsets);
  append(content, chunk.indexBytes);
  appendText(content, "");  // no compression
  append(content, chunk.contentBytes);
  append(content, chunk.contentBytes);
  return recordOf(kChunkIndex, content);
}

std::string statisticsRecord(const std::vector<ChunkSummary>& chunks, const std::map<uint16_t, uint64_t>& counts,
                             size_t schemas, size_t channels) {
  uint64_t messages = 0, begin = chunks.empty() ? 0 : UINT64_MAX, end = 0;
  for (const auto& [channel, count] : counts) messages += count;
  for (const ChunkSummary& chunk : chunks) {
    begin = std::min(begin, chunk.begin);
    end = std::max(end, chunk.end);
  }
  std::string content;
  append(content, messages);
  append(content, static_cast<uint16_t>(schemas));
  append(content, static_cast<uint32_t>(channels));
  append(content, uint32_t{0});  // attachments
  append(content, uint32_t{0});  // metadata
  append(content, static_cast<uint32_t>(chunks.size()));
  append(content, begin);
  append(content, end);
  appendMap(content, counts);
  return recordOf(kStatistics, content);
}

}  // namespace

std::string qosOf(const McapChannel& channel) {
  // Durations of the most seconds are without a limit.
  return std::string("- history: 1\n  depth: 10\n  reliability: 1\n  durability: ") + (channel.latched ? "1" : "2") +
         "\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  lifespan:\n    sec: "
         "9223372036\n    nsec: 854775807\n  liveliness: 1\n  liveliness_lease_duration:\n    "
         "sec: 9223372036\n    nsec: 854775807\n  avoid_ros_namespace_conventions: false\n";
}

std::string mcapChunk(std::vector<McapMessage> messages) {
  std::stable_sort(messages.begin(), messages.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  constexpr size_t kMessageHead = 22, kIndexEntry = 16;
  const auto headOf = [&](uint64_t recordBytes) {
    std::string content, head;
    append(content, static_cast<uint64_t>(messages.empty() ? 0 : messages.front().time));
    append(content, static_cast<uint64_t>(messages.empty() ? 0 : messages.back().time));
    append(content, recordBytes);
    append(content, uint32_t{0});
    appendText(content, "");  // no compression
    append(content, recordBytes);
    append(head, static_cast<uint8_t>(kChunk));
    append(head, uint64_t{content.size() + recordBytes});
    return head + content;
  };
  // The messages append to the chunk itself, because clouds are large. Sizes in front of them are set afterwards.
  std::string bytes = headOf(0);
  const size_t start = bytes.size();
  size_t room = start;
  for (const McapMessage& message : messages) room += kRecordHead + kMessageHead + message.bytes + kIndexEntry;
  bytes.reserve(room);
  std::map<uint16_t, std::string> indexes;
  for (const McapMessage& message : messages) {
    std::string& index = indexes[message.channel];
    append(index, static_cast<uint64_t>(message.time));
    append(index, static_cast<uint64_t>(bytes.size() - start));
    append(bytes, static_cast<uint8_t>(kMessage));
    const size_t sizeAt = bytes.size();
    append(bytes, uint64_t{0});
    append(bytes, message.channel);
    append(bytes, message.sequence);
    append(bytes, static_cast<uint64_t>(message.time));
    append(bytes, static_cast<uint64_t>(message.time));
    message.append(bytes);
    const uint64_t size = bytes.size() - sizeAt - sizeof(size);
    std::memcpy(bytes.data() + sizeAt, &size, sizeof(size));
  }
  bytes.replace(0, start, headOf(bytes.size() - start));
  for (const auto& [channel, index] : indexes) {
    std::string entries;
    append(entries, channel);
    appendText(entries, index);
    bytes += recordOf(kMessageIndex, entries);
  }
  return bytes;
}

void writeMcap(const std::filesystem::path& file, const std::vector<McapSchema>& schemas,
               const std::vector<McapChannel>& channels, const std::vector<std::filesystem::path>& chunks) {
  AtomicFile out(file, partOf(file));
  uint64_t offset = 0;
  const auto write = [&](const std::string& bytes) {
    out.write(bytes);
    offset += bytes.size();
  };
  std::string names, header;
  for (size_t i = 0; i < schemas.size(); ++i) names += schemaRecord(schemas[i], static_cast<uint16_t>(i + 1));
  const size_t schemaBytes = names.size();
  for (size_t i = 0; i < channels.size(); ++i) names += channelRecord(channels[i], static_cast<uint16_t>(i + 1));
  appendText(header, "ros2");
  appendText(header, "gnosphere");
  write(std::string(kMagic, kMagicBytes));
  write(recordOf(kHeader, header));
  write(names);

  std::map<uint16_t, uint64_t> counts;
  std::vector<ChunkSummary> summaries;
  for (const std::filesystem::path& chunk : chunks) {
    const std::string bytes = readWholeFile(chunk);
    summaries.push_back(summaryOf(chunk, bytes, offset, counts));
    write(bytes);
  }
  write(recordOf(kDataEnd, std::string(4, '\0')));

  const uint64_t summaryStart = offset;
  std::string groups;
  const auto group = [&](Opcode opcode, const std::string& records) {
    std::string content;
    append(content, static_cast<uint8_t>(opcode));
    append(content, offset);
    append(content, static_cast<uint64_t>(records.size()));
    groups += recordOf(kSummaryOffset, content);
    write(records);
  };
  group(kSchema, names.substr(0, schemaBytes));
  group(kChannel, names.substr(schemaBytes));
  group(kStatistics, statisticsRecord(summaries, counts, schemas.size(), channels.size()));
  std::string indexes;
  for (const ChunkSummary& summary : summaries) indexes += chunkIndexRecord(summary);
  group(kChunkIndex, indexes);
  std::string footer;
  append(footer, summaryStart);
  append(footer, offset);
  append(footer, uint32_t{0});
  write(groups);
  write(recordOf(kFooter, footer));
  write(std::string(kMagic, kMagicBytes));
  out.commit();
}

}  // namespace gnosphere::drive
