// SPDX-License-Identifier: Apache-2.0
#include "clients/log/recover.h"

#include <map>

#include "clients/log/mcap_writer.h"
#include "proto/log/mcap.h"

namespace haptic {
namespace {

/// Writes messages under the channel numbers of the copy.
class Copy {
 public:
  Copy(const McapReader& from, const std::string& to) : to_(to) {
    for (const McapSchema& schema : from.schemas()) {
      schemas_[schema.id] = to_.add_schema(schema.name, schema.encoding, schema.text);
    }
    for (const McapChannel& channel : from.channels()) {
      const auto schema = schemas_.find(channel.schema);
      const uint16_t none = 0;
      channels_[channel.id] = {to_.add_channel(schema == schemas_.end() ? none : schema->second,
                                               channel.topic, channel.encoding, channel.metadata),
                               channel.topic};
    }
    for (const auto& [name, metadata] : from.metadata()) to_.add_metadata(name, metadata);
  }

  /// Ignores a message of a channel that the file does not describe.
  void add(McapMessage message, Recovered& out) {
    const auto channel = channels_.find(message.channel);
    if (channel == channels_.end()) return;
    message.channel = channel->second.id;
    to_.write(message);
    ++out.messages[channel->second.topic];
  }

  void add(const McapReader& from, const McapAttachment& attachment) {
    to_.add_attachment(attachment.name, attachment.media_type, attachment.log_time_ns,
                       from.read_attachment(attachment));
  }

  McapWriter& file() { return to_; }

 private:
  struct Channel {
    uint16_t id = 0;
    std::string topic;
  };
  McapWriter to_;
  std::map<uint16_t, uint16_t> schemas_;
  std::map<uint16_t, Channel> channels_;
};

}  // namespace

Recovered recover_log(const std::string& from, const std::string& to) {
  const McapReader reader(from);
  Recovered out;
  out.had_end = reader.finished();
  Copy copy(reader, to);
  for (const McapAttachment& attachment : reader.attachments()) {
    try {
      copy.add(reader, attachment);
      ++out.attachments;
    } catch (const McapError& error) {
      out.damaged.push_back(error.what());
      out.lost_bytes += attachment.length;
    }
  }
  for (const McapChunkIndex& chunk : reader.chunks()) {
    try {
      reader.for_each_in(chunk, [&](const McapMessage& message) { copy.add(message, out); });
      ++out.chunks;
    } catch (const McapError& error) {
      out.damaged.push_back(error.what());
      out.lost_bytes += chunk.length;
    }
  }
  if (!out.had_end) out.lost_bytes += reader.cut_bytes();
  reader.for_each_cut([&](const McapMessage& message) {
    copy.add(message, out);
    ++out.rescued;
  });
  copy.file().add_metadata("recovered", {{"had an end", out.had_end ? "yes" : "no"},
                                         {"whole chunks", std::to_string(out.chunks)},
                                         {"damaged chunks", std::to_string(out.damaged.size())},
                                         {"messages of a cut chunk", std::to_string(out.rescued)}});
  if (!copy.file().close()) throw McapError(copy.file().error());
  return out;
}

}  // namespace haptic
