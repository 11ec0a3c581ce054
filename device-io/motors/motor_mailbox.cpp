// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/motors/motor_mailbox.h"

namespace haptic {
namespace {

constexpr int kNumberBits = 16, kFlagsAt = 48,
              kSequenceAt = 56;  // bits of the word: three numbers, eight flags, eight of a count

uint64_t pack(const std::array<int16_t, 3>& numbers, uint8_t flags) {
  uint64_t word = uint64_t{flags} << kFlagsAt;
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

void MotorMailbox::post(const MotorCommand& command, int64_t t_ns) noexcept {
  command_.store(pack(command.motors, command.flags), std::memory_order_relaxed);
  posted_ns_.store(t_ns, std::memory_order_release);
}

std::optional<MotorCommand> MotorMailbox::command_at(int64_t t_ns) const noexcept {
  const int64_t posted_ns = posted_ns_.load(std::memory_order_acquire);
  if (posted_ns == 0) return std::nullopt;
  const uint64_t word = command_.load(std::memory_order_relaxed);
  MotorCommand command;
  command.flags = static_cast<uint8_t>(word >> kFlagsAt);
  if (t_ns - posted_ns <= kCommandLifeNs) command.motors = unpack(word);
  return command;
}

void MotorMailbox::put(const MotorSample& sample) noexcept {
  asked_ns_[sample.number].store(sample.asked_ns, std::memory_order_relaxed);
  heard_ns_[sample.number].store(sample.heard_ns, std::memory_order_relaxed);
  sample_.store(pack(sample.counts, sample.flags) | uint64_t{sample.number} << kSequenceAt,
                std::memory_order_release);
  any_.store(true, std::memory_order_release);
}

std::optional<MotorSample> MotorMailbox::newest() const noexcept {
  if (!any_.load(std::memory_order_acquire)) return std::nullopt;
  const uint64_t word = sample_.load(std::memory_order_acquire);
  MotorSample sample;
  sample.counts = unpack(word);
  sample.flags = static_cast<uint8_t>(word >> kFlagsAt);
  sample.number = static_cast<uint8_t>(word >> kSequenceAt);
  sample.asked_ns = asked_ns_[sample.number].load(std::memory_order_relaxed);
  sample.heard_ns = heard_ns_[sample.number].load(std::memory_order_relaxed);
  return sample;
}

}  // namespace haptic
