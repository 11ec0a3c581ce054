// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "clients/log/file_queue.h"
#include "proto/log/mcap.h"
#include "proto/os/file_descriptor.h"

namespace haptic {

/// Appends messages to a file in chunks (zstd, level 1). A thread writes them (FileQueue), so that
/// a disk that stands still for a while keeps nobody waiting.
///
/// A killed writer loses the open chunk and those not written yet. On a full disk the file ends,
/// complete, before the first chunk for which there is no room; that chunk and the later ones are
/// lost: before each chunk, space for it *and* for the end of the file is reserved. If the file
/// system cannot reserve and a write falls short, the file is truncated to its last whole chunk.
/// After such a stop `error()` gives the reason, and further messages are refused.
class McapWriter {
 public:
  /// Creates or replaces the file. Throws McapError, also if the path is a device or a pipe.
  explicit McapWriter(const std::string& path);
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// Add schemas and channels before the first message that uses them.
  uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view text);
  uint16_t add_channel(uint16_t schema, std::string_view topic, std::string_view encoding,
                       const McapMetadata& metadata);
  /// Named texts that belong to the file, behind the open chunk, which is closed.
  void add_metadata(std::string_view name, const McapMetadata& metadata);

  /// A file that belongs to this one, placed likewise. `log_time_ns`: when it came.
  void add_attachment(std::string_view name, std::string_view media_type, uint64_t log_time_ns,
                      std::span<const std::byte> data);

  /// Adds a message to the open chunk; false if an error has ended the file.
  bool write(const McapMessage& message);
  /// Hands the open chunk over to be written; false as above. The caller decides how long a chunk
  /// stays open.
  bool close_chunk();
  /// Closes the open chunk and waits until all is written; false as above.
  bool flush();
  /// Flushes and writes the end of the file; false as above.
  bool close();

  /// One line; empty: no error.
  const std::string& error() const { return error_; }
  /// Bytes of the file so far, with those that are on their way.
  uint64_t size() const { return offset_; }
  /// Gives the thread that writes the scheduling policy and priority of the caller.
  void share_priority() {
    if (queue_ != nullptr) queue_->share_priority();
  }
  /// Messages of a channel that are known to be in the file, as all are that were written before a
  /// flush.
  uint64_t written(uint16_t channel) const;

 private:
  using Buffer = std::vector<char>;
  using Indexed = std::pair<uint64_t, uint64_t>;  // log time [ns], offset

  struct Queued {
    uint64_t end;  // in the file
    std::function<void()> enter;
  };

  bool append(
      Buffer bytes, std::function<void()> enter = [] {});
  bool settle();
  bool finish();
  void stop(int error);
  void tell(int error, bool whole);
  Buffer make_chunk(McapChunkIndex& index) const;
  void put_statistics(Buffer& out) const;
  Buffer make_end() const;
  uint64_t end_bound() const;

  std::string path_;
  FileDescriptor file_;
  std::unique_ptr<FileQueue> queue_;  // as long as the file is open
  std::deque<Queued> queued_;         // what is on its way into the file
  uint64_t offset_ = 0;
  std::string error_;
  std::vector<McapSchema> schemas_;
  std::vector<McapChannel> channels_;
  std::vector<McapChunkIndex> chunks_;
  std::vector<McapMetadataIndex> metadata_;
  std::vector<McapAttachment> attachments_;
  uint16_t n_schemas_ = 0, n_channels_ = 0;  // with those on their way
  uint64_t named_bytes_ = 0;  // size of all schemas, channels, names of metadata and attachments
  std::map<uint16_t, uint64_t> counts_;  // messages in whole chunks, by channel
  Buffer chunk_;                         // open chunk, uncompressed
  std::map<uint16_t, std::vector<Indexed>> chunk_index_;
  uint64_t chunk_first_ns_ = 0, chunk_last_ns_ = 0;
};

}  // namespace haptic
