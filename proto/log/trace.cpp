// SPDX-License-Identifier: Apache-2.0
#include "proto/log/trace.h"

#include <sys/utsname.h>

#include "proto/os/message.h"
#include "proto/os/version.h"

namespace haptic {
namespace {

// CDR, little endian, as in ROS 2; alignment counts from after these bytes
constexpr std::array<std::byte, 4> kCdrHeader{std::byte{0}, std::byte{1}, std::byte{0},
                                              std::byte{0}};

template <typename T>
constexpr TopicInfo info(const Topic<T>& topic, std::string_view what) {
  return {topic.name, Schema<T>::name, Schema<T>::text, sizeof(T), what};
}

}  // namespace

const std::array<TopicInfo, 5> kTopics{
    info(kServo0Topic, "one record a servo tick"),
    info(kContact0Topic, "answers of collision detection"),
    info(kSimTopic, "poses of the objects"),
    info(kControlTopic, "desired state of the session"),
    info(kEventTopic, "starts, stops, changes of flags, losses"),
};

const TopicInfo* find_topic(std::string_view name) {
  for (const TopicInfo& topic : kTopics) {
    if (topic.name == name) return &topic;
  }
  return nullptr;
}

McapMetadata recording_metadata(const std::string& session, const std::string& config_toml) {
  utsname machine{};
  ::uname(&machine);
  return {
      {"version", version()},
      {"abi", std::to_string(kAbiMajor) + "." + std::to_string(kAbiMinor)},
      {"session", session},
      {"config", config_toml},
      {"host", machine.nodename},
      {"kernel", std::string(machine.sysname) + " " + machine.release + " " + machine.machine},
  };
}

TraceWriter::TraceWriter(const std::string& path, const McapMetadata& metadata) : mcap_(path) {
  for (size_t i = 0; i < kTopics.size(); ++i) {
    const TopicInfo& topic = kTopics[i];
    const uint16_t schema = mcap_.add_schema(topic.schema, "ros2msg", full_definition(topic.text));
    channels_[i] = mcap_.add_channel(schema, topic.name, "cdr",
                                     {{"what", std::string(topic.what)},
                                      {"log_time", "CLOCK_REALTIME"},
                                      {"publish_time", "CLOCK_MONOTONIC"}});
  }
  mcap_.add_metadata("recording", metadata);
  if (!mcap_.error().empty()) throw McapError(mcap_.error());
}

bool TraceWriter::write_bytes(std::string_view topic, const void* value, size_t size,
                              const Stamp& stamp) {
  // the struct is its own CDR encoding, checked in schema.cpp
  const std::byte* bytes = static_cast<const std::byte*>(value);
  message_.assign(kCdrHeader.begin(), kCdrHeader.end());
  message_.insert(message_.end(), bytes, bytes + size);
  const TopicInfo* info = find_topic(topic);
  if (info == nullptr) throw McapError("'" + std::string(topic) + "' is not a topic of recordings");
  const size_t index = static_cast<size_t>(info - kTopics.data());
  return mcap_.write({channels_[index], static_cast<uint32_t>(stamp.sequence),
                      static_cast<uint64_t>(stamp.realtime_ns), static_cast<uint64_t>(stamp.t_ns),
                      message_});
}

uint64_t TraceWriter::written(std::string_view topic) const {
  const TopicInfo* info = find_topic(topic);
  return info == nullptr ? 0 : mcap_.written(channels_[static_cast<size_t>(info - kTopics.data())]);
}

TraceReader::TraceReader(const std::string& path) : path_(path), mcap_(path) {}

std::vector<const TopicInfo*> TraceReader::topics() const {
  std::vector<const TopicInfo*> out;
  for (const McapChannel& channel : mcap_.channels()) {
    const TopicInfo* topic = find_topic(channel.topic);
    if (topic != nullptr) out.push_back(topic);
  }
  return out;
}

std::string TraceReader::layout() const {
  const auto recording = mcap_.metadata().find("recording");
  if (recording == mcap_.metadata().end()) return "";
  const auto abi = recording->second.find("abi");
  return abi == recording->second.end() ? "" : abi->second.substr(0, abi->second.find('.'));
}

std::string TraceReader::notice(const TopicInfo& topic) const {
  const McapChannel* channel = mcap_.find_channel(topic.name);
  if (channel == nullptr) return "";
  const std::optional<Translation> translation = find_translation(topic, *channel);
  std::string lacking;
  for (const std::string& field : translation ? translation->lacking : std::vector<std::string>()) {
    lacking += (lacking.empty() ? "; fields it lacks: " : ", ") + field;
  }
  const std::string number = layout();
  const bool is_ours = number.empty() || number == std::to_string(kAbiMajor);
  if (is_ours && lacking.empty()) return "";
  return "recorded with layout " + (number.empty() ? "of no number" : shown(number)) + lacking;
}

/// Empty if the file's records have this program's layout.
std::optional<Translation> TraceReader::find_translation(const TopicInfo& topic,
                                                         const McapChannel& channel) const {
  const McapSchema& stored = mcap_.schema_of(channel);
  const auto fail = [&](const std::string& why) {
    throw McapError(path_ + ": topic '" + shown(channel.topic) + "' has another layout of " +
                    std::string(topic.schema) + " that cannot be read: " + why +
                    "; export it with the version that recorded it");
  };
  // its codes 3 and 4 had other meanings
  if (topic.name == kEventTopic.name && layout() == "1") fail("the codes had other meanings");
  if (stored.text == full_definition(topic.text)) return std::nullopt;
  if (stored.encoding != "ros2msg") fail("it is not described as a ROS 2 message");
  try {
    return translate(topic.schema, flatten(topic.text), stored.text);
  } catch (const std::runtime_error& error) {
    fail(error.what());
  }
  return std::nullopt;
}

void TraceReader::for_each_bytes(
    const TopicInfo& topic, const std::function<void(const std::byte*, const Stamp&)>& use) const {
  const McapChannel* channel = mcap_.find_channel(topic.name);
  if (channel == nullptr) return;
  const std::optional<Translation> translation = find_translation(topic, *channel);
  const size_t size = translation ? translation->stored_size : topic.size;
  std::vector<std::byte> translated;
  mcap_.for_each(channel->id, [&](const McapMessage& message) {
    if (message.data.size() != kCdrHeader.size() + size || message.data[1] != kCdrHeader[1]) {
      throw McapError(path_ + ": topic '" + shown(channel->topic) + "' has a message of " +
                      std::to_string(message.data.size()) +
                      " bytes that is not its struct; the file is damaged");
    }
    const std::byte* record = message.data.data() + kCdrHeader.size();
    if (translation) {
      apply(*translation, record, translated);
      record = translated.data();
    }
    use(record, {static_cast<int64_t>(message.publish_time_ns),
                 static_cast<int64_t>(message.log_time_ns), message.sequence});
  });
}

}  // namespace haptic
