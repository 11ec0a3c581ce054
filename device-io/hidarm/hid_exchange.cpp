// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hidarm/hid_exchange.h"

namespace haptic {
namespace {

constexpr uint16_t kMostMissed = 1000;   // a second of reports; a larger step is a restart
constexpr int64_t kGapNs = 100'000'000;  // after it the device may have been restarted

}  // namespace

/// True if a counter goes on from the one before.
bool HidExchange::is_in_order(uint16_t counter, int64_t t_ns) noexcept {
  const auto step = static_cast<uint16_t>(counter - counter_);
  const bool first = heard_ == 0 || t_ns - heard_ns_ > kGapNs;
  if (!first && (step == 0 || step > kMostMissed)) return false;
  if (!first) missed_ += step - 1u;
  counter_ = counter;
  heard_ns_ = t_ns;
  return true;
}

void HidExchange::hear(std::span<const uint8_t> report, int64_t t_ns) noexcept {
  MotorSample sample;
  uint16_t counter = 0;
  if (!decode_hid_arm(report, sample, counter)) {
    ++rejected_;
    return;
  }
  const int64_t before_ns = heard_ns_;
  const bool good = is_in_order(counter, t_ns);
  trust_.judge(good);
  mailbox_.set_stale(trust_.is_lost());
  if (!good) return;
  // the counts were true between the last report and this one
  sample.asked_ns = heard_++ == 0 ? t_ns : before_ns;
  sample.heard_ns = t_ns;
  mailbox_.put(sample);
}

std::optional<HidArmCommand> HidExchange::command(int64_t t_ns) const noexcept {
  const std::optional<MotorCommand> wanted = mailbox_.command_at(t_ns);
  if (!wanted) return std::nullopt;
  return encode_hid_arm(wanted->motors);
}

}  // namespace haptic
