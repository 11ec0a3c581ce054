// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/log/layout.h"
#include "proto/log/mcap.h"
#include "proto/wire/hands.h"
#include "proto/wire/parts.h"
#include "proto/wire/schema.h"
#include "proto/wire/wire.h"

/// Recordings: the wire structs in an MCAP file. A message's payload is the CDR encoding of the
/// struct: four bytes, and the struct packed (layout.h). log_time is CLOCK_REALTIME, publish_time
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
  return {view_of(kServoTopics[hand])};
}
constexpr Topic<ContactSet> contact_topic(uint32_t hand) {
  return {view_of(kContactTopics[hand])};
}
inline constexpr std::array<std::string_view, kMostHands> kControlTopics{
    "/control/frame", "/control1/frame", "/control2/frame", "/control3/frame"};
/// The topic of what people want of a hand.
constexpr Topic<ControlFrame> control_topic(uint32_t hand) {
  return {kControlTopics[hand]};
}
inline constexpr Topic<SceneFrame> kSimTopic{"/sim/frame"};
inline constexpr Topic<ControlFrame> kControlTopic = control_topic(kFirstHand);
inline constexpr Topic<Event> kEventTopic{"/events"};

inline constexpr std::array<std::string_view, kMostClients> kGivenTopics{
    "/client0/given", "/client1/given", "/client2/given", "/client3/given",
    "/client4/given", "/client5/given", "/client6/given", "/client7/given"};

/// Topic of what a client gives, by its index in the session file. A recording has the topic once
/// the client has given.
constexpr Topic<GivenFrame> given_topic(uint32_t client) {
  return {kGivenTopics[client]};
}

/// A topic without its type, for code that handles all topics alike.
struct TopicInfo {
  std::string_view name, schema, text;
  size_t size;                        // of the struct [bytes]
  std::span<const RecordPart> parts;  // of it
  std::string_view what;
};

/// The topics of a recording of one hand.
extern const std::array<TopicInfo, 5> kTopics;

/// Finds a topic of any hand or client by its name; nullptr if there is none.
const TopicInfo* find_topic(std::string_view name);

/// The struct of a topic, without its type.
template <typename T>
constexpr TopicInfo info_of(const Topic<T>& topic, std::string_view what = "") {
  return {topic.name, Schema<T>::name, Schema<T>::text, sizeof(T), kParts<T>, what};
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

/// CDR, little endian, as in ROS 2: the begin of a message; alignment counts from after these
/// bytes.
inline constexpr std::array<std::byte, 4> kCdrHeader{std::byte{0}, std::byte{1}, std::byte{0},
                                                     std::byte{0}};

/// Turns the messages of one topic of a file into records of this program's layout.
class TopicDecoder {
 public:
  /// The record in a message of the channel: topic.size bytes, unaligned, valid until the next
  /// call. Throws McapError if the message is not its struct.
  const std::byte* decode(const McapMessage& message);
  uint16_t channel() const { return channel_; }

 private:
  friend class TraceReader;
  /// How the records of a channel lie in memory, and how they become this program's; none: they
  /// are.
  struct Stored {
    std::vector<RecordPart> parts;
    size_t size = 0;  // [bytes]
    std::optional<Translation> translation;
  };
  TopicDecoder(uint16_t channel, std::string where, Stored stored)
      : channel_(channel), where_(std::move(where)), stored_(std::move(stored)) {}

  uint16_t channel_;
  std::string where_;  // "file: topic 't'", for messages
  Stored stored_;
  std::vector<std::byte> unpacked_, translated_;
};

/// A recording that is read by its topics. Not for two threads at once.
class TraceReader {
 public:
  /// Keeps the last `most_kept` chunks that were unpacked, for cursors that go to and fro. Throws
  /// McapError.
  explicit TraceReader(const std::string& path, size_t most_kept = 1)
      : path_(path), mcap_(path), most_kept_(most_kept) {}
  TraceReader(const TraceReader&) = delete;

  /// Passes every record of the topic in file order, in the layout of this program; none if the
  /// file has none. Throws McapError if its own layout cannot be translated.
  template <typename T>
  void for_each(const Topic<T>& topic,
                const std::function<void(const T&, const Stamp&)>& use) const;

  template <typename T>
  std::vector<T> read(const Topic<T>& topic) const {
    std::vector<T> out;
    for_each<T>(topic, [&](const T& value, const Stamp&) { out.push_back(value); });
    return out;
  }

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
  friend class TopicCursor;
  /// A chunk, unpacked: its messages by channel, and the bytes that hold them.
  struct Chunk {
    std::map<uint16_t, std::vector<McapMessage>> messages;
    std::vector<char> records;
  };
  std::shared_ptr<const Chunk> chunk(size_t number) const;
  TopicDecoder::Stored find_stored(const TopicInfo& topic, const McapChannel& channel) const;

  std::string path_;
  McapReader mcap_;
  size_t most_kept_;
  mutable std::list<std::pair<size_t, std::shared_ptr<const Chunk>>> kept_;  // the last used first
};

/// Walks the records of one topic, forwards or backwards, from the beginning or an instant on: by
/// the index of the file's chunks, and of a file without an end by trying them. Memory holds one
/// chunk and what the reader keeps, however long the file. A file may grow meanwhile
/// (McapReader::refresh). All functions throw McapError where a chunk is damaged.
class TopicCursor {
 public:
  /// The reader must outlive it. A topic that the file lacks has no records.
  TopicCursor(const TraceReader& trace, const TopicInfo& topic)
      : trace_(&trace), decoder_(trace.decoder(topic)) {}

  /// To the next record in file order, in the beginning to the first; false at the end. A record
  /// in a chunk with a higher number than `last_chunk` is left for later.
  bool next(size_t last_chunk = std::numeric_limits<size_t>::max());
  /// Back to the record before; false, and before the first, if there is none.
  bool previous();
  /// To the last record that was published at t_ns or before, [ns] of CLOCK_MONOTONIC; false, and
  /// before the first, if there is none. Takes the records to be in the order of time.
  bool seek(int64_t t_ns);
  /// Before the first record.
  void rewind();

  /// The record it is at: topic.size bytes, unaligned, valid until the cursor moves or reads again.
  const std::byte* bytes() { return decoder_->decode(messages_[at_ - 1]); }
  template <typename T>
  T read() {
    T record;
    std::memcpy(&record, bytes(), sizeof record);
    return record;
  }
  Stamp stamp() const { return stamp_of(messages_[at_ - 1]); }

 private:
  void list_chunks();
  void load();
  int64_t first_from(size_t place);
  std::span<const McapMessage> messages_in(const TraceReader::Chunk& chunk) const;

  const TraceReader* trace_;
  std::optional<TopicDecoder> decoder_;
  std::vector<size_t> chunks_;     // those that may hold the topic
  std::vector<int64_t> first_ns_;  // of its messages in each; kUnread, or kNoMessage
  size_t listed_ = 0;              // chunks of the file that were looked at for `chunks_`
  size_t next_place_ = 0;          // in chunks_, after that of messages_
  std::shared_ptr<const TraceReader::Chunk> loaded_;
  std::span<const McapMessage> messages_;  // in it
  size_t at_ = 0;                          // the next one
};

template <typename T>
void TraceReader::for_each(const Topic<T>& topic,
                           const std::function<void(const T&, const Stamp&)>& use) const {
  TopicCursor cursor(*this, info_of(topic));
  while (cursor.next()) use(cursor.read<T>(), cursor.stamp());
}

}  // namespace haptic
