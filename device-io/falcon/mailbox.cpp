// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/mailbox.h"

namespace haptic {
namespace {

constexpr int kNumberBits = 16, kFlagsAt = 48, kSequenceAt = 56;
constexpr uint64_t kHomingFlag = 1, kLightsMask = 0x0e, kByte = 0xff;
// `homed` stays below 8, so that no sample is all ones
constexpr int kHomedAt = 4;
constexpr uint64_t kButtons = 15, kLegs = 7;

uint64_t pack(const std::array<int16_t, 3>& numbers) {
  uint64_t word = 0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    word |= uint64_t{static_cast<uint16_t>(numbers[i])} << (kNumberBits * i);
  }
  return word;
}

std::array<int16_t, 3> unpack(uint64_t word) {
  std::array<int16_t, 3> numbers;
  for (size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = static_cast<int16_t>(static_cast<uint16_t>(word >> (kNumberBits * i)));
  }
  return numbers;
}

}  // namespace

void FalconMailbox::post(const FalconCommand& command, int64_t t_ns) noexcept {
  const uint64_t flags = (command.homing ? kHomingFlag : 0) | (command.lights & kLightsMask);
  command_.store(pack(command.motors) | flags << kFlagsAt, std::memory_order_relaxed);
  posted_ns_.store(t_ns, std::memory_order_release);
}

FalconCommand FalconMailbox::command_at(int64_t t_ns) const noexcept {
  const int64_t posted_ns = posted_ns_.load(std::memory_order_acquire);
  const uint64_t word = command_.load(std::memory_order_relaxed);
  const uint64_t flags = word >> kFlagsAt;
  FalconCommand command;
  // homing before the servo's first command: the first answers say whether it is homed
  command.homing = posted_ns == 0 || (flags & kHomingFlag) != 0;
  command.lights = static_cast<uint8_t>(flags & kLightsMask);
  if (posted_ns != 0 && t_ns - posted_ns <= kCommandLifeNs) command.motors = unpack(word);
  return command;
}

void FalconMailbox::put(const FalconAnswer& answer, int64_t asked_ns, int64_t heard_ns) noexcept {
  const uint8_t number = next_++;
  asked_ns_[number].store(asked_ns, std::memory_order_relaxed);
  heard_ns_[number].store(heard_ns, std::memory_order_relaxed);
  const uint64_t flags = (answer.buttons & kButtons) | uint64_t{answer.homed & kLegs} << kHomedAt;
  sample_.store(pack(answer.counts) | flags << kFlagsAt | uint64_t{number} << kSequenceAt,
                std::memory_order_release);
}

std::optional<FalconSample> FalconMailbox::newest() const noexcept {
  const uint64_t word = sample_.load(std::memory_order_acquire);
  if (word == kNone) return std::nullopt;
  FalconSample sample;
  const uint64_t flags = word >> kFlagsAt & kByte;
  sample.answer.counts = unpack(word);
  sample.answer.buttons = static_cast<uint8_t>(flags & kButtons);
  sample.answer.homed = static_cast<uint8_t>(flags >> kHomedAt & kLegs);
  sample.number = static_cast<uint8_t>(word >> kSequenceAt);
  sample.asked_ns = asked_ns_[sample.number].load(std::memory_order_relaxed);
  sample.heard_ns = heard_ns_[sample.number].load(std::memory_order_relaxed);
  return sample;
}

}  // namespace haptic
