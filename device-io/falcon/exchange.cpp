// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/exchange.h"

#include <algorithm>

#include "device-io/device.h"

namespace haptic {
namespace {

constexpr int64_t kLateNs = 200'000'000;     // after a question had to be asked again
constexpr int64_t kGapNs = 100'000'000;      // without answers
constexpr int64_t kUnmetNs = 1'000'000'000;  // forty challenges, none of them met
// hapticd's four packets, 5 ms apart, and their answers: ten times as long where they were late
constexpr int64_t kExcusedNs = 200'000'000;
constexpr int kGoodForDoubt = 32;  // answers for a challenge that is met
constexpr int kTrials = 4;         // unmet challenges that show a firmware without manners
// four misses are stale, for a busy machine may mistake a late answer for another; as many
// challenges that are met make up for one
constexpr int kDoubtOfMiss = FalconExchange::kMostDoubt / 4;

}  // namespace

FalconTurn FalconTurn::after(Event event) const noexcept {
  const bool awaits = state == State::kAsked || state == State::kAskedAgain;
  switch (event) {
    case Event::kAsk:
      // answers come in order, so after a silence nothing is left of what came before the last one
      return awaits ? FalconTurn{State::kAskedAgain, owed + 1} : FalconTurn{State::kAsked, 1};
    case Event::kAnswer:
      if (owed > 1) return {State::kDraining, owed - 1};
      return {owed == 1 ? State::kFree : State::kHushed, 0};
    case Event::kDistrust:
      return {State::kHushed, 0};
    case Event::kBroughtUp:
      break;
  }
  return {};
}

bool FalconExchange::may_ask(int64_t t_ns) const noexcept {
  const int64_t silent_ns = t_ns - heard_ns_;
  switch (turn_.state) {
    case State::kFree:
      return true;
    case State::kHushed:
      return silent_ns >= std::max(kQuietNs, challenges_.quiet_ns);
    case State::kDraining:
      return silent_ns >= kQuietNs;
    case State::kAsked:
    case State::kAskedAgain:
      break;
  }
  const bool owes_zero = mailbox_.owes_zero(told_, t_ns);
  return t_ns - asked_ns_ >= (owes_zero ? std::min(patience_ns_, kAskAgainNs) : patience_ns_);
}

/// The spacing varies, so that no constant delay fits it; in doubt it is short.
bool FalconExchange::is_challenge_due() noexcept {
  if (legs_ != kFalconLegs || challenges_.manners == Manners::kIgnores) return false;
  if (--challenges_.until_next > 0) return false;
  challenges_.random = 1'664'525 * challenges_.random + 1'013'904'223;  // Knuth's constants
  const bool trusts = trust_.is_whole() && is_challenged();
  const int fewest = trusts ? kFewestApart : 2;
  const int most = trusts ? kMostApart : 5;
  const auto room = static_cast<uint32_t>(most - fewest + 1);
  challenges_.until_next = fewest + static_cast<int>((challenges_.random >> 16) % room);
  return true;
}

FalconBytes FalconExchange::ask(int64_t t_ns) noexcept {
  if (turn_.state == State::kHushed) reader_.clear();
  turn_ = turn_.after(Event::kAsk);
  const bool alone = turn_.state == State::kAsked;
  patience_ns_ = alone ? kAskAgainNs : std::min(2 * patience_ns_, kAskAgainMostNs);
  if (alone) first_asked_ns_ = t_ns;
  asked_ns_ = t_ns;
  // on a machine or bus so busy, late answers are no lie
  if (!alone) excused_ns_ = std::max(excused_ns_, t_ns + kLateNs);
  // before the servo's first command the answers are to say whether it is homed
  told_ = mailbox_.command_at(t_ns).value_or(MotorCommand{{}, kFalconHoming});
  // the answer to a challenge must be told from others
  challenges_.is_one = alone && is_challenge_due();
  if (challenges_.is_one) told_.flags = static_cast<uint8_t>(told_.flags & ~kFalconHoming);
  return encode_falcon(told_);
}

/// A challenge hides the homed bits of its own answer behind those before it, which a firmware that
/// has just begun does not have.
void FalconExchange::restart() noexcept {
  reader_.clear();
  turn_ = turn_.after(Event::kBroughtUp);
  challenges_.is_one = false;
  legs_ = 0;
}

void FalconExchange::judge_challenge(bool met, int64_t t_ns) noexcept {
  if (met) challenges_.met_ns = t_ns;
  if (challenges_.manners == Manners::kUnknown) {
    if (met) challenges_.manners = Manners::kObeys;
    if (!met && ++challenges_.tried == kTrials) challenges_.manners = Manners::kIgnores;
    return;
  }
  const bool was_stale = trust_.is_lost();
  if (met || t_ns >= std::max(excused_ns_, busy_ns_)) doubt(met ? -1 : kDoubtOfMiss);
  // an answer may have been taken for that of the question after it; silence tells them apart, a
  // longer one each time, and a lie outlives it. The first question of a stale device is not held
  // back, for it carries zero force
  if (!met && trust_.is_lost() == was_stale) turn_ = turn_.after(Event::kDistrust);
  const int64_t longest_ns = trust_.is_lost() ? kAskAgainMostNs : kDeviceSilenceNs;
  challenges_.quiet_ns = met ? kQuietNs / 2 : std::min(2 * challenges_.quiet_ns, longest_ns);
}

void FalconExchange::doubt(int weight) noexcept {
  trust_.doubt(weight);
  mailbox_.set_stale(trust_.is_lost());
}

void FalconExchange::begin_anew(int64_t t_ns) noexcept {
  heard_ns_ = t_ns;
  excused_ns_ = t_ns + kExcusedNs;
  turn_ = turn_.after(Event::kDistrust);
}

/// False: nobody has asked for this answer.
bool FalconExchange::take(MotorSample& answer, int64_t t_ns) noexcept {
  const FalconTurn before = turn_;
  turn_ = turn_.after(Event::kAnswer);
  if (before.owed == 0) {
    if (t_ns < excused_ns_) return false;
    ++surplus_;
    doubt(kDoubtOfMiss);
    return false;
  }
  ++answered_;
  // after a gap, or without homing, there was no challenge to meet
  if (t_ns - answered_ns_ > kGapNs || legs_ != kFalconLegs) challenges_.met_ns = t_ns;
  answered_ns_ = t_ns;
  if (challenges_.is_one) judge_challenge((answer.flags & kFalconLegs) == 0, t_ns);
  // the answer to a challenge says nothing of the legs, and of several under way any may be one
  if (challenges_.is_one || (before.state != State::kAsked && is_challenged())) {
    answer.flags = static_cast<uint8_t>((answer.flags & ~kFalconLegs) | legs_);
  }
  legs_ = answer.flags & kFalconLegs;
  if (!is_challenged() && answered_ % kGoodForDoubt == 0) doubt(-1);
  const int64_t unmet_ns = t_ns - std::max({challenges_.met_ns, excused_ns_, busy_ns_});
  if (is_challenged() && unmet_ns > kUnmetNs) doubt(kMostDoubt);
  answer.number = static_cast<uint8_t>(answered_);
  answer.asked_ns = first_asked_ns_;
  answer.heard_ns = t_ns;
  return true;
}

void FalconExchange::hear(std::span<const uint8_t> packet, int64_t t_ns) noexcept {
  // the chip says something every millisecond, whatever the firmware does: else the machine is busy
  if (t_ns - packet_ns_ > kAskAgainNs) busy_ns_ = t_ns + kLateNs;
  packet_ns_ = t_ns;
  if (packet.size() <= kModemStatus) return;
  heard_ns_ = t_ns;
  MotorSample answer;
  for (const uint8_t byte : packet.subspan(kModemStatus)) {
    if (reader_.push(byte, answer) && take(answer, t_ns)) mailbox_.put(answer);
  }
}

}  // namespace haptic
