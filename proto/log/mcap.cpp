// SPDX-License-Identifier: Apache-2.0
#include "proto/log/mcap.h"

#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <utility>

#include "proto/log/mcap_format.h"
#include "proto/os/message.h"
#include "proto/os/regular_file.h"

namespace haptic {

using namespace mcap;

namespace {

// Largest uncompressed chunk [bytes]: chunks are unpacked as a whole, and zstd compresses zeros
// ten-thousandfold. McapWriter closes a chunk at 256 KiB, the public C++ library at 768 KiB, other
// tools at some MiB.
constexpr uint64_t kMostUnpacked = uint64_t{16} << 20;
// Longest record read as a whole [bytes]: a compressed chunk may be longer than its contents.
constexpr uint64_t kMostRecord = kMostUnpacked + (uint64_t{1} << 20);
constexpr uint64_t kMostAttachmentHead = 64 << 10;  // times, name and media type [bytes]
constexpr size_t kMostNamed = 1024;  // schemas or channels of a file; a recording has a dozen

using Buffer = std::vector<char>;

/// Extracts numbers and texts from a record; throws std::out_of_range if it is too short.
class Parser {
 public:
  explicit Parser(const Buffer& content) : data_(content.data()), left_(content.size()) {}

  const char* bytes(uint64_t n) {
    if (n > left_) throw std::out_of_range("record too short");
    const char* at = data_;
    data_ += n;
    left_ -= n;
    return at;
  }
  /// Numbers and texts, in this order.
  template <typename... T>
  void take(T&... fields) {
    (take_one(fields), ...);
  }
  template <typename T>
  T take() {
    T field{};
    take_one(field);
    return field;
  }
  McapMetadata metadata() {
    McapMetadata out;
    const uint32_t size = take<uint32_t>();
    if (size > left_) throw std::out_of_range("record too short");
    for (const uint64_t end = left_ - size; left_ > end;) {
      std::string key = take<std::string>();
      out[std::move(key)] = take<std::string>();
    }
    return out;
  }
  uint64_t left() const { return left_; }

 private:
  void take_one(std::string& text) {
    const uint32_t n = take<uint32_t>();
    text.assign(bytes(n), n);
  }
  void take_one(auto& number) { std::memcpy(&number, bytes(sizeof number), sizeof number); }

  const char* data_;
  uint64_t left_;
};

bool read_magic(int file, uint64_t offset) {
  char magic[kMagic.size()];
  const ssize_t n = ::pread(file, magic, sizeof magic, static_cast<off_t>(offset));
  return n == sizeof magic && std::string_view(magic, sizeof magic) == kMagic;
}

/// Fills the buffer from this place of the file; false if it cannot.
bool read_bytes(int file, uint64_t offset, Buffer& bytes) {
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t n =
        ::pread(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (n <= 0) return false;
    done += static_cast<size_t>(n);
  }
  return true;
}

McapChunkIndex parse_chunk_index(const Buffer& content) {
  Parser in(content);
  McapChunkIndex index;
  in.take(index.first_ns, index.last_ns, index.offset, index.length);
  for (uint32_t left = in.take<uint32_t>(); left >= 10; left -= 10) {
    const uint16_t channel = in.take<uint16_t>();
    index.index_offsets[channel] = in.take<uint64_t>();
  }
  std::string compression;
  in.take(index.index_length, compression, index.compressed, index.uncompressed);
  return index;
}

/// The fields before the data in an attachment record.
McapAttachment parse_attachment(Parser& in) {
  McapAttachment attachment;
  in.take(attachment.log_time_ns, attachment.create_time_ns, attachment.name, attachment.media_type,
          attachment.size);
  return attachment;
}

McapAttachment parse_attachment_index(const Buffer& content) {
  Parser in(content);
  McapAttachment attachment;
  in.take(attachment.offset, attachment.length, attachment.log_time_ns, attachment.create_time_ns,
          attachment.size, attachment.name, attachment.media_type);
  return attachment;
}

/// The fields of a chunk record before its packed records.
struct ChunkHead {
  uint64_t first_ns = 0, last_ns = 0, size = 0;  // unpacked [bytes]
  uint32_t crc = 0;                              // of all that is unpacked; 0: none
  std::string compression;
  uint64_t packed_size = 0;
};

ChunkHead parse_chunk_head(Parser& in) {
  ChunkHead head;
  in.take(head.first_ns, head.last_ns, head.size, head.crc, head.compression, head.packed_size);
  return head;
}

/// Record types that keep() uses.
bool is_kept(uint8_t op) {
  return op == kSchema || op == kChannel || op == kMetadata || op == kMessage;
}

}  // namespace

bool is_mcap_file(const std::string& path) {
  const RegularFile file = open_regular_file(path);
  return file.descriptor.is_open() && read_magic(file.descriptor.get(), 0);
}

McapReader::McapReader(const std::string& path) : path_(path) {
  RegularFile file = open_regular_file(path);
  if (!file.problem.empty()) fail(file.problem + "; name a recording (.mcap)");
  file_ = std::move(file.descriptor);
  size_ = file.size;
  if (!read_magic(file_.get(), 0)) {
    fail("is not an MCAP file; recordings are made by `hapt record`");
  }
  if (!read_summary()) {
    known_ = {};
    scan(kMagic.size());
  }
}

bool McapReader::refresh() {
  if (finished_) return false;
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) fail("cannot be read any more");
  const auto size = static_cast<uint64_t>(status.st_size);
  if (size < whole_) fail("has become shorter while it was read; open it again");
  if (size == size_) return false;
  size_ = size;
  const uint64_t before = whole_;
  // what is known of the whole chunks stays; the summary would only repeat it
  scan(whole_);
  return whole_ > before || finished_;
}

void McapReader::fail(const std::string& what) const {
  throw McapError(path_ + ": " + what);
}

const McapChannel* McapReader::find_channel(std::string_view topic) const {
  const auto channel = std::ranges::find(known_.channels, topic, &McapChannel::topic);
  return channel == known_.channels.end() ? nullptr : &*channel;
}

const McapSchema& McapReader::schema_of(const McapChannel& channel) const {
  const auto schema = std::ranges::find(known_.schemas, channel.schema, &McapSchema::id);
  if (schema != known_.schemas.end()) return *schema;
  throw McapError(path_ + ": topic '" + shown(channel.topic) +
                  "' has no schema; the file is damaged");
}

std::string McapReader::metadata(const std::string& record, const std::string& key) const {
  const auto texts = known_.metadata.find(record);
  if (texts == known_.metadata.end()) return "";
  const auto text = texts->second.find(key);
  return text == texts->second.end() ? "" : text->second;
}

/// Finds position and type of a record; false if it is not wholly in the file.
bool McapReader::find_record(uint64_t offset, Record& record) const {
  char header[kRecordHeader];
  if (offset > size_ || size_ - offset < sizeof header) return false;
  if (::pread(file_.get(), header, sizeof header, static_cast<off_t>(offset)) != sizeof header) {
    return false;
  }
  uint64_t length = 0;
  std::memcpy(&length, header + 1, sizeof length);
  if (length > size_ - offset - sizeof header) return false;
  record.op = static_cast<uint8_t>(header[0]);
  record.offset = offset;
  record.length = sizeof header + length;
  return true;
}

/// Reads the first `most` bytes of a found record, or all.
void McapReader::read_content(Record& record, uint64_t most) const {
  const uint64_t length = std::min(record.length - kRecordHeader, most);
  if (length > kMostRecord) {
    fail("the record at byte " + std::to_string(record.offset) + " has " +
         std::to_string(length >> 20) + " MiB, more than the " + std::to_string(kMostRecord >> 20) +
         " that are read; is it a recording of `hapt record`?");
  }
  record.content.resize(length);
  if (!read_bytes(file_.get(), record.offset + kRecordHeader, record.content)) {
    fail("ends within the record at byte " + std::to_string(record.offset));
  }
}

/// False if the record is not wholly in the file.
bool McapReader::read_record(uint64_t offset, Record& record) const {
  if (!find_record(offset, record)) return false;
  read_content(record, record.length);
  return true;
}

/// Adds a record to the lists; of several with one id the first counts.
void McapReader::keep(const Record& record) {
  Parser in(record.content);
  const auto is_room_for = [&](const auto& list, uint16_t id, const char* kind) {
    const auto has_id = [&](const auto& one) { return one.id == id; };
    if (std::ranges::any_of(list, has_id)) return false;
    if (list.size() == kMostNamed) {
      fail(std::string("has more than 1024 ") + kind + "; the file is damaged");
    }
    return true;
  };
  if (record.op == kSchema) {
    McapSchema schema;
    in.take(schema.id, schema.name, schema.encoding);
    if (!is_room_for(known_.schemas, schema.id, "schemas")) return;
    in.take(schema.text);
    known_.schemas.push_back(std::move(schema));
  } else if (record.op == kChannel) {
    McapChannel channel;
    in.take(channel.id, channel.schema, channel.topic, channel.encoding);
    if (!is_room_for(known_.channels, channel.id, "channels")) return;
    channel.metadata = in.metadata();
    known_.channels.push_back(std::move(channel));
  } else if (record.op == kMetadata) {
    std::string name = in.take<std::string>();
    known_.metadata[std::move(name)] = in.metadata();
  } else if (record.op == kMessage) {
    fail("has messages outside of chunks; only recordings of `hapt record` can be read");
  }
}

/// False if the file has no valid end: its writer was killed, or the end is damaged.
bool McapReader::read_summary() {
  if (size_ < 2 * kMagic.size() + kFooterBytes || !read_magic(file_.get(), size_ - kMagic.size())) {
    return false;
  }
  const uint64_t footer_offset = size_ - kMagic.size() - kFooterBytes;
  Record record;
  if (!find_record(footer_offset, record) || record.op != kFooter) return false;
  try {
    read_content(record, kFooterBytes);
    const uint64_t summary = Parser(record.content).take<uint64_t>();
    finished_ = summary != 0 && read_summary(summary, footer_offset);
  } catch (const std::out_of_range&) {
  }
  return finished_;
}

/// Reads the records from `begin` to `end`. What they point to must be in file order and not
/// overlap, so nothing is read twice, however often it is named.
bool McapReader::read_summary(uint64_t begin, uint64_t end) {
  uint64_t chunks_end = 0, metadata_end = 0;
  Record record, metadata;
  // at once: an hour has a hundred thousand chunks
  Buffer summary(end - std::min(begin, end));
  if (!read_bytes(file_.get(), begin, summary)) return false;
  for (size_t at = 0; at < summary.size(); at += record.length) {
    const size_t left = summary.size() - at;
    if (left < kRecordHeader) return false;
    uint64_t length = 0;
    std::memcpy(&length, &summary[at + 1], sizeof length);
    if (length > left - kRecordHeader) return false;
    record.op = static_cast<uint8_t>(summary[at]);
    record.length = kRecordHeader + length;
    const char* content = &summary[at] + kRecordHeader;
    record.content.assign(content, content + length);
    if (record.op == kChunkIndex) {
      McapChunkIndex index = parse_chunk_index(record.content);
      if (index.offset < chunks_end || index.length > size_ ||
          index.offset > size_ - index.length) {
        return false;
      }
      chunks_end = index.offset + index.length;
      known_.chunks.push_back(std::move(index));
    } else if (record.op == kMetadataIndex) {
      const uint64_t offset = Parser(record.content).take<uint64_t>();
      if (offset < metadata_end || !read_record(offset, metadata)) return false;
      metadata_end = offset + metadata.length;
      keep(metadata);
    } else if (record.op == kAttachmentIndex) {
      keep(parse_attachment_index(record.content));
    } else {
      keep(record);
    }
  }
  return true;
}

/// Walks the records to the first incomplete or invalid one: a crash may leave zeros behind the
/// last record.
void McapReader::scan(uint64_t from) {
  Record record;
  whole_ = from;
  try {
    for (uint64_t at = from; find_record(at, record); at += record.length) {
      if (record.op == kNone) break;
      if (record.op == kDataEnd) {
        finished_ = read_magic(file_.get(), size_ - kMagic.size());
        if (finished_) whole_ = size_;
        break;
      }
      scan_record(record);
      whole_ = at + record.length;
    }
  } catch (const std::out_of_range&) {
    fail("damaged record at byte " + std::to_string(record.offset));
  }
}

/// A chunk is described without its message index, which may be the missing part, an attachment
/// without reading its data.
void McapReader::scan_record(Record& record) {
  if (record.op == kChunk) {
    read_content(record, 2 * sizeof(uint64_t));
    McapChunkIndex chunk{.offset = record.offset, .length = record.length};
    Parser(record.content).take(chunk.first_ns, chunk.last_ns);
    known_.chunks.push_back(std::move(chunk));
  } else if (record.op == kAttachment) {
    read_content(record, kMostAttachmentHead);
    Parser in(record.content);
    McapAttachment attachment = parse_attachment(in);
    attachment.offset = record.offset;
    attachment.length = record.length;
    keep(std::move(attachment));
  } else if (is_kept(record.op)) {
    read_content(record, record.length);
    keep(record);
  }
}

void McapReader::keep(McapAttachment attachment) {
  // more are nothing that is looked for here
  if (known_.attachments.size() < kMostNamed) known_.attachments.push_back(std::move(attachment));
}

std::vector<std::byte> McapReader::read_attachment(const McapAttachment& attachment) const {
  const std::string where =
      "attachment '" + shown(attachment.name) + "' at byte " + std::to_string(attachment.offset);
  Record record;
  try {
    if (!read_record(attachment.offset, record) || record.op != kAttachment) {
      fail(where + " is not there");
    }
    Parser in(record.content);
    const uint64_t size = parse_attachment(in).size;
    const char* data = in.bytes(size);
    const size_t covered = record.content.size() - in.left();
    const uint32_t crc = in.take<uint32_t>();
    if (crc != 0 && crc != crc32(record.content.data(), covered)) {
      fail(where + " has a wrong CRC; the file is damaged");
    }
    const auto bytes = std::as_bytes(std::span(data, size));
    return {bytes.begin(), bytes.end()};
  } catch (const std::out_of_range&) {
    fail(where + " is cut; the file is damaged");
  }
}

/// The records of a chunk, decompressed and checked.
std::vector<char> McapReader::read_chunk(const McapChunkIndex& index) const {
  const std::string where = "chunk at byte " + std::to_string(index.offset);
  Record record;
  if (!find_record(index.offset, record) || record.op != kChunk || record.length != index.length) {
    fail(where + " is not there");
  }
  read_content(record, record.length);
  Parser in(record.content);
  const auto [first_ns, last_ns, size, crc, compression, packed_size] = parse_chunk_head(in);
  const char* packed = in.bytes(packed_size);
  if (size > kMostUnpacked) {
    fail(where + " claims " + std::to_string(size >> 20) + " MiB, more than the " +
         std::to_string(kMostUnpacked >> 20) +
         " that a chunk may hold; write it with smaller ones");
  }
  Buffer out(size);
  if (compression == kZstd) {
    // at most what the chunk claims, whatever the compressed bytes say
    const size_t got = ZSTD_decompress(out.data(), out.size(), packed, packed_size);
    if (ZSTD_isError(got) || got != size) fail(where + " cannot be unpacked; the file is damaged");
  } else if (compression.empty() && packed_size == size) {
    out.assign(packed, packed + size);
  } else {
    fail(where + " is packed with '" + shown(compression) + "'; only zstd and none can be read");
  }
  if (crc != 0 && crc != crc32(out.data(), out.size())) {
    fail(where + " has a wrong CRC; the file is damaged");
  }
  return out;
}

namespace {

/// Passes the messages among these records, up to one that is cut.
void pass_messages(const Buffer& records, const McapReader::Use& use) {
  constexpr size_t kMessageHeader = 2 + 4 + 8 + 8;
  Parser in(records);
  while (in.left() > 0) {
    const uint8_t op = in.take<uint8_t>();
    const uint64_t length = in.take<uint64_t>();
    if (op != kMessage || length < kMessageHeader) {
      in.bytes(length);
      continue;
    }
    McapMessage message;
    in.take(message.channel, message.sequence, message.log_time_ns, message.publish_time_ns);
    const uint64_t size = length - kMessageHeader;
    message.data = std::as_bytes(std::span(in.bytes(size), size));
    use(message);
  }
}

/// As much as can be unpacked of a zstd frame that is cut; at most `most` bytes.
Buffer unpack_cut(const char* packed, size_t size, size_t most) {
  Buffer out(most);
  ZSTD_inBuffer from{packed, size, 0};
  ZSTD_outBuffer to{out.data(), out.size(), 0};
  const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                          &ZSTD_freeDStream);
  if (stream == nullptr) throw std::bad_alloc();
  while (from.pos < from.size && to.pos < to.size) {
    const size_t before = from.pos + to.pos;
    const size_t left = ZSTD_decompressStream(stream.get(), &to, &from);
    if (ZSTD_isError(left) || left == 0 || from.pos + to.pos == before) break;
  }
  out.resize(to.pos);
  return out;
}

}  // namespace

std::vector<char> McapReader::for_each_in(const McapChunkIndex& chunk, const Use& use) const {
  try {
    Buffer records = read_chunk(chunk);
    pass_messages(records, use);
    return records;
  } catch (const std::out_of_range&) {
    fail("chunk at byte " + std::to_string(chunk.offset) + " is cut; the file is damaged");
  }
}

void McapReader::for_each_cut(const Use& use) const {
  Record record{kNone, whole_, cut_bytes(), {}};
  if (finished_ || record.length <= kRecordHeader) return;
  read_content(record, kMostRecord);
  char op = 0;
  if (::pread(file_.get(), &op, 1, static_cast<off_t>(whole_)) != 1 || op != kChunk) return;
  try {
    Parser in(record.content);
    const ChunkHead head = parse_chunk_head(in);  // its CRC is of the whole
    const size_t left = in.left();
    const char* packed = in.bytes(left);
    if (head.size > kMostUnpacked) return;
    Buffer records;
    if (head.compression == kZstd) {
      records = unpack_cut(packed, left, head.size);
    } else if (head.compression.empty()) {
      records.assign(packed, packed + left);
    }
    pass_messages(records, use);
  } catch (const std::out_of_range&) {
    // so far it could be read
  }
}

}  // namespace haptic
