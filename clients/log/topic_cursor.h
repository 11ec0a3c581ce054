// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "proto/log/trace.h"

namespace haptic {

/// Walks the records of one topic, chunk by chunk: memory holds one chunk, however long the file.
class TopicCursor {
 public:
  /// The reader must outlive it. A topic that the file lacks has no records.
  TopicCursor(const TraceReader& trace, const TopicInfo& topic);

  /// The next record in file order, topic.size bytes, unaligned, valid until the next call; null at
  /// the end. Throws McapError.
  const std::byte* next();
  /// Of the record that next() has returned.
  const Stamp& stamp() const { return stamps_[at_ - 1]; }

 private:
  bool read_chunk();

  const McapReader& mcap_;
  std::optional<TopicDecoder> decoder_;
  size_t size_;  // of a record [bytes]
  size_t chunk_ = 0, at_ = 0;
  std::vector<std::byte> records_;  // of the present chunk
  std::vector<Stamp> stamps_;
};

}  // namespace haptic
