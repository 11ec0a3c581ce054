// SPDX-License-Identifier: Apache-2.0
#include "clients/log/mcap_writer.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <type_traits>

#include "proto/log/mcap_format.h"
#include "proto/os/regular_file.h"

namespace haptic {

using namespace mcap;

namespace {

constexpr size_t kChunkBytes = 256 << 10;  // a chunk is written at this size
constexpr int kZstdLevel = 1;              // the fastest standard level

using Buffer = std::vector<char>;

void put_bytes(Buffer& out, const void* data, size_t size) {
  const char* bytes = static_cast<const char*>(data);
  out.insert(out.end(), bytes, bytes + size);
}

/// Puts the length of the content in bytes, known only after it is written, before the content.
template <typename Length, typename PutContent>
void put_sized(Buffer& out, const PutContent& put_content) {
  const size_t at = out.size();
  out.resize(at + sizeof(Length));
  put_content();
  const auto length = static_cast<Length>(out.size() - at - sizeof(Length));
  std::memcpy(&out[at], &length, sizeof length);
}

/// A number in little endian, like the machines (x86-64, ARM64); bytes; or after its length in
/// bytes a text, or an array of pairs.
template <typename T>
void put(Buffer& out, const T& field) {
  if constexpr (std::is_integral_v<T>) {
    put_bytes(out, &field, sizeof field);
  } else if constexpr (std::is_same_v<T, std::span<const std::byte>>) {
    put_bytes(out, field.data(), field.size());
  } else if constexpr (std::is_convertible_v<T, std::string_view>) {
    const std::string_view text = field;
    put_sized<uint32_t>(out, [&] { put_bytes(out, text.data(), text.size()); });
  } else {
    put_sized<uint32_t>(out, [&] {
      for (const auto& [key, value] : field) put(out, key), put(out, value);
    });
  }
}

template <typename... Fields>
void put_record(Buffer& out, Op op, const Fields&... fields) {
  put(out, static_cast<uint8_t>(op));
  put_sized<uint64_t>(out, [&] { (put(out, fields), ...); });
}

void put_schema(Buffer& out, const McapSchema& s) {
  put_record(out, kSchema, s.id, s.name, s.encoding, s.text);
}

void put_channel(Buffer& out, const McapChannel& c) {
  put_record(out, kChannel, c.id, c.schema, c.topic, c.encoding, c.metadata);
}

void put_chunk_index(Buffer& out, const McapChunkIndex& c) {
  put_record(out, kChunkIndex, c.first_ns, c.last_ns, c.offset, c.length, c.index_offsets,
             c.index_length, kZstd, c.compressed, c.uncompressed);
}

/// An empty file that replaces an existing one. Anything but a regular file is refused: it cannot
/// be truncated, and a pipe would wait for a reader.
FileDescriptor create(const std::string& path) {
  FileDescriptor file(
      ::open(path.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, 0644));
  const int error = errno;
  struct stat status {};
  const bool known =
      file.is_open() ? ::fstat(file.get(), &status) == 0 : ::stat(path.c_str(), &status) == 0;
  const std::string kind = known ? kind_problem(status.st_mode) : "";
  if (!kind.empty()) {
    throw MessageError(path + ": " + kind + ", and a recording needs a file; name one (.mcap)");
  }
  if (!file.is_open() || ::ftruncate(file.get(), 0) != 0) {
    throw MessageError(path + ": cannot be written (" +
                       std::strerror(file.is_open() ? errno : error) +
                       "); check the folder and its rights");
  }
  return file;
}

}  // namespace

McapWriter::McapWriter(const std::string& path)
    : path_(path), file_(create(path)), queue_(std::make_unique<FileQueue>(file_.get())) {
  chunk_.reserve(kChunkBytes + (64 << 10));
  Buffer start(kMagic.begin(), kMagic.end());
  put_record(start, kHeader, "ros2", "hapticd");
  append(std::move(start));
  if (!flush()) throw MessageError(error_);
}

McapWriter::~McapWriter() {
  close();
}

uint16_t McapWriter::add_schema(std::string_view name, std::string_view encoding,
                                std::string_view text) {
  const McapSchema schema{++n_schemas_, std::string(name), std::string(encoding),
                          std::string(text)};
  Buffer record;
  put_schema(record, schema);
  named_bytes_ += record.size();
  append(std::move(record), [this, schema] { schemas_.push_back(schema); });
  return schema.id;
}

uint16_t McapWriter::add_channel(uint16_t schema, std::string_view topic, std::string_view encoding,
                                 const McapMetadata& metadata) {
  const McapChannel channel{++n_channels_, schema, std::string(topic), std::string(encoding),
                            metadata};
  Buffer record;
  put_channel(record, channel);
  named_bytes_ += record.size();
  append(std::move(record), [this, channel] { channels_.push_back(channel); });
  return channel.id;
}

void McapWriter::add_metadata(std::string_view name, const McapMetadata& metadata) {
  close_chunk();
  Buffer record;
  put_record(record, kMetadata, name, metadata);
  named_bytes_ += name.size();
  McapMetadataIndex index{offset_, record.size(), std::string(name)};
  append(std::move(record), [this, index] { metadata_.push_back(index); });
}

void McapWriter::add_attachment(std::string_view name, std::string_view media_type,
                                uint64_t log_time_ns, std::span<const std::byte> data) {
  close_chunk();
  McapAttachment index{offset_,
                       0,
                       log_time_ns,
                       log_time_ns,
                       data.size(),
                       std::string(name),
                       std::string(media_type)};
  Buffer record;
  record.reserve(data.size() + name.size() + media_type.size() + 64);
  put_record(record, kAttachment, index.log_time_ns, index.create_time_ns, name, media_type,
             index.size, data, uint32_t{0});
  // the CRC covers the content up to the CRC field
  const size_t content = record.size() - kRecordHeader - sizeof(uint32_t);
  const uint32_t crc = crc32(&record[kRecordHeader], content);
  std::memcpy(&record[kRecordHeader + content], &crc, sizeof crc);
  index.length = record.size();
  named_bytes_ += name.size() + media_type.size();
  append(std::move(record), [this, index] { attachments_.push_back(index); });
}

bool McapWriter::write(const McapMessage& message) {
  if (!file_.is_open()) return false;
  if (chunk_.empty()) chunk_first_ns_ = chunk_last_ns_ = message.log_time_ns;
  chunk_first_ns_ = std::min(chunk_first_ns_, message.log_time_ns);
  chunk_last_ns_ = std::max(chunk_last_ns_, message.log_time_ns);
  chunk_index_[message.channel].push_back({message.log_time_ns, chunk_.size()});
  put_record(chunk_, kMessage, message.channel, message.sequence, message.log_time_ns,
             message.publish_time_ns, message.data);
  return chunk_.size() < kChunkBytes || close_chunk();
}

bool McapWriter::close_chunk() {
  if (!file_.is_open()) return false;
  if (chunk_.empty()) return settle();
  McapChunkIndex index;
  Buffer bytes = make_chunk(index);
  std::map<uint16_t, uint64_t> counts;
  for (const auto& [channel, messages] : chunk_index_) counts[channel] = messages.size();
  chunk_.clear();
  chunk_index_.clear();
  return append(std::move(bytes), [this, index, counts] {
    chunks_.push_back(index);
    for (const auto& [channel, n] : counts) counts_[channel] += n;
  });
}

bool McapWriter::flush() {
  if (!close_chunk()) return false;
  queue_->wait();
  return settle();
}

bool McapWriter::close() {
  if (!file_.is_open()) return error_.empty();
  if (!flush()) return false;
  if (!finish()) tell(errno, false);
  return error_.empty();
}

uint64_t McapWriter::written(uint16_t channel) const {
  const auto count = counts_.find(channel);
  return count == counts_.end() ? 0 : count->second;
}

/// The open chunk as records, with its future index entry.
McapWriter::Buffer McapWriter::make_chunk(McapChunkIndex& index) const {
  Buffer packed(ZSTD_compressBound(chunk_.size()));
  const size_t packed_size =
      ZSTD_compress(packed.data(), packed.size(), chunk_.data(), chunk_.size(), kZstdLevel);
  // with a buffer of this size only memory can fail
  if (ZSTD_isError(packed_size)) throw std::bad_alloc();
  packed.resize(packed_size);
  size_t index_bytes = 0;
  for (const auto& [channel, messages] : chunk_index_) {
    index_bytes += kRecordHeader + 6 + sizeof(Indexed) * messages.size();
  }
  Buffer out;
  out.reserve(packed.size() + index_bytes + 128);
  put_record(out, kChunk, chunk_first_ns_, chunk_last_ns_, uint64_t{chunk_.size()},
             crc32(chunk_.data(), chunk_.size()), kZstd, uint64_t{packed.size()},
             std::as_bytes(std::span<const char>(packed)));
  index = {.first_ns = chunk_first_ns_,
           .last_ns = chunk_last_ns_,
           .offset = offset_,
           .length = out.size(),
           .compressed = packed.size(),
           .uncompressed = chunk_.size()};
  for (const auto& [channel, messages] : chunk_index_) {
    index.index_offsets[channel] = offset_ + out.size();
    put_record(out, kMessageIndex, channel, messages);
  }
  index.index_length = out.size() - index.length;
  return out;
}

/// Numbers of records in the file.
void McapWriter::put_statistics(Buffer& out) const {
  uint64_t messages = 0, first = chunks_.empty() ? 0 : chunks_.front().first_ns, last = 0;
  for (const auto& [channel, n] : counts_) messages += n;
  for (const McapChunkIndex& c : chunks_) {
    first = std::min(first, c.first_ns);
    last = std::max(last, c.last_ns);
  }
  put_record(out, kStatistics, messages, static_cast<uint16_t>(schemas_.size()),
             static_cast<uint32_t>(channels_.size()), static_cast<uint32_t>(attachments_.size()),
             static_cast<uint32_t>(metadata_.size()), static_cast<uint32_t>(chunks_.size()), first,
             last, counts_);
}

/// Everything after the last chunk: end of data, summary, footer.
McapWriter::Buffer McapWriter::make_end() const {
  Buffer out;
  put_record(out, kDataEnd, uint32_t{0});
  const size_t summary = out.size();
  Buffer groups;
  const auto put_group = [&](Op op, const auto& put_records) {
    const size_t begin = out.size();
    put_records();
    if (out.size() == begin) return;
    put_record(groups, kSummaryOffset, static_cast<uint8_t>(op), uint64_t{offset_ + begin},
               uint64_t{out.size() - begin});
  };
  put_group(kSchema, [&] {
    for (const auto& s : schemas_) put_schema(out, s);
  });
  put_group(kChannel, [&] {
    for (const auto& c : channels_) put_channel(out, c);
  });
  put_group(kChunkIndex, [&] {
    for (const auto& c : chunks_) put_chunk_index(out, c);
  });
  put_group(kAttachmentIndex, [&] {
    for (const auto& a : attachments_) {
      put_record(out, kAttachmentIndex, a.offset, a.length, a.log_time_ns, a.create_time_ns, a.size,
                 a.name, a.media_type);
    }
  });
  put_group(kMetadataIndex, [&] {
    for (const auto& m : metadata_) put_record(out, kMetadataIndex, m.offset, m.length, m.name);
  });
  put_group(kStatistics, [&] { put_statistics(out); });
  const uint64_t offsets = offset_ + out.size();
  out.insert(out.end(), groups.begin(), groups.end());
  // the CRC covers the summary and the footer up to the CRC field
  put(out, static_cast<uint8_t>(kFooter));
  put(out, uint64_t{kFooterBytes - kRecordHeader});
  put(out, uint64_t{offset_ + summary});
  put(out, offsets);
  put(out, crc32(&out[summary], out.size() - summary));
  put_bytes(out, kMagic.data(), kMagic.size());
  return out;
}

/// Upper bound of the size of make_end() after one more chunk [bytes].
uint64_t McapWriter::end_bound() const {
  constexpr uint64_t kFixed = 1024;
  constexpr uint64_t kPerChunk = 128, kPerMetadata = 64, kPerAttachment = 64, kPerChannel = 10;
  return kFixed + named_bytes_ + kPerMetadata * metadata_.size() +
         kPerAttachment * attachments_.size() + kPerChannel * n_channels_ +
         (kPerChunk + kPerChannel * n_channels_) * (chunks_.size() + queued_.size() + 1);
}

/// Queues bytes for the end of the file; `enter` puts them into the index once they are there.
bool McapWriter::append(Buffer bytes, std::function<void()> enter) {
  if (!file_.is_open()) return false;
  offset_ += bytes.size();
  queued_.push_back({offset_, std::move(enter)});
  queue_->append(std::move(bytes), end_bound());
  return settle();
}

/// Enters what has reached the file; after an error ends the file behind that.
bool McapWriter::settle() {
  const FileQueue::Written written = queue_->written();
  for (; !queued_.empty() && queued_.front().end <= written.bytes; queued_.pop_front()) {
    queued_.front().enter();
  }
  if (written.error == 0) return true;
  offset_ = written.bytes;
  stop(written.error);
  return false;
}

/// Ends the file after its last whole chunk and notes the reason.
void McapWriter::stop(int error) {
  tell(error, finish());
}

void McapWriter::tell(int error, bool whole) {
  error_ = path_ + ": " + std::strerror(error) + " after " + std::to_string(offset_ >> 10) +
           " KiB; what was recorded is kept (" +
           (whole ? "the file is complete" : "the file has no end, its whole chunks are readable") +
           "), free some space and record again";
}

/// Writes the end and closes the file; false, with errno, if the file then has no end.
bool McapWriter::finish() {
  queue_.reset();
  queued_.clear();
  const Buffer end = make_end();
  // overwrites a half-written chunk, or uses the reserved space
  const bool whole = write_all(file_.get(), std::as_bytes(std::span(end)), offset_);
  int error = errno;
  const uint64_t size = offset_ + (whole ? end.size() : 0);
  const bool cut = ::ftruncate(file_.get(), static_cast<off_t>(size)) == 0;
  if (whole && !cut) error = errno;
  file_.reset();
  errno = error;
  return whole && cut;
}

}  // namespace haptic
