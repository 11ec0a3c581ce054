// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/packet.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace haptic {
namespace {

constexpr uint8_t kSetUp = 1, kTorques = 2;  // first byte of a packet
constexpr uint8_t kBothPorts = 0x03;         // port 1 is bit 0

template <size_t N>
void put_float(std::array<uint8_t, N>& bytes, size_t at, float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  for (size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<uint8_t>(bits >> (8 * i));
}

float float_at(const uint8_t* bytes) {
  uint32_t bits = 0;
  for (size_t i = 0; i < 4; ++i) bits |= uint32_t{bytes[i]} << (8 * i);
  return std::bit_cast<float>(bits);
}

bool is_count(float value) {
  return std::fabs(value) <= static_cast<float>(kMostHaplyCounts) && value == std::trunc(value);
}

}  // namespace

HaplySetup encode_haply_setup(uint8_t device,
                              const std::array<HaplyEncoder, 2>& encoders) noexcept {
  // motors with their directions, encoders with theirs, no analog pins, no PWM pins
  HaplySetup bytes{kSetUp, device, kBothPorts, 0, 0, kBothPorts, 0, 0, 0, 0};
  for (size_t i = 0; i < 2; ++i) {
    put_float(bytes, 10 + 8 * i, encoders[i].start);
    put_float(bytes, 14 + 8 * i, encoders[i].counts_per_turn);
  }
  return bytes;
}

HaplyTorques encode_haply_torques(uint8_t device, const std::array<float, 2>& torques) noexcept {
  HaplyTorques bytes{kTorques, device};
  for (size_t i = 0; i < 2; ++i) put_float(bytes, 2 + 4 * i, torques[i]);
  return bytes;
}

HaplyQuestion encode_haply(uint8_t number, int16_t motor_1, int16_t motor_2) noexcept {
  const auto torques =
      encode_haply_torques(kHaplyDevice, {static_cast<float>(kHaplyTorqueUnit * motor_1),
                                          static_cast<float>(kHaplyTorqueUnit * motor_2)});
  HaplyQuestion bytes{kTorques, number};
  std::copy(torques.begin(), torques.end(), bytes.begin() + 2);
  return bytes;
}

bool HaplyReader::push(uint8_t byte, HaplyAnswer& answer) noexcept {
  std::copy(last_.begin() + 1, last_.end(), last_.begin());
  last_.back() = byte;
  ++bytes_;
  if (last_[0] < kFirstNumber || last_[0] > kLastNumber || last_[1] != kHaplyDevice) return false;
  const float first = float_at(&last_[2]), second = float_at(&last_[6]);
  if (!is_count(first) || !is_count(second)) return false;
  answer = {last_[0], {static_cast<int16_t>(first), static_cast<int16_t>(second)}};
  last_ = {};
  ++answers_;
  return true;
}

}  // namespace haptic
