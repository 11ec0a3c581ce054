// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <memory>
#include <span>
#include <utility>

#include "device-io/emulator/emulated_haply.h"
#include "device-io/haply/haply.h"
#include "tests/support/driver/bench.h"

namespace haptic::test {

/// The driver and an emulated board on virtual time: all of the driver but its node.
class HaplyBench final : public DriverBench {
 public:
  explicit HaplyBench(const EmulatedHaplyOptions& options, DeviceConfig config = {})
      : emulated_(options) {
    delay_ns = 200'000;
    config.pantograph = options.arm;
    const HaplySetup setup = encode_haply_setup(kHaplyDevice, {});
    tell(kHaplyReset);
    tell(setup);
    driver_ = std::make_unique<ThreeMotorDevice>(haply_arm(config.pantograph), haply_flags(),
                                                 config, mailbox_);
    pass(t_ns_ + 2'000'000);
  }

  void write(const Wrench& F_B) override {
    driver_->write(F_B);
    if (!exchange_.may_ask(t_ns_)) return;
    const HaplyQuestion question = exchange_.ask(t_ns_);
    tell(question);
  }

  void pass(int64_t t_ns) override {
    for (; t_ns_ + kTurnNs <= t_ns; t_ns_ += kTurnNs) turn();
  }
  void lie(Lie how) override { emulated_.lie(how); }
  void cut() override { emulated_.cut_power(); }
  const HandPlant& plant() const override { return emulated_.plant(); }
  Wrench felt_B() const override { return {emulated_.force_B(), {}}; }
  double effort() const override { return emulated_.largest_torque(); }
  uint64_t oddities() const override { return exchange_.old(); }
  void tell(std::span<const uint8_t> bytes) override {
    to_board_.emplace_back(t_ns_ + delay_ns, EmulatedHaply::Bytes(bytes.begin(), bytes.end()));
  }

  EmulatedHaply& emulated() { return emulated_; }
  const HaplyExchange& exchange() const { return exchange_; }
  int64_t t_ns() const override { return t_ns_; }

  static constexpr int64_t kTurnNs = 50'000;

 private:
  using Sent = std::deque<std::pair<int64_t, EmulatedHaply::Bytes>>;

  void turn() {
    for (; !to_board_.empty() && to_board_.front().first <= t_ns_; to_board_.pop_front()) {
      emulated_.take(to_board_.front().second, t_ns_);
    }
    EmulatedHaply::Bytes said = emulated_.give(t_ns_);
    if (!said.empty()) to_host_.emplace_back(t_ns_ + delay_ns, std::move(said));
    for (; !to_host_.empty() && to_host_.front().first <= t_ns_; to_host_.pop_front()) {
      exchange_.hear(to_host_.front().second, t_ns_);
    }
  }

  EmulatedHaply emulated_;
  std::shared_ptr<MotorMailbox> mailbox_ = std::make_shared<MotorMailbox>();
  HaplyExchange exchange_{*mailbox_};
  Sent to_board_, to_host_;
  int64_t t_ns_ = kStartNs;
};

}  // namespace haptic::test
