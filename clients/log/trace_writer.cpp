// SPDX-License-Identifier: Apache-2.0
#include "clients/log/trace_writer.h"

#include <sys/utsname.h>

#include <algorithm>

#include "proto/os/version.h"

namespace haptic {

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

TraceWriter::TraceWriter(const std::string& path, const McapMetadata& metadata,
                         std::span<const TopicInfo> topics)
    : mcap_(path) {
  for (const TopicInfo& topic : topics) add_topic(topic);
  mcap_.add_metadata("recording", metadata);
  // who reads the file from here on finds its topics
  if (!mcap_.flush()) throw McapError(mcap_.error());
}

void TraceWriter::add_topic(const TopicInfo& topic) {
  const std::string text = full_definition(topic.text);
  channels_.push_back({topic.name, add_channel(topic.name, topic.schema, text, topic.what)});
}

uint16_t TraceWriter::add_channel(std::string_view topic, std::string_view schema,
                                  std::string_view definition, std::string_view what) {
  return mcap_.add_channel(mcap_.add_schema(schema, "ros2msg", definition), topic, "cdr",
                           {{"what", std::string(what)},
                            {"log_time", "CLOCK_REALTIME"},
                            {"publish_time", "CLOCK_MONOTONIC"}});
}

bool TraceWriter::write_message(uint16_t channel, std::span<const std::byte> message,
                                const Stamp& stamp) {
  return mcap_.write({channel, static_cast<uint32_t>(stamp.sequence),
                      static_cast<uint64_t>(stamp.realtime_ns), static_cast<uint64_t>(stamp.t_ns),
                      message});
}

const TraceWriter::Channel* TraceWriter::find_channel(std::string_view topic) const {
  const auto channel = std::ranges::find(channels_, topic, &Channel::topic);
  return channel == channels_.end() ? nullptr : &*channel;
}

bool TraceWriter::write_record(std::string_view topic, std::span<const std::byte> record,
                               std::span<const RecordPart> parts, const Stamp& stamp) {
  const Channel* channel = find_channel(topic);
  if (channel == nullptr) {
    throw McapError("'" + std::string(topic) + "' is not a topic of this recording");
  }
  message_.assign(kCdrHeader.begin(), kCdrHeader.end());
  pack_message(record, parts, message_);
  return write_message(channel->id, message_, stamp);
}

uint64_t TraceWriter::written(std::string_view topic) const {
  const Channel* channel = find_channel(topic);
  return channel == nullptr ? 0 : mcap_.written(channel->id);
}

}  // namespace haptic
