// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "device-io/hidarm/report.h"
#include "device-io/motors/motor_mailbox.h"
#include "device-io/sensing/trust.h"

namespace haptic {

/// The exchange with an arm that reports by itself, 1000 times a second, and takes currents at any
/// time. Bytes in, bytes out, no clock of its own.
///
/// The counter of the reports is what shows a lie: it rises by one with each. A report whose
/// counter stands still, or goes back, is old and not used. Eight of them, with few good ones
/// between, are stale, until 256 good ones have come. A firmware that counts on but repeats its
/// encoders cannot be told from a still hand, and one that delays all reports alike not from a
/// slower device; the force that they cause stays below the limits of safety.
class HidExchange {
 public:
  explicit HidExchange(MotorMailbox& mailbox) : mailbox_(mailbox) {}

  /// Takes an input report. Of several that wait, all are to be given; the newest counts.
  void hear(std::span<const uint8_t> report, int64_t t_ns) noexcept;

  /// The report to send now; none: the servo has not begun. Zero once its command is too old.
  std::optional<HidArmCommand> command(int64_t t_ns) const noexcept;

  uint64_t heard() const noexcept { return heard_; }
  /// Reports that were made, by their counter, but never came.
  uint64_t missed() const noexcept { return missed_; }
  uint64_t rejected() const noexcept { return rejected_; }

 private:
  bool is_in_order(uint16_t counter, int64_t t_ns) noexcept;

  MotorMailbox& mailbox_;
  uint64_t heard_ = 0, missed_ = 0, rejected_ = 0;
  uint16_t counter_ = 0;
  int64_t heard_ns_ = 0;  // the last report in order
  Trust trust_;
};

}  // namespace haptic
