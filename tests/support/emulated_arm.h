// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "device-io/device.h"
#include "device-io/emulator/firmware.h"
#include "proto/config/device_config.h"

namespace haptic::test {

/// The real driver and the emulated board on virtual time: a socket pair replaces the serial line,
/// and the board runs every quarter of a millisecond.
template <typename Driver>
class EmulatedArm final : public Device {
 public:
  explicit EmulatedArm(const EmulatedDeviceOptions& options, const DeviceConfig& config = {})
      : board_(options, 0) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) != 0) {
      throw std::runtime_error("no pair of sockets");
    }
    wire_ = FileDescriptor(ends[0]);
    // the answer to the greeting, for which the driver waits in real time
    say("[" + std::to_string(options.arm->model) + ",0,0,0,0,0,0,0]\n");
    node_ = ends[1];
    driver_ = std::make_unique<Driver>(config, FileDescriptor(ends[1]));
    hear();
  }

  DeviceCaps caps() const override { return driver_->caps(); }
  std::string description() const override { return driver_->description(); }
  bool read(const TickTime& tick, DeviceState& state) override {
    pass(tick.now_ns);
    return driver_->read(tick, state);
  }
  /// Time passes for the board only.
  void pass(int64_t t_ns) {
    while (turned_ns_ + kTurnNs <= t_ns) turn(turned_ns_ + kTurnNs);
  }
  void write(const Wrench& F_B) override { driver_->write(F_B); }
  void stop() override { driver_->stop(); }

  /// Delay until the driver can read the board's answers; their order is kept.
  int64_t delay_ns = 0;

  /// Descriptor of the driver's end.
  int node() const { return node_; }

  EmulatedDevice& board() { return board_; }
  const Driver& driver() const { return *driver_; }

 private:
  static constexpr int64_t kTurnNs = 250'000;

  void turn(int64_t t_ns) {
    turned_ns_ = t_ns;
    const std::string asked = hear();
    board_.receive({asked.data(), asked.size()});
    board_.turn(t_ns);
    if (!board_.answer().empty()) under_way_.emplace_back(t_ns + delay_ns, board_.answer());
    for (; !under_way_.empty() && under_way_.front().first <= t_ns; under_way_.pop_front()) {
      say(under_way_.front().second);
    }
  }
  void say(std::string_view text) const {
    const auto size = static_cast<ssize_t>(text.size());
    if (!text.empty() && ::write(wire_.get(), text.data(), text.size()) != size) {
      throw std::runtime_error("the line is full");
    }
  }
  std::string hear() const {
    std::array<char, 256> bytes;
    const ssize_t n = ::read(wire_.get(), bytes.data(), bytes.size());
    return n > 0 ? std::string(bytes.data(), static_cast<size_t>(n)) : std::string();
  }

  EmulatedDevice board_;
  std::deque<std::pair<int64_t, std::string>> under_way_;
  FileDescriptor wire_;
  int node_ = -1;
  std::unique_ptr<Driver> driver_;
  int64_t turned_ns_ = 999'000'000;  // the first tick of virtual time is at one second
};

}  // namespace haptic::test
