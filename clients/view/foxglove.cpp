// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/foxglove.h"

#include <cstring>
#include <span>
#include <stdexcept>

#include "proto/log/trace.h"
#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/version.h"

namespace haptic {
namespace {

constexpr char kMessageData = 1;           // opcode of a binary message
constexpr size_t kMostSubscriptions = 64;  // of a client; a session has fewer channels
constexpr int kWarning = 1;                // level of a status

/// The newest record of a topic. `revision` changes with each record; zero: there is none yet.
struct Record {
  uint64_t revision = 0;
  int64_t realtime_ns = 0;
  std::span<const std::byte> bytes;
  std::span<const RecordPart> parts;
};

template <typename T>
Record record_of(const View& view, bool has, uint64_t revision, int64_t t_ns, const T& record) {
  static_assert(kIsWire<T>);
  if (!has) return {};
  const int64_t offset_ns = view.servo.realtime_ns - view.servo.t_ns;
  return {revision + 1, t_ns + offset_ns, std::as_bytes(std::span(&record, 1)), kParts<T>};
}

struct Channel {
  std::string_view topic;
  Record (*newest)(const View&);
};
constexpr std::array<Channel, 4> kChannels{{
    {servo_topic(kFirstHand).name,
     [](const View& v) { return record_of(v, v.has_servo, v.servo.tick, v.servo.t_ns, v.servo); }},
    {contact_topic(kFirstHand).name,
     [](const View& v) {
       return record_of(v, v.has_contacts, v.contacts.seq, v.contacts.answers_t_ns, v.contacts);
     }},
    {kSimTopic.name,
     [](const View& v) { return record_of(v, v.has_scene, v.scene.seq, v.scene.t_ns, v.scene); }},
    {kControlTopic.name,
     [](const View& v) {
       return record_of(v, v.has_control, v.control.revision, v.control.t_ns, v.control);
     }},
}};

template <typename T>
void append(std::string& out, T number) {
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  out.append(bytes, sizeof number);
}

std::string message_data(uint32_t subscription, const Record& record) {
  std::string out;
  out += kMessageData;
  append(out, subscription);
  append(out, static_cast<uint64_t>(record.realtime_ns));
  std::vector<std::byte> message(kCdrHeader.begin(), kCdrHeader.end());
  pack_message(record.bytes, record.parts, message);
  return out.append(reinterpret_cast<const char*>(message.data()), message.size());
}

uint32_t number_in(const Json& json) {
  if (!json.is_number_unsigned() || json.get<uint64_t>() > UINT32_MAX) {
    throw std::runtime_error("the number of a subscription or channel is wrong");
  }
  return json.get<uint32_t>();
}

void subscribe(FoxgloveClient& client, const Json& message) {
  for (const Json& one : message.at("subscriptions")) {
    const uint32_t id = number_in(one.at("id")), channel = number_in(one.at("channelId"));
    if (channel == 0 || channel > kChannels.size()) {
      throw std::runtime_error("there is no channel " + std::to_string(channel));
    }
    if (client.channels.size() >= kMostSubscriptions) {
      throw std::runtime_error("too many subscriptions");
    }
    client.channels[id] = channel;
    client.sent.erase(id);
  }
}

void unsubscribe(FoxgloveClient& client, const Json& message) {
  for (const Json& one : message.at("subscriptionIds")) {
    client.channels.erase(number_in(one));
    client.sent.erase(number_in(one));
  }
}

}  // namespace

std::string foxglove_server_info(const std::string& session) {
  return json_compact({{"op", "serverInfo"},
                       {"name", "hapticd " + session},
                       {"capabilities", Json::array()},
                       {"supportedEncodings", Json::array()},
                       {"metadata", {{"version", version()}}},
                       {"sessionId", session}});
}

std::string foxglove_advertise() {
  Json channels = Json::array();
  for (size_t i = 0; i < kChannels.size(); ++i) {
    const TopicInfo& topic = *find_topic(kChannels[i].topic);
    channels.push_back({{"id", i + 1},
                        {"topic", topic.name},
                        {"encoding", "cdr"},
                        {"schemaName", topic.schema},
                        {"schema", full_definition(topic.text)},
                        {"schemaEncoding", "ros2msg"}});
  }
  return json_compact({{"op", "advertise"}, {"channels", channels}});
}

std::string hear_foxglove(FoxgloveClient& client, std::string_view text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object()) return "the message is no JSON object";
  try {
    const Json& op = message.at("op");
    if (op == "subscribe") subscribe(client, message);
    if (op == "unsubscribe") unsubscribe(client, message);
    return "";
  } catch (const std::exception& error) {
    return one_line(error.what());
  }
}

std::string foxglove_warning(const std::string& text) {
  return json_compact({{"op", "status"}, {"level", kWarning}, {"message", text}});
}

std::vector<std::string> foxglove_messages(FoxgloveClient& client, const View& view) {
  std::vector<std::string> messages;
  for (const auto& [id, channel] : client.channels) {
    const Record record = kChannels[channel - 1].newest(view);
    if (record.revision == 0 || client.sent[id] == record.revision) continue;
    client.sent[id] = record.revision;
    messages.push_back(message_data(id, record));
  }
  return messages;
}

}  // namespace haptic
