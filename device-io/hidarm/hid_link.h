// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pthread.h>

#include <atomic>
#include <string>
#include <thread>

#include "device-io/hid/hid_node.h"
#include "device-io/hidarm/hid_exchange.h"
#include "device-io/motors/byte_tap.h"

namespace haptic {

/// The thread that reads and writes the reports of an arm: an output report waits for the device,
/// which the servo must not. It ends with this object, or when the device is unplugged; its last
/// report is zero. With the servo's first command it takes on the servo's scheduling, one priority
/// above.
class HidLink {
 public:
  /// Waits until the arm has reported, for a second at most. Throws DeviceError.
  HidLink(const std::string& path, MotorMailbox& mailbox);
  ~HidLink();
  HidLink(const HidLink&) = delete;
  HidLink& operator=(const HidLink&) = delete;

  /// Waits until the servo's last command has been sent, at most kStopNs.
  void stop();
  static constexpr int64_t kStopNs = 20'000'000;

  ByteTap& tap() { return tap_; }

 private:
  void run();
  bool hear_all(int wait_ms);

  HidNode node_;
  HidExchange exchange_;
  MotorMailbox& mailbox_;
  ByteTap tap_;
  pthread_t servo_;
  std::atomic<uint64_t> sent_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace haptic
