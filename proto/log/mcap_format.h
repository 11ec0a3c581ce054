// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string_view>

/// Parts of the format common to the reader and the writer of recordings; internal.
namespace haptic::mcap {

inline constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
inline constexpr size_t kRecordHeader = 1 + 8;                     // opcode, length
inline constexpr size_t kFooterBytes = kRecordHeader + 8 + 8 + 4;  // its offsets and its CRC
inline constexpr std::string_view kZstd = "zstd";

/// First byte of a record; its length follows as uint64.
enum Op : uint8_t {
  kNone = 0x00,  // no record
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// CRC-32 (IEEE), the checksum of chunks and of the summary.
inline uint32_t crc32(const char* data, size_t size) {
  return static_cast<uint32_t>(::crc32_z(0, reinterpret_cast<const Bytef*>(data), size));
}

}  // namespace haptic::mcap
