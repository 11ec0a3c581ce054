// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/exchange.h"

#include <algorithm>

namespace haptic {

bool HaplyExchange::may_ask(int64_t t_ns) const noexcept {
  const bool owes_zero = mailbox_.owes_zero(told_, t_ns);
  const int64_t patience_ns = owes_zero ? std::min(patience_ns_, kAskAgainNs) : patience_ns_;
  return times_ == 0 || t_ns - asked_ns_ >= patience_ns;
}

/// Another one than the last.
uint8_t HaplyExchange::draw_number() noexcept {
  constexpr uint32_t kNumbers = kLastNumber - kFirstNumber + 1;
  random_ = 1'664'525 * random_ + 1'013'904'223;  // Knuth's constants
  const uint32_t step = 1 + (random_ >> 16) % (kNumbers - 1);
  const uint32_t from = number_ == 0 ? 0 : number_ - uint32_t{kFirstNumber};
  return static_cast<uint8_t>(kFirstNumber + (from + step) % kNumbers);
}

HaplyQuestion HaplyExchange::ask(int64_t t_ns) noexcept {
  if (times_ == 0) {
    number_ = draw_number();
    first_asked_ns_ = t_ns;
    patience_ns_ = kAskAgainNs;
  } else if (!heard_old_) {
    patience_ns_ = std::min(2 * patience_ns_, kAskAgainMostNs);
  }
  // a board that answers, though wrongly, has not fallen behind
  heard_old_ = false;
  asked_ns_ = t_ns;
  ++times_;
  ++asked_;
  told_ = mailbox_.command_at(t_ns).value_or(MotorCommand{});
  return encode_haply(number_, told_.motors[0], told_.motors[1]);
}

void HaplyExchange::judge(bool good) noexcept {
  trust_.judge(good);
  mailbox_.set_stale(trust_.is_lost());
}

void HaplyExchange::take(const HaplyAnswer& answer, int64_t t_ns) noexcept {
  if (times_ == 0 || answer.number != number_) {
    // answers come in order: before the first one to this question, all to the one before
    if (surplus_ > 0 && answer.number == before_) {
      --surplus_;
      return;
    }
    ++old_;
    heard_old_ = true;
    return judge(false);
  }
  before_ = number_;
  surplus_ = times_ - 1;
  times_ = 0;
  ++answered_;
  judge(true);
  MotorSample sample;
  sample.counts = {answer.counts[0], answer.counts[1], 0};
  sample.number = sample_++;
  sample.asked_ns = first_asked_ns_;
  sample.heard_ns = t_ns;
  mailbox_.put(sample);
}

void HaplyExchange::hear(std::span<const uint8_t> bytes, int64_t t_ns) noexcept {
  HaplyAnswer answer;
  for (const uint8_t byte : bytes) {
    if (reader_.push(byte, answer)) take(answer, t_ns);
  }
}

}  // namespace haptic
