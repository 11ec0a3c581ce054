// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>
#include <span>

#include <array>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "device-io/emulator/firmware.h"
#include "device-io/woodenhaptics/motor_device.h"
#include "proto/config/device_config.h"
#include "tests/support/driver/bench.h"

namespace haptic::test {

/// The real driver and the emulated board on virtual time: a socket pair replaces the serial line,
/// and the board runs every quarter of a millisecond.
class EmulatedArm final : public DriverBench {
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
    driver_ = std::make_unique<MotorDevice>(*options.arm, config, FileDescriptor(ends[1]));
    hear();
  }

  void pass(int64_t t_ns) override {
    while (turned_ns_ + kTurnNs <= t_ns) turn(turned_ns_ + kTurnNs);
  }
  void lie(Lie how) override {
    lie_ = how;
    mirror_ = board_.record().counts[encoder];
    board_.lie(how);
    board_.disturb({}, 0);
  }
  void cut() override {
    is_cut_ = true;
    shutdown(wire_.get(), SHUT_WR);
  }
  void tell(std::span<const uint8_t> bytes) override {
    board_.receive({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  const HandPlant& plant() const override { return board_.plant(); }
  Wrench felt_B() const override { return {board_.record().force_B, board_.record().torque_B}; }
  double effort() const override { return largest_of(board_.record().currents); }
  uint64_t oddities() const override { return driver().rejected(); }

  int64_t t_ns() const override { return turned_ns_; }
  int node() const override { return node_; }

  EmulatedDevice& board() { return board_; }
  const MotorDevice& driver() const { return static_cast<const MotorDevice&>(*driver_); }

 private:
  static constexpr int64_t kTurnNs = 250'000;

  void turn(int64_t t_ns) {
    turned_ns_ = t_ns;
    if (lie_ == Lie::kSilent || is_cut_) return;
    MotorCounts off{};
    off[encoder] = lie_ == Lie::kFlipped ? 2 * (mirror_ - board_.record().counts[encoder]) : 3000;
    if (lie_ == Lie::kFlipped || lie_ == Lie::kSlipped) board_.disturb(off, 10);
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
  Lie lie_ = Lie::kHealthy;
  bool is_cut_ = false;
  int32_t mirror_ = 0;               // of an encoder that counts backwards
  int64_t turned_ns_ = 999'000'000;  // the first tick of virtual time is at one second
};

/// A driver of a line, before the board of its arm or of another one.
template <const Arm& (*arm)()>
std::unique_ptr<DriverBench> open_line(const SimulatedHandConfig& hand,
                                       const DeviceConfig& config) {
  EmulatedDeviceOptions options;
  options.hand = hand;
  options.arm = &arm();
  return std::make_unique<EmulatedArm>(options, config);
}

}  // namespace haptic::test
