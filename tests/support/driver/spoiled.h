// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "device-io/motors/three_motor_device.h"
#include "proto/math/units.h"

namespace haptic::test {

/// One in `fates` of the answers is damaged, cut, doubled, old or noise, each.
inline void spoil(std::vector<uint8_t>& answer, std::vector<uint8_t>& before, unsigned fate,
                  size_t head, std::mt19937& random) {
  if (fate == 0) answer[random() % answer.size()] = static_cast<uint8_t>(random());
  if (fate == 1) answer.resize(random() % answer.size());
  if (fate == 2) {
    const std::vector<uint8_t> again(answer.begin() + static_cast<ptrdiff_t>(head), answer.end());
    answer.insert(answer.end(), again.begin(), again.end());
  }
  if (fate == 3) std::swap(answer, before);
  if (fate == 4) {
    for (uint8_t& byte : answer) byte = static_cast<uint8_t>(random());
  }
}

/// An exchange and its driver hear answers that are right, damaged, cut, doubled or old:
/// `answer_of(question, random)`, of which `head` bytes are not said again. Whatever they hear, the
/// state is finite and no motor is told more than `most`. Returns the samples that were fresh.
template <typename Exchange, typename AnswerOf>
size_t fuzz_exchange(const Arm& arm, const MotorFlags& flags, size_t n, size_t head, int most,
                     const Vec3& push_B, AnswerOf answer_of) {
  const auto mailbox = std::make_shared<MotorMailbox>();
  Exchange exchange(*mailbox);
  ThreeMotorDevice device(arm, flags, {}, mailbox);
  std::mt19937 random(24);
  DeviceState state{};
  auto question = exchange.ask(kMs);
  std::vector<uint8_t> before = answer_of(question, random);
  size_t fresh = 0;
  int64_t t_ns = 2 * kMs;
  for (size_t k = 0; k < n; ++k, t_ns += kMs) {
    const bool asks = exchange.may_ask(t_ns);
    if (asks) question = exchange.ask(t_ns);
    std::vector<uint8_t> answer = answer_of(question, random);
    const std::vector<uint8_t> right = answer;
    const auto fate = static_cast<unsigned>(random() % 32);
    spoil(answer, before, fate, head, random);
    before = right;
    // nobody answers what was not asked, but for an answer in seven that is spoiled
    if (asks || fate < 5) exchange.hear(answer, t_ns + 500'000);
    fresh += device.read({t_ns + 600'000, t_ns + 600'000}, state) ? 1 : 0;
    device.write({(random() % 2 == 0 ? 1.0 : 1e300) * push_B, {}});
    bool good = is_finite(state.X_BH.p) && is_finite(state.V_BH.v);
    const MotorCommand command = mailbox->command_at(t_ns + 600'000).value();
    for (const int16_t motor : command.motors) good &= std::abs(motor) <= most;
    if (!good) FAIL("input " << k);
  }
  return fresh;
}

}  // namespace haptic::test
