// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "device-io/device.h"
#include "proto/os/realtime.h"

namespace haptic::test {

/// A driver under guard, whose device is played by a thread of its own, as a kernel and a firmware
/// would: each read first waits until that thread has come to this tick of virtual time. They wait
/// for each other by atomics and short sleeps until a deadline, which the guard allows.
class PlayedDevice final : public Device {
 public:
  /// `pass` moves the device on to an instant; only the thread calls it, and never at the same time
  /// as the driver is called. `start_ns`: the first tick for driver and device; 0: the loop's.
  PlayedDevice(std::unique_ptr<Device> driver, std::function<void(int64_t t_ns)> pass,
               int64_t start_ns)
      : driver_(std::move(driver)), pass_(std::move(pass)), start_ns_(start_ns) {
    player_ = std::thread([this] { play(); });
  }
  ~PlayedDevice() override {
    ending_ = true;
    player_.join();
  }

  DeviceCaps caps() const override { return driver_->caps(); }
  std::string description() const override { return driver_->description(); }
  /// On the grid of ticks: a late wake-up of the first tick, which is in real time, is not followed
  /// by other late ones.
  bool read(const TickTime& tick, DeviceState& state) override {
    if (wanted_ns_ == 0) shift_ns_ = start_ns_ == 0 ? 0 : start_ns_ - tick.deadline_ns;
    const int64_t t_ns = tick.deadline_ns + shift_ns_;
    wanted_ns_.store(t_ns, std::memory_order_release);
    wait([&] { return played_ns_.load(std::memory_order_acquire) == t_ns; });
    const bool fresh = driver_->read({t_ns, t_ns}, state);
    state.t_ns -= shift_ns_;
    fresh_ += fresh ? 1 : 0;
    return fresh;
  }
  void write(const Wrench& F_B) override { driver_->write(F_B); }
  Wrench holding(const GravityConfig& gravity) const override { return driver_->holding(gravity); }
  void stop() override { driver_->stop(); }

  /// Samples so far.
  uint64_t fresh() const { return fresh_; }

 private:
  template <typename Until>
  static void wait(Until until) {
    constexpr int kSpins = 100;  // some 3 µs; a busy machine has no processor to spin on
    constexpr int64_t kNapNs = 50'000;
    for (int i = 0; !until(); ++i) {
      if (i > kSpins) sleep_until(now_ns() + kNapNs);
    }
  }

  void play() {
    while (!ending_) {
      wait([&] { return ending_ || wanted_ns_ != played_ns_; });
      const int64_t t_ns = wanted_ns_.load(std::memory_order_acquire);
      if (!ending_) pass_(t_ns);
      played_ns_.store(t_ns, std::memory_order_release);
    }
  }

  std::unique_ptr<Device> driver_;
  std::function<void(int64_t)> pass_;
  int64_t start_ns_, shift_ns_ = 0;
  uint64_t fresh_ = 0;
  std::atomic<int64_t> wanted_ns_{0}, played_ns_{0};
  std::atomic<bool> ending_{false};
  std::thread player_;  // last: it uses all of the above
};

}  // namespace haptic::test
