// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// MCAP files assembled byte by byte from the specification, without the program's writer, so that
/// they can be wrong anywhere.
namespace haptic::test {

/// Content of a record or of a file.
class McapBytes {
 public:
  template <typename T>
  McapBytes& number(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  McapBytes& raw(std::string_view bytes) {
    bytes_ += bytes;
    return *this;
  }
  McapBytes& text(std::string_view text) {
    return number(static_cast<uint32_t>(text.size())).raw(text);
  }
  McapBytes& record(uint8_t op, const McapBytes& content) {
    return number(op).number(uint64_t{content.size()}).raw(content.bytes_);
  }
  size_t size() const { return bytes_.size(); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

/// A zstd frame (RFC 8878) of `blocks` blocks that each repeat one byte `each` times; `announced`
/// is the size it claims. Four bytes a block.
inline std::string repeating_frame(uint32_t blocks, uint32_t each, uint64_t announced) {
  McapBytes out;
  out.number(uint32_t{0xFD2FB528}).number(uint8_t{0xE0}).number(announced);
  for (uint32_t i = 0; i < blocks; ++i) {
    const uint32_t header = (i + 1 == blocks ? 1u : 0u) | 1u << 1 | each << 3;
    out.raw(std::string_view(reinterpret_cast<const char*>(&header), 3)).number(uint8_t{0});
  }
  return out.bytes();
}

/// The content of a chunk record.
inline McapBytes chunk(uint64_t claimed, std::string_view compression, std::string_view packed) {
  McapBytes out;
  out.number(uint64_t{0}).number(uint64_t{0}).number(claimed).number(uint32_t{0});
  return out.text(compression).number(uint64_t{packed.size()}).raw(packed);
}

/// The content of a message of channel 1, with this payload.
inline McapBytes message(std::string_view payload) {
  McapBytes out;
  out.number(uint16_t{1}).number(uint32_t{0}).number(uint64_t{0}).number(uint64_t{0});
  return out.raw(payload);
}

/// The content of a chunk index record for a chunk at this offset.
inline McapBytes chunk_index(uint64_t offset, uint64_t length) {
  McapBytes out;
  out.number(uint64_t{0}).number(uint64_t{0}).number(offset).number(length);
  out.number(uint32_t{0}).number(uint64_t{0}).text("zstd");
  return out.number(uint64_t{0}).number(uint64_t{0});
}

/// The end of a file: the records of its summary, which begins at this offset, and the footer.
inline std::string mcap_end(uint64_t summary_at, const McapBytes& summary) {
  McapBytes footer, out;
  footer.number(summary_at).number(uint64_t{0}).number(uint32_t{0});
  return out.raw(summary.bytes()).record(0x02, footer).raw(kMcapMagic).bytes();
}

}  // namespace haptic::test
