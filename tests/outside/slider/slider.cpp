// SPDX-License-Identifier: GPL-3.0-or-later
// Driver of the slider, which docs/how-to-add-a-device.md invents: a handle on a rail along z of B.
// Four bytes each way: a mark, a number that the answer repeats, 16 bits with the low byte first.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "device-io/device.h"
#include "device-io/sensing/handle_velocity.h"
#include "proto/ipc/process.h"
#include "proto/os/serial_port.h"

namespace haptic {
namespace {

constexpr uint8_t kAsks = 0xf0, kAnswers = 0x0f;  // the marks
constexpr double kMetre = 1e-5;                   // a count of the encoder [m]
constexpr double kNewton = 1e-3;                  // a unit of the force [N]
constexpr double kMaxForce = 10;                  // of the motor [N]
constexpr int64_t kAskAgainNs = 5'000'000;        // an answer takes less than a millisecond
constexpr int kGreetingMs = 2000;                 // a board that restarts when its port is opened

using Packet = std::array<uint8_t, 4>;

Packet force_packet(uint8_t number, double newtons) {
  const auto units = static_cast<uint16_t>(std::lround(newtons / kNewton));
  return {kAsks, number, static_cast<uint8_t>(units), static_cast<uint8_t>(units >> 8)};
}

class Slider final : public Device {
 public:
  Slider(const DeviceConfig& config, FileDescriptor node)
      : node_(std::move(node)),
        max_force_(std::min(config.max_force, kMaxForce)),
        cutoff_(config.serial.velocity_cutoff) {
    send(0);
    pollfd answer{node_.get(), POLLIN, 0};
    if (poll(&answer, 1, kGreetingMs) != 1 || !hear()) {
      throw DeviceError(std::string(view(config.serial.path)) +
                        ": no slider answers; check its cable and its power");
    }
  }

  DeviceCaps caps() const override { return {.max_force = max_force_}; }
  std::string description() const override { return "slider, 1 axis"; }

  bool read(const TickTime& tick, DeviceState& state) override {
    now_ns_ = tick.now_ns;
    const std::optional<int16_t> counts = hear();
    if (counts) move_to(*counts);
    const bool silent = now_ns_ - last_.t_ns > kDeviceSilenceNs;
    last_.flags = kDeviceHomed | (counts ? kDeviceFresh : kDeviceHeld) |
                  (silent ? uint32_t{kDeviceLost} : 0) |
                  (silent && strange_ ? uint32_t{kDeviceStale} : 0) |
                  (saturated_ ? uint32_t{kDeviceSaturated} : 0);
    state = last_;
    return counts.has_value();
  }

  void write(const Wrench& F_B) override {
    if (awaits_ && now_ns_ - asked_ns_ < kAskAgainNs) return;
    // only what is along the rail can be felt
    const double wanted = F_B.f.z;
    const double force = std::isfinite(wanted) ? std::clamp(wanted, -max_force_, max_force_) : 0;
    saturated_ = force != wanted;
    send((last_.flags & kDeviceLost) != 0 ? 0 : force);
  }

  void stop() override { send(0); }

  DeviceRelease release() const override {
    const Packet zero = force_packet(0, 0);
    DeviceRelease release{};
    release.by = static_cast<uint32_t>(ReleaseBy::kWrite);
    release.size = zero.size();
    std::copy(zero.begin(), zero.end(), release.bytes.begin());
    return release;
  }

 private:
  void send(double newtons) {
    const Packet packet = force_packet(++number_, newtons);
    // a full queue loses it, and it is asked again
    awaits_ = ::write(node_.get(), packet.data(), packet.size()) > 0;
    asked_ns_ = now_ns_;
  }

  /// The counts of the answer to the last question, if it has come.
  std::optional<int16_t> hear() {
    std::optional<int16_t> counts;
    std::array<uint8_t, 64> bytes;
    const ssize_t n = ::read(node_.get(), bytes.data(), bytes.size());
    for (ssize_t i = 0; i < n; ++i) {
      std::rotate(heard_.begin(), heard_.begin() + 1, heard_.end());
      heard_.back() = bytes[static_cast<size_t>(i)];
      if (heard_[0] != kAnswers) continue;
      // an old answer is none; hapticd's zero has number 0 now and then
      strange_ = heard_[1] != number_;
      if (!strange_) counts = static_cast<int16_t>(heard_[2] | heard_[3] << 8);
      heard_ = {};
    }
    awaits_ = awaits_ && !counts;
    return counts;
  }

  /// The answer is that of the last question: the handle was there when it was asked.
  void move_to(int16_t counts) {
    const Pose before_B = last_.X_BH;
    last_.X_BH.p.z = kMetre * counts;
    const double dt = 1e-9 * static_cast<double>(asked_ns_ - last_.t_ns);
    if (last_.t_ns > 0 && dt > 0) {
      low_pass_velocity(before_B, last_.X_BH, dt, cutoff_, last_.V_BH);
    }
    last_.t_ns = asked_ns_;
  }

  FileDescriptor node_;
  double max_force_, cutoff_;
  DeviceState last_{};
  Packet heard_{};
  uint8_t number_ = 0;
  int64_t now_ns_ = 0, asked_ns_ = 0;
  bool awaits_ = false, strange_ = false, saturated_ = false;
};

}  // namespace

std::unique_ptr<Device> open_slider(const DeviceConfig& config, FileDescriptor node) {
  if (!node.is_open()) node = open_serial_port(std::string(view(config.serial.path)));
  return std::make_unique<Slider>(config, std::move(node));
}

}  // namespace haptic
