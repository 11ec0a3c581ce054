// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/faults.h"

#include <algorithm>
#include <cstdio>

#include "proto/math/units.h"
#include "proto/os/realtime.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr int64_t kBeforeNs = 60 * kMs;       // pressing between two faults
constexpr int64_t kContextNs = 15 * kMs;      // context before the first checked command
constexpr int64_t kJustBeforeNs = 50 * kMs;   // delay the device may still have
constexpr int64_t kSettleNs = 30 * kMs;       // after a fault, also checked
constexpr int64_t kHealthyNs = 10'200 * kMs;  // hapticd's ten seconds plus one look
constexpr int kFaultsPerTurn = 20;            // while a body is held, and while it is pressed
constexpr int64_t kEmptyNs = 20 * kMs;        // without a force, after which nothing is held
constexpr int64_t kCalmNs = 600 * kMs;        // in which a body that is still held hangs calm

/// Includes the stall time just before: if it is zero, the machine is no excuse.
std::string in_words(Part part, const ForceViolation& v, int64_t begin_ns,
                     std::span<const Stall> stalls) {
  const auto ms = [](int64_t ns) { return 1e-6 * static_cast<double>(ns); };
  return formatted(
      "%s: %.4f %s after %.1f ms, %.4f allowed (in the %.0f ms before, the machine stood still for "
      "%.1f ms)",
      std::string(name_of(v.breach)).c_str(), v.force, part == Part::kForce ? "N" : "N·m",
      ms(v.t_ns - begin_ns), v.allowed, ms(kJustBeforeNs),
      ms(held_up(stalls, v.t_ns - kJustBeforeNs, v.t_ns)));
}

}  // namespace

int64_t FaultInjector::ready_ns(FaultKind kind) const {
  const auto restarts = info_of(kind).restarts;
  if (restarts == nullptr) return 0;
  // hapticd itself kills what hangs, as after a standstill of the machine
  const WriterSeen& writer = (session_.*restarts)();
  return writer.generation > 1 ? writer.first_ns + kHealthyNs : 0;
}

/// Checks the commands since the last checked fault; before the first there are none.
std::vector<std::string> FaultInjector::judge_calm(int64_t until_ns) const {
  std::vector<std::string> broken;
  const JudgedFault none{.effect = Effect::kLimits,
                         .begin_ns = judged_ns_,
                         .stalls = session_.stalls(judged_ns_ - 4 * kBeforeNs, true),
                         .from_ns = judged_ns_};
  const auto records = session_.records_since(judged_ns_ - kContextNs);
  for (const ForceRules& rules : session_.rules()) {
    for (const ForceViolation& v : judge_force(rules, records, none).violations) {
      if (v.t_ns < until_ns) broken.push_back(in_words(rules.part, v, judged_ns_, none.stalls));
    }
  }
  return broken;
}

void FaultInjector::judge(const FaultInfo& info, const Inflicted& done, FaultOutcome& outcome) {
  const bool silence = info.effect == Effect::kSilence;
  const int64_t since_ns = done.begin_ns - 4 * kBeforeNs;
  // where nothing may change, nothing may change afterwards either
  const int64_t over_ns = info.effect == Effect::kNothing ? 0 : done.over_ns;
  const JudgedFault fault{
      info.effect,    done.begin_ns, over_ns, done.soft_ns, session_.stalls(since_ns, !silence),
      info.is_misled, done.from_ns};
  const auto records = session_.records_since(done.from_ns - kContextNs);
  outcome.zero_after_ns = 0;
  for (ForceRules rules : session_.rules()) {
    rules.zero_ns = info.zero_ns;
    const ForceVerdict verdict = judge_force(rules, records, fault);
    for (const ForceViolation& v : verdict.violations) {
      outcome.violations.push_back(in_words(rules.part, v, done.begin_ns, fault.stalls));
    }
    // of force and torque the later
    const bool are_zero = outcome.zero_after_ns && verdict.zero_after_ns;
    outcome.zero_after_ns =
        are_zero ? std::max(outcome.zero_after_ns, verdict.zero_after_ns) : std::nullopt;
    outcome.excused += verdict.excused;
  }
  if (info.goal_ns == 0 || !outcome.recovery_ns) return;
  // the documented time assumes a free processor; processes start at normal priority
  const int64_t stated_ns = info.goal_ns + done.waited_ns +
                            held_up(session_.stalls_of_starts(since_ns), done.recovery_from_ns,
                                    done.recovery_from_ns + *outcome.recovery_ns);
  if (*outcome.recovery_ns > stated_ns) {
    outcome.violations.push_back("whole again after " + milliseconds(*outcome.recovery_ns) + ", " +
                                 milliseconds(stated_ns) + " allowed");
  }
}

/// In a session with bodies the hand holds one in every other turn and presses it in between.
void FaultInjector::change_hands(FaultOutcome& outcome) {
  if (!session_.has_bodies() || n_faults_++ % kFaultsPerTurn != 0) return;
  const bool takes = n_faults_ / kFaultsPerTurn % 2 == 0;
  const bool done = takes ? session_.take(kFaultPatienceNs) : session_.let_go(kFaultPatienceNs);
  if (!done) {
    outcome.violations.push_back(takes ? "the block cannot be taken"
                                       : "the block cannot be pressed again");
  }
  judged_ns_ = now_ns();
}

/// True if nothing has been held for a while.
bool FaultInjector::is_empty() const {
  return std::ranges::all_of(
      session_.records_since(now_ns() - kEmptyNs),
      [](const EmulatorRecord& r) { return norm(r.force_B) < ForceRules{}.step; });
}

/// A grasp ends with whatever ends a force, and begins only when the button goes down again.
void FaultInjector::take_again(FaultOutcome& outcome) {
  if (!session_.holds()) return;
  if (!is_empty() && session_.wait_calm(kCalmNs)) return;
  if (session_.take(kFaultPatienceNs)) return;
  outcome.violations.push_back("the block cannot be taken again");
}

FaultOutcome FaultInjector::inject(FaultKind kind) {
  FaultOutcome outcome;
  outcome.kind = kind;
  change_hands(outcome);
  session_.pause(kBeforeNs);
  const int64_t from_ns = now_ns();
  if (judged_ns_ != 0) outcome.before = judge_calm(from_ns);
  Inflicted done = info_of(kind).inflict(torturer_);
  done.from_ns = from_ns;
  outcome.begin_ns = done.begin_ns;
  outcome.left_out = done.left_out;
  outcome.violations.insert(outcome.violations.end(), done.problems.begin(), done.problems.end());
  if (!done.left_out.empty()) return outcome;
  bool ends_hold = session_.holds() && info_of(kind).effect != Effect::kNothing;
  std::optional<int64_t> whole_ns;
  if (!ends_hold) {
    const int64_t patience_ns = session_.holds() ? kCalmNs : kFaultPatienceNs;
    whole_ns = session_.wait_whole(done.whole_from_ns, patience_ns);
    // a standstill of the machine ends a hold too: the commands are judged by it
    ends_hold = session_.holds() && !whole_ns && is_empty();
    if (!whole_ns && !ends_hold) {
      whole_ns = session_.wait_whole(done.whole_from_ns, kFaultPatienceNs);
    }
  }
  if (ends_hold) {
    session_.pause(kBeforeNs);
  } else if (!whole_ns) {
    outcome.violations.push_back("not whole again within " + milliseconds(kFaultPatienceNs));
  } else if (done.recovers) {
    const int64_t until_ns = done.recovered_ns != 0 ? done.recovered_ns : *whole_ns;
    outcome.recovery_ns = std::max<int64_t>(0, until_ns - done.recovery_from_ns);
  }
  session_.pause(kSettleNs);
  judge(info_of(kind), done, outcome);
  take_again(outcome);
  judged_ns_ = now_ns();
  session_.forget_before(judged_ns_ - kNsPerSecond);
  return outcome;
}

}  // namespace haptic
