// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/log/layout.h"
#include "proto/log/mcap.h"
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

inline constexpr Topic<ServoFrame> kServo0Topic{"/servo0/frame"};
inline constexpr Topic<ContactSet> kContact0Topic{"/contact0/set"};
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

struct Stamp {
  int64_t t_ns = 0;         // CLOCK_MONOTONIC
  int64_t realtime_ns = 0;  // the same instant on CLOCK_REALTIME
  uint64_t sequence = 0;    // of the item in its ring, modulo 2³²
};

/// Origin of a recording: program version, machine, kernel, session name and its configuration as
/// TOML ("" if unknown).
McapMetadata recording_metadata(const std::string& session, const std::string& config_toml);

class TraceWriter {
 public:
  /// Creates the file with all topics. Throws McapError.
  TraceWriter(const std::string& path, const McapMetadata& metadata);

  /// Appends a record to one of kTopics; false if an error has ended the file, see error().
  template <typename T>
  bool write(const Topic<T>& topic, const T& value, const Stamp& stamp) {
    static_assert(kIsWire<T>);
    return write_bytes(topic.name, &value, sizeof value, stamp);
  }

  /// Adds facts known only now, such as the number of lost records.
  void add_metadata(std::string_view name, const McapMetadata& metadata) {
    mcap_.add_metadata(name, metadata);
  }
  /// Writes what is still in memory.
  bool flush() { return mcap_.flush(); }
  bool close() { return mcap_.close(); }
  const std::string& error() const { return mcap_.error(); }
  uint64_t size() const { return mcap_.size(); }
  /// Records of a topic in the file, without those of the open chunk.
  uint64_t written(std::string_view topic) const;

 private:
  bool write_bytes(std::string_view topic, const void* value, size_t size, const Stamp& stamp);

  McapWriter mcap_;
  std::array<uint16_t, 5> channels_{};
  std::vector<std::byte> message_;
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
    const TopicInfo info{topic.name, Schema<T>::name, Schema<T>::text, sizeof(T), ""};
    for_each_bytes(info, [&](const std::byte* bytes, const Stamp& stamp) {
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

  /// Topics of this file known to this program.
  std::vector<const TopicInfo*> topics() const;
  const McapReader& mcap() const { return mcap_; }

 private:
  std::optional<Translation> find_translation(const TopicInfo& topic,
                                              const McapChannel& channel) const;

  std::string path_;
  McapReader mcap_;
};

}  // namespace haptic
