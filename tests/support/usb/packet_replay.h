// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "clients/desk/trial/byte_log.h"
#include "device-io/falcon/exchange.h"
#include "device-io/falcon/falcon.h"
#include "device-io/hidarm/hid_arm.h"
#include "device-io/hidarm/hid_exchange.h"
#include "device-io/motors/three_motor_device.h"

namespace haptic::test {

inline constexpr int64_t kReplayNs = 1'000'000'000;
inline constexpr int64_t kBurstNs = 200'000;

/// What a driver made of a recording, sample by sample.
struct ReplayedPackets {
  std::vector<DeviceState> samples;
  size_t mismatches = 0;  // questions of the host that were of another kind in the recording
};

/// A device of packets or reports that `hapt devices try` has recorded, played to its
/// exchange and driver on the recording's own time, from kReplayNs on.
template <typename Exchange, typename AskAgain>
ReplayedPackets replay_packets(const std::vector<DeviceBytes>& pieces, const Arm& arm,
                               const MotorFlags& flags, Exchange& exchange,
                               const std::shared_ptr<MotorMailbox>& mailbox, AskAgain ask_again) {
  ThreeMotorDevice driver(arm, flags, {}, mailbox);
  ReplayedPackets out;
  for (size_t i = 0; i < pieces.size(); ++i) {
    const DeviceBytes& piece = pieces[i];
    const int64_t t_ns = kReplayNs + piece.t_ns;
    const std::vector<uint8_t> bytes(piece.bytes.begin(), piece.bytes.end());
    if (!piece.by_device) {
      out.mismatches += ask_again(bytes, t_ns) ? 0 : 1;
      continue;
    }
    exchange.hear(bytes, t_ns);
    // of those that had waited for a busy machine the driver sees the newest
    const bool waits = i + 1 < pieces.size() && pieces[i + 1].by_device &&
                       pieces[i + 1].t_ns - piece.t_ns < kBurstNs;
    if (waits) continue;
    DeviceState state{};
    if (driver.read({t_ns, t_ns}, state)) out.samples.push_back(state);
    driver.write({});
  }
  return out;
}

/// A question must be a challenge where it was one, since its answer depends on it; motors and
/// lights depend on what the session wanted.
inline ReplayedPackets replay_falcon(const std::vector<DeviceBytes>& pieces) {
  const auto mailbox = std::make_shared<MotorMailbox>();
  FalconExchange exchange(*mailbox);
  return replay_packets(pieces, falcon_arm({}), falcon_flags(), exchange, mailbox,
                        [&](const std::vector<uint8_t>& said, int64_t t_ns) {
                          const FalconBytes asked = exchange.ask(t_ns);
                          return said.size() == asked.size() &&
                                 ((said[13] ^ asked[13]) & kFalconHoming) == 0;
                        });
}

/// Output reports ask nothing.
inline ReplayedPackets replay_hid_arm(const std::vector<DeviceBytes>& pieces,
                                      const HidArmConfig& config = {}) {
  const auto mailbox = std::make_shared<MotorMailbox>();
  HidExchange exchange(*mailbox);
  return replay_packets(pieces, hid_arm(config), {}, exchange, mailbox,
                        [](const std::vector<uint8_t>& said, int64_t) {
                          return said.size() == HidArmCommand{}.size();
                        });
}

}  // namespace haptic::test
