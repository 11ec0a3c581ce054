// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/exchange.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr int kTrials = 4;  // unmet challenges that show a firmware without manners
// two misses are stale, for one may be a late answer to the question before; four met challenges
// make up for a miss
constexpr int kDoubtOfMiss = 4, kMostDoubt = 2 * kDoubtOfMiss;

}  // namespace

bool FalconExchange::may_ask(int64_t t_ns) const noexcept {
  if (distrusts_) return t_ns - heard_ns_ >= kQuietNs;
  return !waits_ || t_ns - asked_ns_ >= kAskAgainNs;
}

/// The spacing varies, so that no constant delay fits it; in doubt it is short.
bool FalconExchange::is_challenge_due() noexcept {
  if (legs_ != kFalconLegs || manners_ == Manners::kIgnores) return false;
  if (--until_next_ > 0) return false;
  random_ = 1'664'525 * random_ + 1'013'904'223;  // Knuth's constants
  const bool trusts = doubt_ == 0 && manners_ == Manners::kObeys;
  const int fewest = trusts ? kFewestApart : 2;
  const int most = trusts ? kMostApart : 5;
  until_next_ =
      fewest + static_cast<int>((random_ >> 16) % static_cast<uint32_t>(most - fewest + 1));
  return true;
}

FalconBytes FalconExchange::ask(int64_t t_ns) noexcept {
  // nothing old is left: the next answer is the one to this question
  if (distrusts_) {
    distrusts_ = false;
    reader_.clear();
  }
  ++asked_;
  // while one is unanswered, the next answer may be to either
  if (!waits_) first_asked_ns_ = t_ns;
  asked_ns_ = t_ns;
  waits_ = true;
  // before the servo's first command the answers are to say whether it is homed
  MotorCommand command = mailbox_.command_at(t_ns).value_or(MotorCommand{{}, kFalconHoming});
  challenges_ = is_challenge_due();
  if (challenges_) command.flags = static_cast<uint8_t>(command.flags & ~kFalconHoming);
  return encode_falcon(command);
}

void FalconExchange::judge_challenge(bool met) noexcept {
  if (manners_ == Manners::kUnknown) {
    if (met) manners_ = Manners::kObeys;
    if (!met && ++tried_ == kTrials) manners_ = Manners::kIgnores;
    return;
  }
  if (!met) doubt_ = std::min(doubt_ + kDoubtOfMiss, kMostDoubt);
  if (met && doubt_ > 0) --doubt_;
  if (doubt_ == kMostDoubt) stale_ = true;
  if (doubt_ == 0) stale_ = false;
}

void FalconExchange::take(MotorSample answer, int64_t t_ns) noexcept {
  if (!waits_) {
    ++surplus_;
    distrusts_ = true;
    mailbox_.set_stale(true);
  }
  waits_ = false;
  if (distrusts_) return;
  ++answered_;
  answered_ns_ = t_ns;
  if (challenges_) {
    judge_challenge((answer.flags & kFalconLegs) == 0);
    answer.flags = static_cast<uint8_t>((answer.flags & ~kFalconLegs) | legs_);
  }
  legs_ = answer.flags & kFalconLegs;
  mailbox_.set_stale(stale_);
  answer.number = number_++;
  answer.asked_ns = first_asked_ns_;
  answer.heard_ns = t_ns;
  mailbox_.put(answer);
}

void FalconExchange::hear(std::span<const uint8_t> packet, int64_t t_ns) noexcept {
  if (packet.size() <= kModemStatus) return;
  heard_ns_ = t_ns;
  MotorSample answer;
  for (const uint8_t byte : packet.subspan(kModemStatus)) {
    if (reader_.push(byte, answer)) take(answer, t_ns);
  }
}

}  // namespace haptic
