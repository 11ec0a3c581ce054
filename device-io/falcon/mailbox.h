// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "device-io/falcon/packet.h"

namespace haptic {

/// An answer of the device, and the times between which it was true.
struct FalconSample {
  FalconAnswer answer;
  uint8_t number = 0;  // counts on with each answer; wraps
  int64_t asked_ns = 0, heard_ns = 0;
};

/// What the servo and the thread of the transfers tell each other, by atomics alone: neither waits.
/// One writer and one reader each way; the newest counts.
///
/// A sample fits into one word, so that it cannot be torn; its times lie in a table by its number,
/// and stay there for the next 255 answers, a quarter of a second.
class FalconMailbox {
 public:
  // the servo
  void post(const FalconCommand& command, int64_t t_ns) noexcept;
  /// The newest; none: there has been no answer yet.
  std::optional<FalconSample> newest() const noexcept;
  /// The device was unplugged: no answer will come.
  bool is_gone() const noexcept { return gone_.load(std::memory_order_acquire); }
  /// Answers do not match the questions.
  bool is_stale() const noexcept { return stale_.load(std::memory_order_acquire); }

  // the thread
  /// The servo's command, without force once it is older than kCommandLifeNs.
  FalconCommand command_at(int64_t t_ns) const noexcept;
  void put(const FalconAnswer& answer, int64_t asked_ns, int64_t heard_ns) noexcept;
  void set_stale(bool stale) noexcept { stale_.store(stale, std::memory_order_release); }
  void set_gone() noexcept { gone_.store(true, std::memory_order_release); }
  /// The servo has posted a command.
  bool is_served() const noexcept { return posted_ns_.load(std::memory_order_acquire) != 0; }

  /// hapticd releases the device of a servo that is silent for ten ticks; so does the thread.
  static constexpr int64_t kCommandLifeNs = 10'000'000;

 private:
  static constexpr uint64_t kNone = ~uint64_t{0};
  std::atomic<uint64_t> sample_{kNone};  // 48 bits of counts, 8 of flags, 8 of number
  std::array<std::atomic<int64_t>, 256> asked_ns_{}, heard_ns_{};  // by the sample's number
  std::atomic<uint64_t> command_{0};                               // 48 bits of words, 8 of flags
  std::atomic<int64_t> posted_ns_{0};
  std::atomic<bool> gone_{false}, stale_{false};
  uint8_t next_ = 0;  // of the thread
};

}  // namespace haptic
