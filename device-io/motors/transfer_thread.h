// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pthread.h>

#include <atomic>
#include <cstdint>
#include <span>
#include <thread>
#include <utility>

#include "device-io/device.h"
#include "device-io/motors/motor_mailbox.h"

namespace haptic {

/// A thread that exchanges with a device what a mailbox holds: a transfer waits for the device,
/// which the servo must not. With the servo's first command it takes on the servo's scheduling, one
/// priority above: an answer that is late is worth more than a tick that has nothing to say.
class TransferThread {
 public:
  TransferThread(const TransferThread&) = delete;
  TransferThread& operator=(const TransferThread&) = delete;
  virtual ~TransferThread() = default;

  /// Waits until the servo's last command has been sent, at most kStopNs.
  void stop() const;
  static constexpr int64_t kStopNs = 20'000'000;

  /// Tells `hears` of what the thread says and hears from now on. At most once, from any thread.
  void tap(HearBytes hears);

 protected:
  /// Called by the servo's thread.
  explicit TransferThread(MotorMailbox& mailbox) : mailbox_(mailbox), servo_(pthread_self()) {}

  template <typename Run>
  void start(Run run) {
    thread_ = std::thread(std::move(run));
  }
  /// To be called by the destructor of the class whose members the thread uses.
  void end();

  // the thread
  /// Does nothing if the servo has no real-time scheduling, or the right is missing, which the
  /// servo has reported by then.
  void follow_servo();
  void note_sent() { sent_.fetch_add(1, std::memory_order_release); }
  bool is_tapped() const noexcept { return is_tapped_.load(std::memory_order_acquire); }
  void tell(bool by_device, std::span<const uint8_t> bytes, int64_t t_ns) const {
    if (is_tapped()) hears_(by_device, bytes, t_ns);
  }

  MotorMailbox& mailbox_;
  std::atomic<bool> ending_{false};

 private:
  pthread_t servo_;
  bool follows_ = false;
  HearBytes hears_;
  std::atomic<bool> is_tapped_{false};
  std::atomic<uint64_t> sent_{0};
  std::thread thread_;
};

}  // namespace haptic
