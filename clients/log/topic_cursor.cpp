// SPDX-License-Identifier: Apache-2.0
#include "clients/log/topic_cursor.h"

namespace haptic {

TopicCursor::TopicCursor(const TraceReader& trace, const TopicInfo& topic)
    : mcap_(trace.mcap()), decoder_(trace.decoder(topic)), size_(topic.size) {}

const std::byte* TopicCursor::next() {
  if (!decoder_) return nullptr;
  while (at_ == stamps_.size()) {
    if (!read_chunk()) return nullptr;
  }
  return records_.data() + size_ * at_++;
}

/// False after the last chunk.
bool TopicCursor::read_chunk() {
  if (chunk_ == mcap_.chunks().size()) return false;
  const McapChunkIndex& chunk = mcap_.chunks()[chunk_++];
  records_.clear();
  stamps_.clear();
  at_ = 0;
  const uint16_t channel = decoder_->channel();
  if (!chunk.index_offsets.empty() && !chunk.index_offsets.contains(channel)) return true;
  mcap_.for_each_in(chunk, [&](const McapMessage& message) {
    if (message.channel != channel) return;
    const std::byte* record = decoder_->decode(message);
    records_.insert(records_.end(), record, record + size_);
    stamps_.push_back(stamp_of(message));
  });
  return true;
}

}  // namespace haptic
