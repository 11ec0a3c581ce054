// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "device-io/hid/hid_node.h"
#include "device-io/hidarm/hid_exchange.h"
#include "device-io/motors/transfer_thread.h"

namespace haptic {

/// The thread that reads and writes the reports of an arm, since an output report waits for the
/// device. It ends with this object, or when the device is unplugged; its last report is zero.
class HidLink final : public TransferThread {
 public:
  /// Waits until the arm has reported, for a second at most. Throws DeviceError.
  HidLink(const std::string& path, MotorMailbox& mailbox);
  ~HidLink() override { end(); }

 private:
  void run();
  bool hear_all(int wait_ms);

  HidNode node_;
  HidExchange exchange_;
};

}  // namespace haptic
