// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clients/log/mcap_writer.h"
#include "proto/log/trace.h"

namespace haptic {

/// Origin of a recording: program version, machine, kernel, session name and its configuration as
/// TOML ("" if unknown).
McapMetadata recording_metadata(const std::string& session, const std::string& config_toml);

class TraceWriter {
 public:
  /// Creates the file with these topics, whose names must outlive it. Throws McapError.
  TraceWriter(const std::string& path, const McapMetadata& metadata,
              std::span<const TopicInfo> topics = kTopics);

  /// Appends a record to one of the topics; false if an error has ended the file, see error().
  template <typename T>
  bool write(const Topic<T>& topic, const T& value, const Stamp& stamp) {
    static_assert(kIsWire<T>);
    return write_record(topic.name, std::as_bytes(std::span(&value, 1)), kParts<T>, stamp);
  }

  /// Adds a topic of this program to the file; its name must outlive it.
  void add_topic(const TopicInfo& topic);
  /// Adds a topic of messages of another kind, such as those of ROS that every viewer knows;
  /// returns its channel. `definition` is that of the message with all its nested types.
  uint16_t add_channel(std::string_view topic, std::string_view schema, std::string_view definition,
                       std::string_view what);
  /// Appends a message in CDR to such a channel; false as above.
  bool write_message(uint16_t channel, std::span<const std::byte> message, const Stamp& stamp);

  /// Adds facts known only now, such as the number of lost records.
  void add_metadata(std::string_view name, const McapMetadata& metadata) {
    mcap_.add_metadata(name, metadata);
  }
  void add_attachment(std::string_view name, std::string_view media_type, int64_t realtime_ns,
                      std::span<const std::byte> data) {
    mcap_.add_attachment(name, media_type, static_cast<uint64_t>(realtime_ns), data);
  }
  /// Hands what has been written over to the disk, without waiting for it.
  bool close_chunk() { return mcap_.close_chunk(); }
  /// Waits until what has been written is in the file.
  bool flush() { return mcap_.flush(); }
  bool close() { return mcap_.close(); }
  const std::string& error() const { return mcap_.error(); }
  uint64_t size() const { return mcap_.size(); }
  /// Gives the thread that writes the scheduling policy and priority of the caller.
  void share_priority() { mcap_.share_priority(); }
  /// Records of a topic that are known to be in the file.
  uint64_t written(std::string_view topic) const;

 private:
  bool write_record(std::string_view topic, std::span<const std::byte> record,
                    std::span<const RecordPart> parts, const Stamp& stamp);

  struct Channel {
    std::string_view topic;
    uint16_t id;
  };
  const Channel* find_channel(std::string_view topic) const;

  McapWriter mcap_;
  std::vector<Channel> channels_;
  std::vector<std::byte> message_;
};

}  // namespace haptic
