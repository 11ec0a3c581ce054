// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>

#include "device-io/emulator/emulated_hid_arm.h"
#include "device-io/hidarm/hid_arm.h"
#include "device-io/hidarm/hid_exchange.h"
#include "tests/support/driver/bench.h"

namespace haptic::test {

/// The driver and an emulated arm on virtual time, in turns of a USB microframe: all of the driver
/// but hidapi and its thread. As there, each report is answered with the servo's newest command.
class HidArmBench final : public DriverBench {
 public:
  explicit HidArmBench(const EmulatedHidArmOptions& options, DeviceConfig config = {})
      : emulated_(options) {
    config.hid_arm = options.arm;
    driver_ = std::make_unique<ThreeMotorDevice>(hid_arm(config.hid_arm), hid_arm_flags(), config,
                                                 mailbox_);
  }

  void pass(int64_t t_ns) override {
    for (; t_ns_ + kTurnNs <= t_ns; t_ns_ += kTurnNs) turn();
  }
  void lie(Lie how) override { emulated_.lie(how); }
  /// The first byte is the report's number, which the kernel takes away.
  void tell(std::span<const uint8_t> bytes) override {
    emulated_.take(1, bytes.data() + 1, bytes.size() - 1, t_ns_);
  }
  const HandPlant& plant() const override { return emulated_.plant(); }
  Wrench felt_B() const override { return {emulated_.force_B(), {}}; }
  double effort() const override { return largest_of(emulated_.milliamperes()); }
  uint64_t oddities() const override { return exchange_.missed(); }
  void cut() override {
    plugged_ = false;
    mailbox_->set_gone();
  }

  EmulatedHidArm& emulated() { return emulated_; }
  const HidExchange& exchange() const { return exchange_; }
  int64_t t_ns() const override { return t_ns_; }

  static constexpr int64_t kTurnNs = 125'000;

 private:
  void turn() {
    UsbBytes packet;
    bool heard = false;
    while (plugged_ && emulated_.give(0x81, 64, packet, t_ns_)) {
      exchange_.hear(packet, t_ns_);
      heard = true;
    }
    const auto command = exchange_.command(t_ns_);
    if (heard && command) tell(*command);
  }

  EmulatedHidArm emulated_;
  std::shared_ptr<MotorMailbox> mailbox_ = std::make_shared<MotorMailbox>();
  HidExchange exchange_{*mailbox_};
  int64_t t_ns_ = kStartNs;
  bool plugged_ = true;
};

}  // namespace haptic::test
