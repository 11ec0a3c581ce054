// SPDX-License-Identifier: GPL-3.0-or-later
// The servo's side and the thread's side of devices with a mailbox, under the guard: 11,000 ticks
// here, 10⁶ with HAPTIC_TORTURE_SCALE=91.
#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>

#include "device-io/falcon/exchange.h"
#include "device-io/falcon/falcon.h"
#include "device-io/haply/exchange.h"
#include "device-io/haply/haply.h"
#include "device-io/hidarm/hid_arm.h"
#include "device-io/hidarm/hid_exchange.h"
#include "proto/math/units.h"
#include "tests/support/guarded.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// The servo's side and the thread's side of a device, tick by tick; the first ones without the
/// guard: they touch all memory once. `answer` is what the device says in tick i, now and then half
/// of it or almost nothing.
template <typename Exchange, typename Answer>
DeviceState check_guarded(const Arm& arm, const MotorFlags& flags, double stiffness,
                          Answer answer) {
  if (!hooks_are_here()) return {};
  const auto mailbox = std::make_shared<MotorMailbox>();
  ThreeMotorDevice device(arm, flags, {}, mailbox);
  Exchange exchange(*mailbox);
  DeviceState state{};
  int64_t fresh = 0;
  const auto tick = [&](int64_t i) {
    const auto said = answer(exchange, i);
    const size_t size = i % 500 == 3 ? said.size() / 2 : i % 700 == 4 ? 2 : said.size();
    exchange.hear({said.data(), size}, i * kMs + 900'000);
    const int64_t t_ns = i * kMs + 950'000;
    fresh += device.read({t_ns, t_ns}, state) ? 1 : 0;
    // now and then what no device can exert
    device.write({i % 1000 == 7 ? Vec3{1e300, 0, 0} : -stiffness * state.X_BH.p, {}});
  };
  constexpr int64_t kWarmUp = 1000;
  const auto ticks = static_cast<int64_t>(11'000 * torture_scale());
  for (int64_t i = 1; i <= kWarmUp; ++i) tick(i);
  const GuardReport report = guarded([&] {
    for (int64_t i = kWarmUp + 1; i <= kWarmUp + ticks; ++i) tick(i);
  });
  INFO(report.explain());
  CHECK(report.violations() == 0);
  CHECK(fresh > ticks * 9 / 10);
  CHECK((state.flags & kDeviceHomed) != 0);
  return state;
}

}  // namespace

TEST_CASE("guard: the Falcon's tick and exchange neither allocate, lock nor call the system",
          "[device-io]") {
  bool challenged = !guard_hooks_linked();
  check_guarded<FalconExchange>(
      falcon_arm({}), falcon_flags(), 200, [&](FalconExchange& exchange, int64_t i) {
        const FalconBytes asked = exchange.ask(i * kMs);
        // counts near −200, and the homed bits that the question deserves
        const bool homing = ((asked[13] - 'A') & 1) != 0;
        std::array<uint8_t, 18> packet{1,   0x60, '<', 'I', 'D', 'P', 'P', 'I', 'D',
                                       'P', 'P',  'I', 'D', 'P', 'P', 'A', 'A', '>'};
        packet[3] = static_cast<uint8_t>('A' + i / 8 % 16);
        packet[15] = static_cast<uint8_t>('A' + (homing ? 0x70 : 0));
        challenged |= exchange.is_challenged();
        return packet;
      });
  CHECK(challenged);
}

TEST_CASE("guard: a HID arm's tick and exchange neither allocate, lock nor call the system",
          "[device-io]") {
  check_guarded<HidExchange>(hid_arm({}), {}, 200, [](HidExchange& exchange, int64_t i) {
    use(exchange.command(i * kMs));
    return std::array<uint8_t, 8>{
        static_cast<uint8_t>(i / 16 % 200), 0, 10, 0, 20, 0, static_cast<uint8_t>(i & 0xff),
        static_cast<uint8_t>(i >> 8 & 0xff)};
  });
}

TEST_CASE("guard: a Haply's tick and exchange neither allocate, lock nor call the system",
          "[device-io]") {
  check_guarded<HaplyExchange>(haply_arm({}), {}, 20, [](HaplyExchange& exchange, int64_t i) {
    const auto angle =
        std::bit_cast<std::array<uint8_t, 4>>(static_cast<float>(-1000 - i / 8 % 300));
    const auto other = std::bit_cast<std::array<uint8_t, 4>>(900.0f);
    std::array<uint8_t, 10> answer{exchange.ask(i * kMs)[1], kHaplyDevice};
    std::copy(angle.begin(), angle.end(), answer.begin() + 2);
    std::copy(other.begin(), other.end(), answer.begin() + 6);
    return answer;
  });
}
