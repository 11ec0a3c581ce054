// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include "device-io/haply/packet.h"
#include "device-io/motors/motor_mailbox.h"
#include "device-io/sensing/trust.h"

namespace haptic {

/// The exchange with a Haply board that is set up: one question, one answer. Bytes in, bytes out,
/// no clock of its own.
///
/// A question that is not answered within kAskAgainNs is asked again, with the same number, then
/// each time after twice as long, but for the first that tells the motors zero; then as many
/// answers may come as it was asked.
///
/// Numbers follow each other at random, so an answer with another number than the question's is
/// old, and not used. Eight of those are stale, with few good ones between, until 256 good ones
/// have come. A firmware that repeats its encoders behind the right numbers cannot be told from a
/// still hand. Answers without a number, to the zero of hapticd, are passed over.
class HaplyExchange {
 public:
  explicit HaplyExchange(MotorMailbox& mailbox) : mailbox_(mailbox) {}

  /// True if a question is due: the last one is answered, or has waited long enough.
  bool may_ask(int64_t t_ns) const noexcept;
  /// The next question, from the servo's newest command; zero before the first one.
  HaplyQuestion ask(int64_t t_ns) noexcept;
  void hear(std::span<const uint8_t> bytes, int64_t t_ns) noexcept;

  bool awaits() const noexcept { return times_ > 0; }
  uint64_t asked() const noexcept { return asked_; }
  uint64_t answered() const noexcept { return answered_; }
  /// Answers with a wrong number.
  uint64_t old() const noexcept { return old_; }

  static constexpr int64_t kAskAgainNs = 5'000'000;  // an answer takes 1 ms; the rest is the bus
  static constexpr int64_t kAskAgainMostNs = 80'000'000;

 private:
  void take(const HaplyAnswer& answer, int64_t t_ns) noexcept;
  void judge(bool good) noexcept;
  uint8_t draw_number() noexcept;

  MotorMailbox& mailbox_;
  HaplyReader reader_;
  uint64_t asked_ = 0, answered_ = 0, old_ = 0;
  int64_t asked_ns_ = 0, first_asked_ns_ = 0, patience_ns_ = kAskAgainNs;
  MotorCommand told_;       // with the last question
  uint8_t number_ = 0;      // of the last question
  int times_ = 0;           // it was asked; 0: it is answered
  uint8_t before_ = 0;      // number of the last one that was answered
  int surplus_ = 0;         // answers to it that may still come
  bool heard_old_ = false;  // since the last question
  Trust trust_;
  uint32_t random_ = 1;
  uint8_t sample_ = 0;  // number of samples
};

}  // namespace haptic
