// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "device-io/hidarm/hid_arm.h"
#include "device-io/hidarm/hid_exchange.h"
#include "tests/support/usb/emulated_hid_arm.h"

namespace haptic::test {

/// The driver and an emulated arm on virtual time, in turns of a USB microframe: all of the driver
/// but hidapi and its thread. As there, each report is answered with the servo's newest command.
class HidArmBench final : public Device {
 public:
  explicit HidArmBench(const EmulatedHidArmOptions& options, DeviceConfig config = {})
      : emulated_(options) {
    config.hid_arm = options.arm;
    driver_ = std::make_unique<ThreeMotorDevice>(hid_arm(config.hid_arm), config, mailbox_);
  }

  DeviceCaps caps() const override { return driver_->caps(); }
  std::string description() const override { return driver_->description(); }
  bool read(const TickTime& tick, DeviceState& state) override {
    pass(tick.now_ns);
    return driver_->read(tick, state);
  }
  void write(const Wrench& F_B) override { driver_->write(F_B); }
  void stop() override { driver_->stop(); }
  DeviceRelease release() const override { return driver_->release(); }

  /// Time passes for the device and the transfers.
  void pass(int64_t t_ns) {
    for (; t_ns_ + kTurnNs <= t_ns; t_ns_ += kTurnNs) turn();
  }
  void unplug() {
    plugged_ = false;
    mailbox_->set_gone();
  }

  EmulatedHidArm& emulated() { return emulated_; }
  const EmulatedHidArm& emulated() const { return emulated_; }
  const HidExchange& exchange() const { return exchange_; }
  int64_t t_ns() const { return t_ns_; }

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
    // the first byte is the report's number, which the kernel takes away
    if (heard && command) emulated_.take(1, command->data() + 1, command->size() - 1, t_ns_);
  }

  EmulatedHidArm emulated_;
  std::shared_ptr<MotorMailbox> mailbox_ = std::make_shared<MotorMailbox>();
  HidExchange exchange_{*mailbox_};
  std::unique_ptr<ThreeMotorDevice> driver_;
  int64_t t_ns_ = 1'000'000'000;
  bool plugged_ = true;
};

}  // namespace haptic::test
