// SPDX-License-Identifier: GPL-3.0-or-later
// The servo's side and the thread's side of devices with a mailbox, under the guard: 11,000 ticks
// here, 10⁶ with HAPTIC_TORTURE_SCALE=91.
#include <array>
#include <catch2/catch.hpp>

#include "device-io/falcon/exchange.h"
#include "device-io/falcon/falcon.h"
#include "device-io/hidarm/hid_arm.h"
#include "device-io/hidarm/hid_exchange.h"
#include "tests/support/guarded.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr int64_t kMs = 1'000'000;

/// Runs the ticks from 1 on, the first ones without the guard: they touch all memory once.
template <typename Tick>
GuardReport guarded_ticks(int64_t n, Tick tick) {
  constexpr int64_t kWarmUp = 1000;
  for (int64_t i = 1; i <= kWarmUp; ++i) tick(i);
  return guarded([&] {
    for (int64_t i = kWarmUp + 1; i <= kWarmUp + n; ++i) tick(i);
  });
}

int64_t ticks() {
  return static_cast<int64_t>(11'000 * torture_scale());
}

/// Force towards the middle, and now and then what no device can exert.
Wrench force_of(const DeviceState& state, int64_t tick) {
  return {tick % 1000 == 7 ? Vec3{1e300, 0, 0} : -200.0 * state.X_BH.p, {}};
}

}  // namespace

TEST_CASE("guard: the Falcon's tick and exchange neither allocate, lock nor call the system",
          "[device-io]") {
  if (!hooks_are_here()) return;
  const auto mailbox = std::make_shared<MotorMailbox>();
  ThreeMotorDevice device(falcon_arm({}), {}, mailbox);
  FalconExchange exchange(*mailbox);
  DeviceState state{};
  int64_t fresh = 0;
  const GuardReport report = guarded_ticks(ticks(), [&](int64_t i) {
    const FalconBytes asked = exchange.ask(i * kMs);
    // counts near −200, and the homed bits that the question deserves
    const bool homing = ((asked[13] - 'A') & 1) != 0;
    std::array<uint8_t, 18> packet{1,   0x60, '<', 'I', 'D', 'P', 'P', 'I', 'D',
                                   'P', 'P',  'I', 'D', 'P', 'P', 'A', 'A', '>'};
    packet[3] = static_cast<uint8_t>('A' + i / 8 % 16);
    packet[15] = static_cast<uint8_t>('A' + (homing ? 0x70 : 0));
    // now and then half an answer, or none
    const size_t size = i % 500 == 3 ? 9 : i % 700 == 4 ? 2 : packet.size();
    exchange.hear({packet.data(), size}, i * kMs + 900'000);
    const int64_t t_ns = i * kMs + 950'000;
    fresh += device.read({t_ns, t_ns}, state) ? 1 : 0;
    device.write(force_of(state, i));
  });
  INFO(report.explain());
  CHECK(report.violations() == 0);
  CHECK(fresh > ticks() * 9 / 10);
  CHECK((state.flags & kDeviceHomed) != 0);
  CHECK(exchange.is_challenged());
}

TEST_CASE("guard: a HID arm's tick and exchange neither allocate, lock nor call the system",
          "[device-io]") {
  if (!hooks_are_here()) return;
  const auto mailbox = std::make_shared<MotorMailbox>();
  ThreeMotorDevice device(hid_arm({}), {}, mailbox);
  HidExchange exchange(*mailbox);
  DeviceState state{};
  int64_t fresh = 0;
  const GuardReport report = guarded_ticks(ticks(), [&](int64_t i) {
    const std::array<uint8_t, 8> bytes{
        static_cast<uint8_t>(i / 16 % 200), 0, 10, 0, 20, 0, static_cast<uint8_t>(i & 0xff),
        static_cast<uint8_t>(i >> 8 & 0xff)};
    exchange.hear({bytes.data(), i % 500 == 3 ? size_t{5} : bytes.size()}, i * kMs);
    use(exchange.command(i * kMs));
    fresh += device.read({i * kMs, i * kMs}, state) ? 1 : 0;
    device.write(force_of(state, i));
  });
  INFO(report.explain());
  CHECK(report.violations() == 0);
  CHECK(fresh > ticks() * 9 / 10);
}
