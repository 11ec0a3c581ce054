// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/log/layout.h"
#include "proto/log/mcap.h"
#include "proto/wire/hands.h"
#include "proto/wire/schema.h"
#include "proto/wire/wire.h"

/// Recordings: the wire structs in an MCAP file. A message's payload is the CDR encoding of the
/// struct: four bytes and the struct itself. log_time is CLOCK_REALTIME, publish_time
/// CLOCK_MONOTONIC. Older recordings hold other layouts of the structs; they are read by the
/// definitions in the file (layout.h).
namespace haptic {

/// A topic of a recording and the struct it carries.
template <typename T>
struct Topic {
  std::string_view name;
};

inline constexpr HandNames kServoTopics = names_of_hands("/servo", "/frame");
inline constexpr HandNames kContactTopics = names_of_hands("/contact", "/set");

/// The topics of a hand's servo and contact.
constexpr Topic<ServoFrame> servo_topic(uint32_t hand) {
  return {kServoTopics[hand].data()};
}
constexpr Topic<ContactSet> contact_topic(uint32_t hand) {
  return {kContactTopics[hand].data()};
}
inline constexpr Topic<SceneFrame> kSimTopic{"/sim/frame"};
inline constexpr Topic<ControlFrame> kControlTopic{"/control/frame"};
inline constexpr Topic<Event> kEventTopic{"/events"};

/// A topic without its type, for code that handles all topics alike.
struct TopicInfo {
  std::string_view name, schema, text;
  size_t size;  // of the struct [bytes]
  std::string_view what;
};

/// The topics of a recording of this version.
extern const std::array<TopicInfo, 5> kTopics;

/// nullptr if there is no such topic.
const TopicInfo* find_topic(std::string_view name);

/// The struct of a topic, without its type.
template <typename T>
constexpr TopicInfo info_of(const Topic<T>& topic, std::string_view what = "") {
  return {topic.name, Schema<T>::name, Schema<T>::text, sizeof(T), what};
}

struct Stamp {
  int64_t t_ns = 0;         // CLOCK_MONOTONIC
  int64_t realtime_ns = 0;  // the same instant on CLOCK_REALTIME
  uint64_t sequence = 0;    // of the item in its ring, modulo 2³²
};
inline Stamp stamp_of(const McapMessage& message) {
  return {static_cast<int64_t>(message.publish_time_ns), static_cast<int64_t>(message.log_time_ns),
          message.sequence};
}

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
    return write_bytes(topic.name, &value, sizeof value, stamp);
  }

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
  bool write_bytes(std::string_view topic, const void* value, size_t size, const Stamp& stamp);

  struct Channel {
    std::string_view topic;
    uint16_t id;
  };
  const Channel* find_channel(std::string_view topic) const;

  McapWriter mcap_;
  std::vector<Channel> channels_;
  std::vector<std::byte> message_;
};

/// Turns the messages of one topic of a file into records of this program's layout.
class TopicDecoder {
 public:
  /// The record in a message of the channel: topic.size bytes, unaligned, valid until the next
  /// call or as long as the message. Throws McapError if the message is not its struct.
  const std::byte* decode(const McapMessage& message);
  uint16_t channel() const { return channel_; }

 private:
  friend class TraceReader;
  TopicDecoder(uint16_t channel, std::string where, size_t size,
               std::optional<Translation> translation);

  uint16_t channel_;
  std::string where_;  // "file: topic 't'", for messages
  size_t size_;        // of a record in the file [bytes]
  std::optional<Translation> translation_;
  std::vector<std::byte> translated_;
};

class TraceReader {
 public:
  /// Throws McapError.
  explicit TraceReader(const std::string& path);

  /// Passes every record of the topic in file order, in the layout of this program; none if the
  /// file has none. Throws McapError if its own layout cannot be translated.
  template <typename T>
  void for_each(const Topic<T>& topic,
                const std::function<void(const T&, const Stamp&)>& use) const {
    for_each_bytes(info_of(topic), [&](const std::byte* bytes, const Stamp& stamp) {
      std::array<std::byte, sizeof(T)> record;
      std::memcpy(record.data(), bytes, sizeof(T));
      use(std::bit_cast<T>(record), stamp);
    });
  }

  template <typename T>
  std::vector<T> read(const Topic<T>& topic) const {
    std::vector<T> out;
    for_each<T>(topic, [&](const T& value, const Stamp&) { out.push_back(value); });
    return out;
  }

  /// Without the type: `topic.size` bytes per record, unaligned.
  void for_each_bytes(const TopicInfo& topic,
                      const std::function<void(const std::byte*, const Stamp&)>& use) const;

  /// Number of the layout (kAbiMajor) that the file was recorded with; "": it does not say.
  std::string layout() const;
  /// For people, if the records have another layout than this program's: its number, and the fields
  /// that it lacks, with the defaults used instead; else "".
  std::string notice(const TopicInfo& topic) const;

  /// For a topic of this file with the records of `topic`; none if the file has no such topic.
  /// Throws McapError if its layout cannot be translated.
  std::optional<TopicDecoder> decoder(const TopicInfo& topic) const;

  /// Topics of this file with records of this program, of whatever name; `name` and `what` are
  /// valid as long as this reader. Other topics are ignored.
  std::vector<TopicInfo> topics() const;
  const McapReader& mcap() const { return mcap_; }
  McapReader& mcap() { return mcap_; }

 private:
  std::optional<Translation> find_translation(const TopicInfo& topic,
                                              const McapChannel& channel) const;

  std::string path_;
  McapReader mcap_;
};

}  // namespace haptic
