// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/baked/block.h"

#include <xxhash.h>

#include <algorithm>
#include <cstring>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr std::array<char, 8> kMagic{'h', 'a', 'p', 't', 'b', 'a', 'k', 'e'};
constexpr size_t kAlignment = 64;  // of arrays [bytes]: a cache line

struct Section {
  uint64_t offset = 0, bytes = 0;
};

struct Header {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kBakeVersion;
  uint32_t header_bytes = sizeof(Header);
  BakedKind kind = BakedKind::kShape;
  uint32_t n_arrays = 0;
  uint64_t file_bytes = 0;
  uint64_t key = 0;
  std::array<uint64_t, 2> checksums{};  // of each half of the file, with this field zero
  std::array<Section, kMostBakedArrays> sections;
};
static_assert(std::is_trivially_copyable_v<Header>);

size_t aligned(size_t n) {
  return (n + kAlignment - 1) / kAlignment * kAlignment;
}

Header header_of(std::span<const std::byte> bytes) {
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  return header;
}

/// Checksum of the first half, including the header, or the second.
uint64_t checksum(Header header, std::span<const std::byte> file, size_t half) {
  const size_t middle = std::max(sizeof header, file.size() / 2);
  if (half == 1) return hash_bytes(file.subspan(middle));
  header.checksums = {};
  return hash_bytes(file.first(middle).subspan(sizeof header),
                    hash_bytes(std::as_bytes(std::span(&header, 1))));
}

}  // namespace

uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

std::vector<std::byte> write_block(BakedKind kind, uint64_t key,
                                   std::span<const std::span<const std::byte>> arrays) {
  Header header;
  HAPTIC_ASSERT(arrays.size() <= kMostBakedArrays);
  header.kind = kind;
  header.n_arrays = static_cast<uint32_t>(arrays.size());
  header.key = key;
  size_t end = aligned(sizeof header);
  for (size_t i = 0; i < arrays.size(); ++i) {
    header.sections[i] = {end, arrays[i].size()};
    end = aligned(end + arrays[i].size());
  }
  header.file_bytes = end;
  std::vector<std::byte> bytes(end);
  for (size_t i = 0; i < arrays.size(); ++i) {
    if (arrays[i].empty()) continue;
    std::memcpy(bytes.data() + header.sections[i].offset, arrays[i].data(), arrays[i].size());
  }
  header.checksums = {checksum(header, bytes, 0), checksum(header, bytes, 1)};
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

BakedBlock view_block(std::span<const std::byte> bytes, BakedKind kind, uint64_t key,
                      size_t n_arrays) {
  HAPTIC_ASSERT(n_arrays <= kMostBakedArrays);
  require_baked(bytes.size() >= sizeof(Header), "shorter than its header");
  const Header header = header_of(bytes);
  require_baked(header.magic == kMagic, "not a baked shape");
  require_baked(header.version == kBakeVersion && header.header_bytes == sizeof header,
                "baked by another version");
  require_baked(header.kind == kind && header.n_arrays == n_arrays, "baked for another use");
  require_baked(header.key == key, "baked from something else");
  require_baked(header.file_bytes == bytes.size(), "truncated");
  require_baked(reinterpret_cast<uintptr_t>(bytes.data()) % alignof(double) == 0, "not aligned");
  BakedBlock block;
  block.bytes = bytes;
  for (size_t i = 0; i < n_arrays; ++i) {
    const Section& section = header.sections[i];
    require_baked(section.offset <= bytes.size() && section.offset % kAlignment == 0 &&
                      section.bytes <= bytes.size() - section.offset,
                  "an array outside the file");
    block.arrays[i] = bytes.subspan(section.offset, section.bytes);
  }
  return block;
}

void check_half(const BakedBlock& block, size_t half) {
  HAPTIC_ASSERT(half < 2);
  const Header header = header_of(block.bytes);
  require_baked(header.checksums[half] == checksum(header, block.bytes, half), "damaged");
}

}  // namespace haptic
