// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

namespace haptic {

/// An answer of a device of three motors, and the times between which it was true.
struct MotorSample {
  std::array<int16_t, 3> counts{};  // of the encoders; they wrap
  uint8_t flags = 0;                // of the device
  uint8_t number = 0;               // differs from that of the sample before
  int64_t asked_ns = 0, heard_ns = 0;
};

/// A command to such a device.
struct MotorCommand {
  std::array<int16_t, 3> motors{};  // in the units of the device
  uint8_t flags = 0;                // of the device
};

constexpr bool is_zero(const MotorCommand& command) {
  return command.motors == std::array<int16_t, 3>{};
}

/// Passes commands and samples between the servo and a thread of transfers, by atomics alone:
/// neither waits. One writer and one reader each way; the newest counts.
///
/// A sample fits into one word, so that it cannot be torn; its times lie in a table by its number,
/// and stay there for the next 255 numbers, a quarter of a second.
class MotorMailbox {
 public:
  // the servo
  void post(const MotorCommand& command, int64_t t_ns) noexcept;
  /// The newest; none: there has been no answer yet.
  std::optional<MotorSample> newest() const noexcept;
  /// The device was unplugged: no answer will come.
  bool is_gone() const noexcept { return gone_.load(std::memory_order_acquire); }
  /// Answers do not match the questions.
  bool is_stale() const noexcept { return stale_.load(std::memory_order_acquire); }

  // the thread
  /// The servo's command, with motors at zero once it is older than kCommandLifeNs; none: there has
  /// been no command yet.
  std::optional<MotorCommand> command_at(int64_t t_ns) const noexcept;
  /// True if a device that was told this last is now to be told zero: no back-off puts that off.
  bool owes_zero(const MotorCommand& told, int64_t t_ns) const noexcept {
    return !is_zero(told) && is_zero(command_at(t_ns).value_or(MotorCommand{}));
  }
  void put(const MotorSample& sample) noexcept;
  void set_stale(bool stale) noexcept { stale_.store(stale, std::memory_order_release); }
  void set_gone() noexcept { gone_.store(true, std::memory_order_release); }

  /// hapticd releases the device of a servo that is silent for ten ticks; so does the thread.
  static constexpr int64_t kCommandLifeNs = 10'000'000;

 private:
  std::atomic<uint64_t> sample_{0};   // 48 bits of counts, 8 of flags, 8 of number
  std::atomic<uint64_t> command_{0};  // 48 bits of motors, 8 of flags
  std::array<std::atomic<int64_t>, 256> asked_ns_{}, heard_ns_{};  // by the sample's number
  std::atomic<int64_t> posted_ns_{0};
  std::atomic<bool> any_{false}, gone_{false}, stale_{false};
};

}  // namespace haptic
