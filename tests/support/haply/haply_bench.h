// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <memory>
#include <utility>

#include "device-io/haply/haply.h"
#include "tests/support/haply/emulated_haply.h"

namespace haptic::test {

/// The driver and an emulated board on virtual time, its line taking `delay_ns` each way: all of
/// the driver but its node.
class HaplyBench final : public Device {
 public:
  explicit HaplyBench(const EmulatedHaplyOptions& options, DeviceConfig config = {})
      : emulated_(options) {
    config.pantograph = options.arm;
    const HaplySetup setup = encode_haply_setup(kHaplyDevice, {});
    send({kHaplyReset.begin(), kHaplyReset.end()});
    send({setup.begin(), setup.end()});
    driver_ = std::make_unique<ThreeMotorDevice>(haply_arm(config.pantograph), config, mailbox_);
    pass(t_ns_ + 2'000'000);
  }

  DeviceCaps caps() const override { return driver_->caps(); }
  std::string description() const override { return driver_->description(); }
  bool read(const TickTime& tick, DeviceState& state) override {
    pass(tick.now_ns);
    return driver_->read(tick, state);
  }
  void write(const Wrench& F_B) override {
    driver_->write(F_B);
    if (!exchange_.may_ask(t_ns_)) return;
    const HaplyQuestion question = exchange_.ask(t_ns_);
    send({question.begin(), question.end()});
  }
  void stop() override { driver_->stop(); }
  DeviceRelease release() const override { return driver_->release(); }

  /// Time passes for the line and the board.
  void pass(int64_t t_ns) {
    for (; t_ns_ + kTurnNs <= t_ns; t_ns_ += kTurnNs) turn();
  }
  /// As somebody else does who has the node.
  void send(EmulatedHaply::Bytes bytes) {
    to_board_.emplace_back(t_ns_ + delay_ns, std::move(bytes));
  }

  EmulatedHaply& emulated() { return emulated_; }
  const HaplyExchange& exchange() const { return exchange_; }
  int64_t t_ns() const { return t_ns_; }

  int64_t delay_ns = 200'000;
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
  std::unique_ptr<ThreeMotorDevice> driver_;
  Sent to_board_, to_host_;
  int64_t t_ns_ = 1'000'000'000;
};

}  // namespace haptic::test
