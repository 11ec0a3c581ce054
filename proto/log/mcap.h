// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/os/file_descriptor.h"
#include "proto/os/message.h"

/// A small reader of MCAP, the log container of robotics tools (Foxglove, Lichtblick,
/// PlotJuggler, rosbag2), after the public specification, https://mcap.dev/spec.
namespace haptic {

/// A recording that cannot be read: one line "file: what; how to mend".
struct McapError : InputError {
  using InputError::InputError;
};

using McapMetadata = std::map<std::string, std::string>;

/// One message as stored in the file. `data` is valid during the call that passes it, or as that
/// says.
struct McapMessage {
  uint16_t channel = 0;
  uint32_t sequence = 0;
  uint64_t log_time_ns = 0;
  uint64_t publish_time_ns = 0;
  std::span<const std::byte> data;
};

struct McapSchema {
  uint16_t id = 0;
  std::string name, encoding, text;
};

struct McapChannel {
  uint16_t id = 0;
  uint16_t schema = 0;
  std::string topic, encoding;
  McapMetadata metadata;
};

/// Place of a chunk in the file, and its own description.
struct McapChunkIndex {
  uint64_t first_ns = 0, last_ns = 0;  // log times
  uint64_t offset = 0, length = 0;     // of the chunk record
  uint64_t index_length = 0;           // of the message index records behind it
  uint64_t compressed = 0, uncompressed = 0;
  std::map<uint16_t, uint64_t> index_offsets{};  // channel → its message index record
};

struct McapMetadataIndex {
  uint64_t offset = 0, length = 0;
  std::string name;
};

/// A file within the file: where its record is, and what it says of itself.
struct McapAttachment {
  uint64_t offset = 0, length = 0;  // of the record
  uint64_t log_time_ns = 0, create_time_ns = 0;
  uint64_t size = 0;  // of its data [bytes]
  std::string name, media_type;
};

/// True if a file starts as an MCAP file; false if it cannot be read.
bool is_mcap_file(const std::string& path);

/// Reads a file by its index, or by scanning if it has no end (a killed writer), up to the last
/// whole chunk. The file is not trusted: a chunk may hold 16 MiB, and apart from two such chunks
/// memory is bounded by a small multiple of the file's size.
class McapReader {
 public:
  /// Throws McapError if it is no MCAP file or uses unsupported features.
  explicit McapReader(const std::string& path);

  const std::vector<McapSchema>& schemas() const { return known_.schemas; }
  const std::vector<McapChannel>& channels() const { return known_.channels; }
  const std::vector<McapChunkIndex>& chunks() const { return known_.chunks; }
  /// Metadata records by name.
  const std::map<std::string, McapMetadata>& metadata() const { return known_.metadata; }
  /// A text of one of them; empty if it is not there.
  std::string metadata(const std::string& record, const std::string& key) const;
  /// Attachments in file order; one that replaces another of its name comes after it.
  const std::vector<McapAttachment>& attachments() const { return known_.attachments; }
  /// The data of one. Throws McapError if it is damaged, or longer than what is read at once.
  std::vector<std::byte> read_attachment(const McapAttachment& attachment) const;
  /// False: the writer was killed; the contents of its open chunk are lost.
  bool finished() const { return finished_; }

  /// The channel of a topic; nullptr if there is none.
  const McapChannel* find_channel(std::string_view topic) const;
  const McapSchema& schema_of(const McapChannel& channel) const;

  using Use = std::function<void(const McapMessage&)>;
  /// Passes every message of one chunk, of all channels, in file order. Their data lie in the bytes
  /// that are returned. Throws McapError on a chunk with a wrong CRC or contents.
  std::vector<char> for_each_in(const McapChunkIndex& chunk, const Use& use) const;

  /// Looks for chunks, and the end, that have been written since to a file that had no end. True if
  /// there is anything new.
  bool refresh();

  /// Bytes behind the last whole record of a file without an end.
  uint64_t cut_bytes() const { return size_ - whole_; }
  /// Passes the messages that can still be read in the chunk that the file ends within.
  void for_each_cut(const Use& use) const;

 private:
  struct Record {
    uint8_t op = 0;
    uint64_t offset = 0, length = 0;  // of the whole record
    std::vector<char> content;
  };

  bool find_record(uint64_t offset, Record& record) const;
  void read_content(Record& record, uint64_t most) const;
  bool read_record(uint64_t offset, Record& record) const;
  bool read_summary();
  bool read_summary(uint64_t begin, uint64_t end);
  void scan(uint64_t from);
  void scan_record(Record& record);
  void keep(const Record& record);
  void keep(McapAttachment attachment);
  std::vector<char> read_chunk(const McapChunkIndex& index) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  FileDescriptor file_;
  uint64_t size_ = 0;
  uint64_t whole_ = 0;  // end of the last whole record of a file without an end
  bool finished_ = false;
  struct Known {
    std::vector<McapSchema> schemas;
    std::vector<McapChannel> channels;
    std::vector<McapChunkIndex> chunks;
    std::map<std::string, McapMetadata> metadata;
    std::vector<McapAttachment> attachments;
  } known_;
};

}  // namespace haptic
