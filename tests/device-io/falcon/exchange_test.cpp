// SPDX-License-Identifier: GPL-3.0-or-later
// The Falcon's exchange and driver against packets of the chip that are right, damaged, cut,
// doubled or old.
#include "device-io/falcon/exchange.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <random>
#include <utility>
#include <vector>

#include "device-io/falcon/falcon.h"
#include "device-io/threemotors/three_motor_device.h"
#include "tests/support/torture_scale.h"

using namespace haptic;

namespace {

constexpr int64_t kMs = 1'000'000;
using Bytes = std::vector<uint8_t>;

/// An honest answer with these counts, after the chip's two bytes.
Bytes answer_of(const FalconBytes& question, const std::array<int16_t, 3>& counts) {
  const bool homing = ((question[13] - 'A') & kFalconHoming) != 0;
  FalconBytes packet = encode_falcon({counts, 0});
  packet[13] = static_cast<uint8_t>('A' + (homing ? kFalconLegs : 0));
  Bytes out{0x01, 0x60};
  out.insert(out.end(), packet.begin(), packet.end());
  return out;
}

void spoil(Bytes& packet, Bytes& before, unsigned fate, std::mt19937& random) {
  if (fate == 0) packet[random() % packet.size()] = static_cast<uint8_t>(random());
  if (fate == 1) packet.resize(random() % packet.size());
  if (fate == 2) packet.insert(packet.end(), packet.begin() + 2, packet.end());
  if (fate == 3) std::swap(packet, before);
  if (fate == 4) {
    for (uint8_t& byte : packet) byte = static_cast<uint8_t>(random());
  }
}

}  // namespace

TEST_CASE("falcon exchange: fuzz: packets that are right, damaged, cut, doubled or old",
          "[device-io][fuzz]") {
  // 10⁷: HAPTIC_TORTURE_SCALE=500, with a sanitizer 10000
  const auto mailbox = std::make_shared<MotorMailbox>();
  FalconExchange exchange(*mailbox);
  ThreeMotorDevice device(falcon_arm({}), {}, mailbox);
  std::mt19937 random(24);
  DeviceState state{};
  FalconBytes question{};
  Bytes before{0x01, 0x60};
  size_t fresh = 0;
  int64_t t_ns = kMs;
  const size_t n = test::sweep(20'000);
  for (size_t k = 0; k < n; ++k, t_ns += kMs) {
    const bool asks = exchange.may_ask(t_ns);
    if (asks) question = exchange.ask(t_ns);
    const auto count = [&] { return static_cast<int16_t>(static_cast<int>(random() % 800) - 600); };
    Bytes packet = answer_of(question, {count(), count(), count()});
    const Bytes right = packet;
    const auto fate = static_cast<unsigned>(random() % 32);
    spoil(packet, before, fate, random);
    before = right;
    // nobody answers what was not asked, but for a packet in seven that is spoiled
    if (asks || fate < 5) exchange.hear(packet, t_ns + 500'000);
    fresh += device.read({t_ns + 600'000, t_ns + 600'000}, state) ? 1 : 0;
    device.write({{0, 0, random() % 2 == 0 ? 1.0 : 1e300}, {}});
    bool good = is_finite(state.X_BH.p) && is_finite(state.V_BH.v);
    const MotorCommand command = mailbox->command_at(t_ns + 600'000).value();
    for (const int16_t motor : command.motors) good &= std::abs(motor) <= kMostFalconWord;
    if (!good) FAIL("input " << k);
  }
  CHECK(fresh > n / 4);
}
