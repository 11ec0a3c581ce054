// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/exchange.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr int64_t kLateNs = 200'000'000;     // after a question had to be asked again
constexpr int64_t kGapNs = 100'000'000;      // without answers
constexpr int64_t kUnmetNs = 1'000'000'000;  // forty challenges, none of them met
// hapticd's four packets, 5 ms apart, and their answers: ten times as long where they were late
constexpr int64_t kExcusedNs = 200'000'000;
constexpr int64_t kMostQuietNs = 20'000'000;  // as long as a device may be silent and not lost
constexpr int kGoodForDoubt = 32;             // answers for a challenge that is met
constexpr int kTrials = 4;  // unmet challenges that show a firmware without manners
// four misses are stale, for a busy machine may mistake a late answer for another; as many
// challenges that are met make up for one
constexpr int kDoubtOfMiss = FalconExchange::kMostDoubt / 4;

}  // namespace

bool FalconExchange::may_ask(int64_t t_ns) const noexcept {
  if (distrusts_) return t_ns - heard_ns_ >= std::max(kQuietNs, quiet_ns_);
  if (owed_ == 0) return true;
  if (heard_since_) return t_ns - heard_ns_ >= kQuietNs;
  const bool owes_zero = mailbox_.owes_zero(told_, t_ns);
  return t_ns - asked_ns_ >= (owes_zero ? std::min(patience_ns_, kAskAgainNs) : patience_ns_);
}

/// The spacing varies, so that no constant delay fits it; in doubt it is short.
bool FalconExchange::is_challenge_due() noexcept {
  if (legs_ != kFalconLegs || manners_ == Manners::kIgnores) return false;
  if (--until_next_ > 0) return false;
  random_ = 1'664'525 * random_ + 1'013'904'223;  // Knuth's constants
  const bool trusts = trust_.is_whole() && manners_ == Manners::kObeys;
  const int fewest = trusts ? kFewestApart : 2;
  const int most = trusts ? kMostApart : 5;
  until_next_ =
      fewest + static_cast<int>((random_ >> 16) % static_cast<uint32_t>(most - fewest + 1));
  return true;
}

FalconBytes FalconExchange::ask(int64_t t_ns) noexcept {
  if (distrusts_) reader_.clear();
  // answers come in order, so after a silence nothing is left of what came before the last answer
  if (distrusts_ || heard_since_) owed_ = 0;
  patience_ns_ = owed_ == 0 ? kAskAgainNs : std::min(2 * patience_ns_, kAskAgainMostNs);
  distrusts_ = heard_since_ = false;
  ++asked_;
  if (owed_ == 0) first_asked_ns_ = t_ns;
  asked_ns_ = t_ns;
  alone_ = ++owed_ == 1;
  // on a machine or bus so busy, late answers are no lie
  if (!alone_) excused_ns_ = std::max(excused_ns_, t_ns + kLateNs);
  // before the servo's first command the answers are to say whether it is homed
  MotorCommand command = mailbox_.command_at(t_ns).value_or(MotorCommand{{}, kFalconHoming});
  // the answer to a challenge must be told from others
  challenges_ = alone_ && is_challenge_due();
  if (challenges_) command.flags = static_cast<uint8_t>(command.flags & ~kFalconHoming);
  told_ = command;
  return encode_falcon(command);
}

/// A challenge hides the homed bits of its own answer behind those before it, which a firmware that
/// has just begun does not have.
void FalconExchange::restart() noexcept {
  reader_.clear();
  owed_ = 0;
  heard_since_ = distrusts_ = challenges_ = false;
  legs_ = 0;
}

void FalconExchange::judge_challenge(bool met, int64_t t_ns) noexcept {
  if (met) met_ns_ = t_ns;
  if (manners_ == Manners::kUnknown) {
    if (met) manners_ = Manners::kObeys;
    if (!met && ++tried_ == kTrials) manners_ = Manners::kIgnores;
    return;
  }
  const bool was_stale = trust_.is_lost();
  if (met || t_ns >= std::max(excused_ns_, busy_ns_)) doubt(met ? -1 : kDoubtOfMiss);
  // an answer may have been taken for that of the question after it; silence tells them apart, a
  // longer one each time, and a lie outlives it. The first question of a stale device is not held
  // back, for it carries zero force
  distrusts_ |= !met && trust_.is_lost() == was_stale;
  quiet_ns_ = met ? kQuietNs / 2
                  : std::min(2 * quiet_ns_, trust_.is_lost() ? kAskAgainMostNs : kMostQuietNs);
}

void FalconExchange::doubt(int weight) noexcept {
  trust_.doubt(weight);
  mailbox_.set_stale(trust_.is_lost());
}

void FalconExchange::begin_anew(int64_t t_ns) noexcept {
  heard_ns_ = t_ns;
  excused_ns_ = t_ns + kExcusedNs;
  distrusts_ = true;
  owed_ = 0;
}

void FalconExchange::take(MotorSample answer, int64_t t_ns) noexcept {
  if (owed_ == 0) {
    distrusts_ = true;
    if (t_ns < excused_ns_) return;
    ++surplus_;
    doubt(kDoubtOfMiss);
    return;
  }
  --owed_;
  heard_since_ = true;
  ++answered_;
  // after a gap, or without homing, there was no challenge to meet
  if (t_ns - answered_ns_ > kGapNs || legs_ != kFalconLegs) met_ns_ = t_ns;
  answered_ns_ = t_ns;
  if (challenges_) {
    judge_challenge((answer.flags & kFalconLegs) == 0, t_ns);
  }
  // the answer to a challenge says nothing of the legs, and of several under way any may be one
  if (challenges_ || (!alone_ && manners_ == Manners::kObeys)) {
    answer.flags = static_cast<uint8_t>((answer.flags & ~kFalconLegs) | legs_);
  }
  legs_ = answer.flags & kFalconLegs;
  if (manners_ != Manners::kObeys && ++good_ % kGoodForDoubt == 0) doubt(-1);
  const int64_t unmet_ns = t_ns - std::max({met_ns_, excused_ns_, busy_ns_});
  if (manners_ == Manners::kObeys && unmet_ns > kUnmetNs) doubt(kMostDoubt);
  answer.number = number_++;
  answer.asked_ns = first_asked_ns_;
  answer.heard_ns = t_ns;
  mailbox_.put(answer);
}

void FalconExchange::hear(std::span<const uint8_t> packet, int64_t t_ns) noexcept {
  // the chip says something every millisecond, whatever the firmware does: else the machine is busy
  if (t_ns - packet_ns_ > kAskAgainNs) busy_ns_ = t_ns + kLateNs;
  packet_ns_ = t_ns;
  if (packet.size() <= kModemStatus) return;
  heard_ns_ = t_ns;
  MotorSample answer;
  for (const uint8_t byte : packet.subspan(kModemStatus)) {
    if (reader_.push(byte, answer)) take(answer, t_ns);
  }
}

}  // namespace haptic
