// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <utility>

#include "device-io/emulator/emulated_falcon.h"
#include "device-io/falcon/bring_up.h"
#include "device-io/falcon/exchange.h"
#include "device-io/falcon/falcon.h"
#include "device-io/falcon/usb_link.h"
#include "tests/support/driver/bench.h"

namespace haptic::test {

/// A port to the chip of an emulated Falcon, on virtual time that it moves on.
inline FtdiPort port_of(EmulatedFalcon& device, int64_t& t_ns) {
  constexpr int64_t kFrameNs = 125'000;
  FtdiPort port;
  port.control = [&](uint8_t request, uint16_t value) {
    UsbBytes none;
    device.control({0x40, request, value, 0, 0}, {}, none, t_ns += kFrameNs);
  };
  port.send = [&](std::span<const uint8_t> bytes) {
    device.take(kFalconOut, bytes.data(), bytes.size(), t_ns += kFrameNs);
  };
  port.receive = [&](int64_t wait_ns) {
    UsbBytes packet;
    for (const int64_t until_ns = t_ns + wait_ns; t_ns < until_ns;) {
      t_ns += kFrameNs;
      if (device.give(kFalconIn, kFtdiPacket, packet, t_ns) && packet.size() > kModemStatus) {
        return UsbBytes(packet.begin() + kModemStatus, packet.end());
      }
    }
    return UsbBytes{};
  };
  return port;
}

/// The driver and an emulated Falcon on virtual time: its transfers take place in turns of 125 µs,
/// half of a packet's time on the chip's serial side. All of the driver but libusb.
class FalconBench final : public DriverBench {
 public:
  explicit FalconBench(const EmulatedFalconOptions& options, const DeviceConfig& config = {})
      : emulated_(options) {
    t_ns_ = kStartNs;
    bring_up(port_of(emulated_, t_ns_), UsbBytes(8000, 0x5a), "image");
    exchange_ = std::make_unique<FalconExchange>(*mailbox_);
    driver_ = std::make_unique<ThreeMotorDevice>(falcon_arm(config.falcon), falcon_flags(), config,
                                                 mailbox_);
  }

  void pass(int64_t t_ns) override {
    for (; t_ns_ + kTurnNs <= t_ns; t_ns_ += kTurnNs) turn();
  }

  void lie(Lie how) override { emulated_.lie(how); }
  void cut() override { emulated_.cut_power(); }
  void tell(std::span<const uint8_t> bytes) override {
    begin_anew();
    emulated_.take(kFalconOut, bytes.data(), bytes.size(), t_ns_);
  }
  const HandPlant& plant() const override { return emulated_.plant(); }
  Wrench felt_B() const override { return {emulated_.force_B(), {}}; }
  double effort() const override { return largest_of(emulated_.motors()); }
  uint64_t oddities() const override { return exchange_->surplus(); }

  /// As the link does after transfers that hapticd has cancelled.
  void begin_anew() { exchange_->begin_anew(t_ns_); }

  /// How long the machine sits on the chip's next packet [ns]; their order is kept.
  std::function<int64_t()> late = [] { return 0; };

  EmulatedFalcon& emulated() { return emulated_; }
  const FalconExchange& exchange() const { return *exchange_; }
  MotorMailbox& mailbox() { return *mailbox_; }
  int64_t t_ns() const override { return t_ns_; }

  static constexpr int64_t kTurnNs = 125'000;

 private:
  void turn() {
    UsbBytes packet;
    if (emulated_.give(kFalconIn, kFtdiPacket, packet, t_ns_)) {
      const int64_t due_ns = t_ns_ + (packet.size() > kModemStatus ? late() : 0);
      under_way_.emplace_back(std::max(due_ns, last_due_ns_), packet);
      last_due_ns_ = under_way_.back().first;
    }
    for (; !under_way_.empty() && under_way_.front().first <= t_ns_; under_way_.pop_front()) {
      exchange_->hear(under_way_.front().second, t_ns_);
    }
    if (!exchange_->may_ask(t_ns_)) return;
    const FalconBytes question = exchange_->ask(t_ns_);
    emulated_.take(kFalconOut, question.data(), question.size(), t_ns_);
  }

  EmulatedFalcon emulated_;
  std::shared_ptr<MotorMailbox> mailbox_ = std::make_shared<MotorMailbox>();
  std::unique_ptr<FalconExchange> exchange_;
  std::deque<std::pair<int64_t, UsbBytes>> under_way_;
  int64_t t_ns_ = 0, last_due_ns_ = 0;
};

}  // namespace haptic::test
