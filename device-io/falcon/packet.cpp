// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/packet.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr uint8_t kBegin = '<', kEnd = '>', kZero = 'A';
constexpr size_t kNumbers = 3, kLetters = 4;        // of a number
constexpr size_t kFlags = 1 + kNumbers * kLetters;  // place of the flags
constexpr uint8_t kMostFlags = 0x7f;                // buttons and legs

bool is_letter(uint8_t byte) {
  return byte >= kZero && byte < kZero + 16;
}

int16_t number_at(const FalconBytes& bytes, size_t i) {
  uint16_t number = 0;
  for (size_t k = 0; k < kLetters; ++k) {
    number = static_cast<uint16_t>(number | (bytes[1 + kLetters * i + k] - kZero) << (4 * k));
  }
  return static_cast<int16_t>(number);
}

bool is_valid(const FalconBytes& bytes) {
  return bytes.front() == kBegin && bytes.back() == kEnd &&
         std::all_of(bytes.begin() + 1, bytes.begin() + kFlags, is_letter) &&
         bytes[kFlags] >= kZero && bytes[kFlags] <= kZero + kMostFlags;
}

}  // namespace

FalconBytes encode_falcon(const MotorCommand& command) noexcept {
  FalconBytes bytes;
  bytes.fill(kZero);
  bytes.front() = kBegin;
  bytes.back() = kEnd;
  for (size_t i = 0; i < kNumbers; ++i) {
    const auto number = static_cast<uint16_t>(command.motors[i]);
    for (size_t k = 0; k < kLetters; ++k) {
      bytes[1 + kLetters * i + k] = static_cast<uint8_t>(kZero + (number >> (4 * k) & 15));
    }
  }
  bytes[kFlags] = static_cast<uint8_t>(kZero + (command.flags & (kFalconHoming | kFalconLights)));
  return bytes;
}

/// Drops the first byte, and all up to the next '<'.
void FalconReader::begin_again() noexcept {
  ++rejected_;
  const auto end = bytes_.begin() + static_cast<ptrdiff_t>(size_);
  const auto next = std::find(bytes_.begin() + 1, end, kBegin);
  size_ = static_cast<size_t>(std::copy(next, end, bytes_.begin()) - bytes_.begin());
}

bool FalconReader::push(uint8_t byte, MotorSample& sample) noexcept {
  if (size_ == 0 && byte != kBegin) return false;
  bytes_[size_++] = byte;
  if (size_ < kFalconPacket) return false;
  if (!is_valid(bytes_)) {
    begin_again();
    return false;
  }
  size_ = 0;
  for (size_t i = 0; i < kNumbers; ++i) sample.counts[i] = number_at(bytes_, i);
  sample.flags = static_cast<uint8_t>(bytes_[kFlags] - kZero);
  return true;
}

}  // namespace haptic
