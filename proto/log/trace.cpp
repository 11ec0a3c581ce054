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

void TraceReader::for_each_bytes(
    const TopicInfo& topic, const std::function<void(const std::byte*, const Stamp&)>& use) const {
  const McapChannel* channel = mcap_.find_channel(topic.name);
  if (channel == nullptr) return;
  const std::string where = path_ + ": topic '" + shown(channel->topic) + "' ";
  if (mcap_.schema_of(*channel).text != full_definition(topic.text)) {
    throw McapError(where + "was recorded with another layout of " + std::string(topic.schema) +
                    "; export it with the version that recorded it");
  }
  mcap_.for_each(channel->id, [&](const McapMessage& message) {
    if (message.data.size() != kCdrHeader.size() + topic.size || message.data[1] != kCdrHeader[1]) {
      throw McapError(where + "has a message of " + std::to_string(message.data.size()) +
                      " bytes that is not its struct; the file is damaged");
    }
    use(message.data.data() + kCdrHeader.size(),
        {static_cast<int64_t>(message.publish_time_ns), static_cast<int64_t>(message.log_time_ns),
         message.sequence});
  });
}

}  // namespace haptic
