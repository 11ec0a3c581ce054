// SPDX-License-Identifier: Apache-2.0
#include "proto/log/trace.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <ranges>
#include <utility>

#include "proto/os/message.h"

namespace haptic {
namespace {

constexpr int64_t kUnread = std::numeric_limits<int64_t>::min();
constexpr int64_t kNoMessage = std::numeric_limits<int64_t>::max();

TopicInfo servo_info(uint32_t hand) {
  return info_of(servo_topic(hand), "one record a servo tick");
}

TopicInfo contact_info(uint32_t hand) {
  return info_of(contact_topic(hand), "answers of collision detection");
}

TopicInfo control_info(uint32_t hand) {
  return info_of(control_topic(hand), "desired state of the session");
}

/// The topics of the hands behind the first, and of the clients.
const std::vector<TopicInfo>& topics_of_others() {
  static const std::vector<TopicInfo> topics = [] {
    std::vector<TopicInfo> all;
    for (uint32_t hand = kFirstHand + 1; hand < kMostHands; ++hand) {
      all.push_back(servo_info(hand));
      all.push_back(contact_info(hand));
      all.push_back(control_info(hand));
    }
    for (uint32_t client = 0; client < kMostClients; ++client) {
      all.push_back(info_of(given_topic(client), "what a client gives"));
    }
    return all;
  }();
  return topics;
}

/// The numbers of a record of this program, of which there are ten thousand.
const Fields& fields_of(const TopicInfo& topic) {
  static std::mutex mutex;
  static std::map<std::string_view, Fields> all;
  const std::lock_guard lock(mutex);
  auto found = all.find(topic.schema);
  if (found == all.end()) found = all.emplace(topic.schema, flatten(topic.text)).first;
  return found->second;
}

}  // namespace

const std::array<TopicInfo, 5> kTopics{
    servo_info(kFirstHand),
    contact_info(kFirstHand),
    info_of(kSimTopic, "poses of the objects"),
    control_info(kFirstHand),
    info_of(kEventTopic, "starts, stops, changes of flags, losses"),
};

const TopicInfo* find_topic(std::string_view name) {
  const auto topic = std::ranges::find(kTopics, name, &TopicInfo::name);
  if (topic != kTopics.end()) return &*topic;
  const std::vector<TopicInfo>& others = topics_of_others();
  const auto other = std::ranges::find(others, name, &TopicInfo::name);
  return other == others.end() ? nullptr : &*other;
}

std::vector<TopicInfo> TraceReader::topics() const {
  std::vector<TopicInfo> out;
  for (const McapChannel& channel : mcap_.channels()) {
    const auto has_schema = [&](const McapSchema& schema) { return schema.id == channel.schema; };
    const auto schema = std::ranges::find_if(mcap_.schemas(), has_schema);
    if (schema == mcap_.schemas().end()) continue;
    const auto add = [&](TopicInfo topic) {
      if (topic.schema != schema->name) return;
      topic.name = channel.topic;
      out.push_back(topic);
    };
    for (const TopicInfo& topic : kTopics) add(topic);
    add(*find_topic(kGivenTopics[0]));
  }
  return out;
}

std::string TraceReader::layout() const {
  const std::string abi = mcap_.metadata("recording", "abi");
  return abi.substr(0, abi.find('.'));
}

std::string TraceReader::notice(const TopicInfo& topic) const {
  const McapChannel* channel = mcap_.find_channel(topic.name);
  if (channel == nullptr) return "";
  const std::optional<Translation> translation = find_stored(topic, *channel).translation;
  std::string lacking;
  for (const std::string& field : translation ? translation->lacking : std::vector<std::string>()) {
    lacking += (lacking.empty() ? "; fields it lacks: " : ", ") + field;
  }
  const std::string number = layout();
  const bool is_ours = number.empty() || number == std::to_string(kAbiMajor);
  if (is_ours && lacking.empty()) return "";
  return "recorded with layout " + (number.empty() ? "of no number" : shown(number)) + lacking;
}

TopicDecoder::Stored TraceReader::find_stored(const TopicInfo& topic,
                                              const McapChannel& channel) const {
  const McapSchema& stored = mcap_.schema_of(channel);
  const auto fail = [&](const std::string& why) {
    throw McapError(path_ + ": topic '" + shown(channel.topic) + "' has another layout of " +
                    std::string(topic.schema) + " that cannot be read: " + why +
                    "; export it with the version that recorded it");
  };
  // its codes 3 and 4 had other meanings
  if (topic.name == kEventTopic.name && layout() == "1") fail("the codes had other meanings");
  if (stored.text == full_definition(topic.text)) {
    return {{topic.parts.begin(), topic.parts.end()}, topic.size, std::nullopt};
  }
  if (stored.encoding != "ros2msg") fail("it is not described as a ROS 2 message");
  try {
    const Fields theirs = flatten_definition(stored.text);
    return {theirs.parts, theirs.bytes, translate(topic.schema, fields_of(topic), theirs)};
  } catch (const std::runtime_error& error) {
    fail(error.what());
  }
  return {};
}

std::optional<TopicDecoder> TraceReader::decoder(const TopicInfo& topic) const {
  const McapChannel* channel = mcap_.find_channel(topic.name);
  if (channel == nullptr) return std::nullopt;
  return TopicDecoder(channel->id, path_ + ": topic '" + shown(channel->topic) + "'",
                      find_stored(topic, *channel));
}

std::shared_ptr<const TraceReader::Chunk> TraceReader::chunk(size_t number) const {
  const auto found = std::ranges::find(kept_, number, [](const auto& one) { return one.first; });
  if (found != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, found);
    return kept_.front().second;
  }
  const auto chunk = std::make_shared<Chunk>();
  chunk->records = mcap_.for_each_in(mcap_.chunks().at(number), [&](const McapMessage& message) {
    chunk->messages[message.channel].push_back(message);
  });
  kept_.emplace_front(number, chunk);
  if (kept_.size() > most_kept_) kept_.pop_back();
  return chunk;
}

/// Adds the chunks that may hold the topic and have not been listed yet.
void TopicCursor::list_chunks() {
  const std::vector<McapChunkIndex>& all = trace_->mcap().chunks();
  for (; decoder_ && listed_ < all.size(); ++listed_) {
    const auto& index = all[listed_].index_offsets;
    if (!index.empty() && !index.contains(decoder_->channel())) continue;
    chunks_.push_back(listed_);
    first_ns_.push_back(kUnread);
  }
}

std::span<const McapMessage> TopicCursor::messages_in(const TraceReader::Chunk& chunk) const {
  const auto found = chunk.messages.find(decoder_->channel());
  if (found == chunk.messages.end()) return {};
  return found->second;
}

/// To the beginning of the next chunk.
void TopicCursor::load() {
  loaded_ = trace_->chunk(chunks_[next_place_]);
  messages_ = messages_in(*loaded_);
  at_ = 0;
  ++next_place_;
}

bool TopicCursor::next(size_t last_chunk) {
  while (at_ == messages_.size()) {
    list_chunks();
    if (next_place_ == chunks_.size() || chunks_[next_place_] > last_chunk) return false;
    load();
  }
  ++at_;
  return true;
}

bool TopicCursor::previous() {
  if (at_ > 0) --at_;
  while (at_ == 0) {
    if (next_place_ < 2) return false;
    next_place_ -= 2;
    load();
    at_ = messages_.size();
  }
  return true;
}

/// Time of the first message of the topic from a chunk on; kNoMessage: there is none.
int64_t TopicCursor::first_from(size_t place) {
  for (; place < chunks_.size(); ++place) {
    int64_t& first_ns = first_ns_[place];
    if (first_ns == kUnread) {
      const auto chunk = trace_->chunk(chunks_[place]);
      const auto messages = messages_in(*chunk);
      first_ns = messages.empty() ? kNoMessage : stamp_of(messages.front()).t_ns;
    }
    if (first_ns != kNoMessage) return first_ns;
  }
  return kNoMessage;
}

bool TopicCursor::seek(int64_t t_ns) {
  rewind();
  list_chunks();
  const auto is_later = [&](const McapMessage& message) { return stamp_of(message).t_ns > t_ns; };
  const auto places = std::views::iota(size_t{0}, chunks_.size());
  auto later =
      std::ranges::partition_point(places, [&](size_t i) { return first_from(i) <= t_ns; });
  if (later == places.begin()) return false;
  next_place_ = *--later;
  load();
  at_ = static_cast<size_t>(std::ranges::find_if(messages_, is_later) - messages_.begin());
  return true;
}

void TopicCursor::rewind() {
  next_place_ = at_ = 0;
  messages_ = {};
}

const std::byte* TopicDecoder::decode(const McapMessage& message) {
  const bool is_cdr = message.data.size() >= kCdrHeader.size() && message.data[1] == kCdrHeader[1];
  if (!is_cdr || !unpack_message(message.data.subspan(kCdrHeader.size()), stored_.parts,
                                 stored_.size, unpacked_)) {
    throw McapError(where_ + " has a message of " + std::to_string(message.data.size()) +
                    " bytes that is not its struct; the file is damaged");
  }
  if (!stored_.translation) return unpacked_.data();
  apply(*stored_.translation, unpacked_.data(), translated_);
  return translated_.data();
}

}  // namespace haptic
