// SPDX-License-Identifier: Apache-2.0
#include "proto/log/trace.h"

#include <algorithm>
#include <utility>

#include "proto/os/message.h"

namespace haptic {
const std::array<TopicInfo, 5> kTopics{
    info_of(servo_topic(kFirstHand), "one record a servo tick"),
    info_of(contact_topic(kFirstHand), "answers of collision detection"),
    info_of(kSimTopic, "poses of the objects"),
    info_of(kControlTopic, "desired state of the session"),
    info_of(kEventTopic, "starts, stops, changes of flags, losses"),
};

const TopicInfo* find_topic(std::string_view name) {
  for (const TopicInfo& topic : kTopics) {
    if (topic.name == name) return &topic;
  }
  return nullptr;
}

TraceReader::TraceReader(const std::string& path) : path_(path), mcap_(path) {}

std::vector<TopicInfo> TraceReader::topics() const {
  std::vector<TopicInfo> out;
  for (const McapChannel& channel : mcap_.channels()) {
    const auto has_schema = [&](const McapSchema& schema) { return schema.id == channel.schema; };
    const auto schema = std::ranges::find_if(mcap_.schemas(), has_schema);
    if (schema == mcap_.schemas().end()) continue;
    for (TopicInfo topic : kTopics) {
      if (topic.schema != schema->name) continue;
      topic.name = channel.topic;
      out.push_back(topic);
    }
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

std::optional<TopicDecoder> TraceReader::decoder(const TopicInfo& topic) const {
  const McapChannel* channel = mcap_.find_channel(topic.name);
  if (channel == nullptr) return std::nullopt;
  std::optional<Translation> translation = find_translation(topic, *channel);
  const size_t size = translation ? translation->stored_size : topic.size;
  return TopicDecoder(channel->id, path_ + ": topic '" + shown(channel->topic) + "'", size,
                      std::move(translation));
}

void TraceReader::for_each_bytes(
    const TopicInfo& topic, const std::function<void(const std::byte*, const Stamp&)>& use) const {
  std::optional<TopicDecoder> decoder = this->decoder(topic);
  if (!decoder) return;
  mcap_.for_each(decoder->channel(), [&](const McapMessage& message) {
    use(decoder->decode(message), stamp_of(message));
  });
}

TopicDecoder::TopicDecoder(uint16_t channel, std::string where, size_t size,
                           std::optional<Translation> translation)
    : channel_(channel),
      where_(std::move(where)),
      size_(size),
      translation_(std::move(translation)) {}

const std::byte* TopicDecoder::decode(const McapMessage& message) {
  if (message.data.size() != kCdrHeader.size() + size_ || message.data[1] != kCdrHeader[1]) {
    throw McapError(where_ + " has a message of " + std::to_string(message.data.size()) +
                    " bytes that is not its struct; the file is damaged");
  }
  const std::byte* record = message.data.data() + kCdrHeader.size();
  if (!translation_) return record;
  apply(*translation_, record, translated_);
  return translated_.data();
}

}  // namespace haptic
