// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/faults.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <memory>
#include <thread>

#include "clients/lab/torture/faulty/fault_order.h"
#include "device-io/emulator/fault_order.h"
#include "proto/ipc/process.h"
#include "proto/math/units.h"
#include "proto/os/programs.h"
#include "proto/os/queued_order.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kPatienceNs = 20 * kNsPerSecond;  // only a broken session takes this long
constexpr int64_t kBeforeNs = 60 * kMs;             // pressing between two faults
constexpr int64_t kContextNs = 15 * kMs;            // context before the first checked command
constexpr int64_t kJustBeforeNs = 50 * kMs;         // delay the device may still have
constexpr int64_t kSettleNs = 30 * kMs;             // after a fault, also checked
constexpr int64_t kLatchPatienceNs = 150 * kMs;     // per attempt, until safety has latched a fault
constexpr int64_t kTrustNs = 500 * kMs;        // until the driver trusts an honest device again
constexpr int kLatchAttempts = 5;              // a faulty answer may be overwritten unread
constexpr int64_t kHealthyNs = 10'200 * kMs;   // hapticd's ten seconds plus one look
constexpr int64_t kGoneNs = 2 * kNsPerSecond;  // limit for children to end and firmware to let go
constexpr int64_t kStopNs = 2 * kMs;           // until SIGSTOP has reached every thread
constexpr int kFaultsPerTurn = 20;             // while a body is held, and while it is pressed
constexpr int64_t kEmptyNs = 20 * kMs;         // without a force, after which nothing is held
constexpr int64_t kCalmNs = 600 * kMs;         // in which a body that is still held hangs calm
constexpr size_t kManyClients = 64;
constexpr const char* kStressTime = "2s";  // of stress-ng

constexpr int64_t kReplacedGoal = 50 * kMs;  // from contact's death until its spare answers

void send(pid_t pid, int signal) {
  if (pid > 0) kill(pid, signal);
}

/// Includes the stall time just before: if it is zero, the machine is no excuse.
std::string in_words(Part part, const ForceViolation& v, int64_t begin_ns,
                     std::span<const Stall> stalls) {
  const auto ms = [](int64_t ns) { return 1e-6 * static_cast<double>(ns); };
  char text[224];
  std::snprintf(text, sizeof text,
                "%s: %.4f %s after %.1f ms, %.4f allowed (in the %.0f ms before, the machine stood "
                "still for %.1f ms)",
                std::string(name_of(v.breach)).c_str(), v.force, part == Part::kForce ? "N" : "N·m",
                ms(v.t_ns - begin_ns), v.allowed, ms(kJustBeforeNs),
                ms(held_up(stalls, v.t_ns - kJustBeforeNs, v.t_ns)));
  return text;
}

std::string milliseconds(int64_t ns) {
  return std::to_string(ns / kMs) + " ms";
}

}  // namespace

int64_t FaultInjector::between(int64_t least_ns, int64_t most_ns) {
  return std::uniform_int_distribution<int64_t>(least_ns, most_ns)(random_);
}

int64_t FaultInjector::ready_ns(FaultKind kind) const {
  // hapticd itself kills what hangs, as after a standstill of the machine
  const auto after = [](const WriterSeen& writer) {
    return writer.generation > 1 ? writer.first_ns + kHealthyNs : 0;
  };
  if (kind == FaultKind::kContactKill || kind == FaultKind::kContactHang) {
    return after(session_.contact());
  }
  return kind == FaultKind::kSimKill ? after(session_.sim()) : 0;
}

namespace {

/// The order to the emulator that makes this fault.
EmulatorFault order_of(FaultKind kind) {
  if (kind == FaultKind::kPoseJump) return EmulatorFault::kJumpOnce;
  if (kind == FaultKind::kTurnJump) return EmulatorFault::kTurnJumpOnce;
  if (kind == FaultKind::kDeviceFrozen) return EmulatorFault::kFrozen;
  if (kind == FaultKind::kDeviceOldFirst) return EmulatorFault::kOldFirst;
  if (kind == FaultKind::kDeviceTurnNoise) return EmulatorFault::kTurnNoise;
  return kind == FaultKind::kDeviceDelayed ? EmulatorFault::kDelayed : EmulatorFault::kNoise;
}

/// Orders contact to answer once with NaN or infinity.
void spoil_an_answer(TortureSession& session, FaultKind kind) {
  const bool is_nan = kind == FaultKind::kContactNaN;
  const ContactFault fault = is_nan ? ContactFault::kNaN : ContactFault::kInfinity;
  send_order(session.contact().pid, static_cast<int>(fault));
}

}  // namespace

FaultInjector::Done FaultInjector::inflict(FaultKind kind) {
  switch (kind) {
    case FaultKind::kContactKill:
    case FaultKind::kContactHang:
      return kill_contact(kind == FaultKind::kContactHang);
    case FaultKind::kContactStop:
      return stop_contact();
    case FaultKind::kContactNaN:
    case FaultKind::kContactInfinity:
      return close_by([this, kind] { spoil_an_answer(session_, kind); });
    case FaultKind::kContactTenTimes:
    case FaultKind::kContactThousandTimes:
      return slow_contact(kind);
    case FaultKind::kContactLies:
      return lie_in_contact();
    case FaultKind::kSimKill:
      return kill_sim();
    case FaultKind::kSimStop:
      return stop_sim();
    case FaultKind::kServoKill:
    case FaultKind::kServoStop:
      return fell_servo(kind == FaultKind::kServoKill ? SIGKILL : SIGSTOP);
    case FaultKind::kServoPause:
      return pause_servo();
    case FaultKind::kHapticdKill:
    case FaultKind::kHapticdServoKill:
      return kill_hapticd(kind == FaultKind::kHapticdServoKill);
    case FaultKind::kHapticdStop:
      return stop_hapticd();
    case FaultKind::kRecorderKill:
      return kill_recorder();
    case FaultKind::kRecorderStop:
      return stop_recorder();
    case FaultKind::kClientKill:
    case FaultKind::kClientStop:
      return fell_client(kind == FaultKind::kClientKill ? SIGKILL : SIGSTOP);
    case FaultKind::kManyClients:
      return fell_many_clients();
    case FaultKind::kPoseJump:
    case FaultKind::kTurnJump:
      return close_by([this, kind] {
        send_order(session_.emulator().pid(), static_cast<int>(order_of(kind)));
      });
    case FaultKind::kDeviceSilent:
      return silence_device();
    case FaultKind::kDeviceFrozen:
    case FaultKind::kDeviceOldFirst:
    case FaultKind::kDeviceDelayed:
    case FaultKind::kDeviceNoise:
    case FaultKind::kDeviceTurnNoise:
      return lie(order_of(kind));
    case FaultKind::kMemory:
      return stress({"--vm", "1", "--vm-bytes", "50%"});
    case FaultKind::kBusy:
      break;
  }
  return stress({"--cpu", std::to_string(std::thread::hardware_concurrency())});
}

/// The documented times for a contact's death assume that a spare is ready.
void FaultInjector::wait_for_spare(Done& done) {
  const auto waits = [&] {
    return session_.ask("status").find("\"ready\": true") != std::string::npos;
  };
  if (!session_.wait_until(waits, kPatienceNs)) done.problems.push_back("no spare contact waits");
}

/// Kills contact at once, or stops it until hapticd kills it.
FaultInjector::Done FaultInjector::kill_contact(bool hang) {
  Done done;
  wait_for_spare(done);
  const WriterSeen before = session_.contact();
  send(before.pid, hang ? SIGSTOP : SIGKILL);
  done.begin_ns = now_ns();
  done.recovery_from_ns = done.begin_ns;
  if (hang) {
    session_.wait_until([&] { return !is_running(before.pid); }, kPatienceNs);
    done.recovery_from_ns = now_ns();
  }
  const auto replaced = [&] { return session_.contact().generation > before.generation; };
  if (!session_.wait_until(replaced, kPatienceNs)) {
    done.problems.push_back("contact did not come back");
  }
  done.over_ns = session_.contact().first_ns;
  done.whole_from_ns = done.over_ns;
  const int64_t replaced_ns = done.over_ns - done.recovery_from_ns;
  const int64_t stated_ns = kReplacedGoal + held_up(session_.stalls(done.begin_ns, true),
                                                    done.recovery_from_ns, done.over_ns);
  if (replaced_ns > stated_ns) {
    done.problems.push_back("replaced after " + milliseconds(replaced_ns) + ", " +
                            milliseconds(stated_ns) + " allowed");
  }
  return done;
}

FaultInjector::Done FaultInjector::stop_for(const std::function<void(int)>& send_signal,
                                            int64_t least_ns, int64_t most_ns) {
  Done done;
  send_signal(SIGSTOP);
  done.begin_ns = now_ns();
  session_.pause(between(least_ns, most_ns));
  done.over_ns = now_ns();
  send_signal(SIGCONT);
  done.whole_from_ns = done.recovery_from_ns = done.over_ns;
  return done;
}

/// Short enough that hapticd does not treat contact as hung.
FaultInjector::Done FaultInjector::stop_contact() {
  const pid_t pid = session_.contact().pid;
  return stop_for([pid](int signal) { send(pid, signal); }, 40 * kMs, 200 * kMs);
}

/// Applies a cause that makes safety latch zero force, until the fault is cleared.
FaultInjector::Done FaultInjector::close_by(const std::function<void()>& cause,
                                            const std::function<void()>& cure) {
  Done done;
  // zero force alone may have another cause: hapticd releases the device of a stalled servo
  const auto is_closed = [&] { return session_.servo().fault_ns > done.begin_ns; };
  for (int i = 0; i < kLatchAttempts; ++i) {
    cause();
    done.begin_ns = now_ns();
    if (session_.wait_until(is_closed, kLatchPatienceNs)) break;
  }
  session_.pause(between(20 * kMs, 60 * kMs));
  done.over_ns = done.whole_from_ns = done.recovery_from_ns = now_ns();
  if (cure) cure();
  clear_fault(done);
  return done;
}

/// A device that answers with false data until it is cured.
FaultInjector::Done FaultInjector::lie(EmulatorFault how) {
  const auto order = [this](EmulatorFault what) {
    send_order(session_.emulator().pid(), static_cast<int>(what));
  };
  const auto cure = [&] {
    order(EmulatorFault::kHealthy);
    session_.pause(kTrustNs);
  };
  return close_by([&] { order(how); }, cure);
}

/// Clearing is accepted once the hand is calm: without force, nothing holds it up.
void FaultInjector::clear_fault(Done& done) {
  const int64_t give_up_ns = now_ns() + kPatienceNs;
  for (;;) {
    const std::string answer = session_.ask("clear-fault");
    if (answer == "ok") return;
    if (now_ns() < give_up_ns) continue;
    done.problems.push_back("clear-fault was answered with " + answer);
    return;
  }
}

FaultInjector::Done FaultInjector::slow_contact(FaultKind kind) {
  const bool ten = kind == FaultKind::kContactTenTimes;
  const pid_t pid = session_.contact().pid;
  Done done;
  send_order(pid, static_cast<int>(ten ? ContactFault::kTenTimes : ContactFault::kThousandTimes));
  done.begin_ns = now_ns();
  // until the servo has measured the new period, a set may be older than the hold by a few
  // milliseconds: five of nine intervals
  constexpr int64_t kLearnNs = 150 * kMs;
  if (ten) {
    session_.pause(kLearnNs);
    done.begin_ns += kLearnNs;
  }
  session_.pause(between(200 * kMs, 350 * kMs));
  done.over_ns = done.whole_from_ns = done.recovery_from_ns = now_ns();
  done.recovers = !ten;
  send_order(pid, static_cast<int>(ContactFault::kHealthy));
  return done;
}

FaultInjector::Done FaultInjector::lie_in_contact() {
  const pid_t pid = session_.contact().pid;
  Done done;
  send_order(pid, static_cast<int>(ContactFault::kLies));
  done.begin_ns = now_ns();
  session_.pause(between(100 * kMs, 300 * kMs));
  send_order(pid, static_cast<int>(ContactFault::kHealthy));
  done.over_ns = done.whole_from_ns = done.recovery_from_ns = now_ns();
  return done;
}

FaultInjector::Done FaultInjector::kill_sim() {
  const WriterSeen before = session_.sim();
  Done done;
  send(before.pid, SIGKILL);
  done.begin_ns = now_ns();
  if (!session_.wait_until([&] { return session_.sim().generation > before.generation; },
                           kPatienceNs)) {
    done.problems.push_back("sim did not come back");
  }
  done.over_ns = now_ns();
  done.waited_ns = time_waited(session_.sim().pid);
  done.whole_from_ns = done.recovery_from_ns = done.begin_ns;
  done.recovered_ns = session_.sim().first_ns;
  return done;
}

FaultInjector::Done FaultInjector::stop_sim() {
  const pid_t pid = session_.sim().pid;
  Done done = stop_for([pid](int signal) { send(pid, signal); }, 40 * kMs, 200 * kMs);
  done.recovers = false;
  return done;
}

FaultInjector::Done FaultInjector::fell_servo(int signal) {
  const WriterSeen before = session_.servo();
  Done done;
  send(before.pid, signal);
  done.begin_ns = now_ns();
  done.recovery_from_ns = done.begin_ns;
  if (!session_.wait_until([&] { return session_.servo().generation > before.generation; },
                           kPatienceNs)) {
    done.problems.push_back("the servo did not come back");
  }
  done.waited_ns = time_waited(session_.servo().pid);
  done.over_ns = done.soft_ns = done.whole_from_ns = session_.servo().first_ns;
  return done;
}

/// hapticd releases the device in the meantime, so the force restarts from zero.
FaultInjector::Done FaultInjector::pause_servo() {
  const pid_t pid = session_.servo().pid;
  return stop_for([pid](int signal) { send(pid, signal); }, 20 * kMs, 150 * kMs);
}

bool FaultInjector::has_let_go(int64_t since_ns) const {
  const std::vector<EmulatorRecord>& records = session_.records();
  return std::any_of(records.begin(), records.end(), [&](const EmulatorRecord& r) {
    return r.t_ns > since_ns && r.event == EmulatorEvent::kWatchdog;
  });
}

/// Kills hapticd alone, or together with the servo: hapticd is stopped first, so that it cannot
/// release the device on the servo's death.
FaultInjector::Done FaultInjector::kill_hapticd(bool servo_too) {
  const std::array children{session_.contact().pid, session_.sim().pid, session_.servo().pid};
  if (servo_too) {
    session_.hapticd().send(SIGSTOP);
    session_.pause(kStopNs);
    send(session_.servo().pid, SIGKILL);
  }
  Done done;
  done.begin_ns = session_.kill_hapticd();
  const auto all_gone = [&] {
    return std::none_of(children.begin(), children.end(),
                        [](pid_t pid) { return is_running(pid); });
  };
  if (!session_.wait_until(all_gone, kGoneNs)) {
    done.problems.push_back("a process of the session outlived hapticd by " +
                            milliseconds(kGoneNs));
  }
  // a new servo is ready sooner than that, and its first line would be the zero
  if (servo_too && !session_.wait_until([&] { return has_let_go(done.begin_ns); }, kGoneNs)) {
    done.problems.push_back("the firmware did not switch the motors off within " +
                            milliseconds(kGoneNs));
  }
  done.recovery_from_ns = now_ns();
  session_.restart_hapticd();
  if (!session_.wait_until([&] { return session_.servo().generation > 0; }, kPatienceNs)) {
    done.problems.push_back("the servo did not come back");
  }
  done.over_ns = done.soft_ns = done.whole_from_ns = session_.servo().first_ns;
  return done;
}

FaultInjector::Done FaultInjector::stop_hapticd() {
  Done done =
      stop_for([this](int signal) { session_.hapticd().send(signal); }, 100 * kMs, 400 * kMs);
  done.recovers = false;
  return done;
}

FaultInjector::Done FaultInjector::kill_recorder() {
  if (session_.recorder() == nullptr) return {.left_out = "nothing is recorded"};
  Done done{.begin_ns = now_ns(), .recovers = false};
  session_.kill_recorder();
  session_.pause(between(5 * kMs, 50 * kMs));
  session_.start_recorder();
  // the next recorder must have started before it may be killed
  session_.pause(between(150 * kMs, 300 * kMs));
  done.over_ns = now_ns();
  done.whole_from_ns = done.begin_ns;
  return done;
}

FaultInjector::Done FaultInjector::stop_recorder() {
  if (session_.recorder() == nullptr) return {.left_out = "nothing is recorded"};
  // the rings hold four seconds
  Done done =
      stop_for([this](int signal) { session_.recorder()->send(signal); }, 100 * kMs, 1000 * kMs);
  done.recovers = false;
  return done;
}

FaultInjector::Done FaultInjector::fell_client(int signal) {
  Done done{.begin_ns = now_ns(), .recovers = false};
  SessionProcess client("hapt", {"top", "--json", "-d", "0.02", "--session", session_.name()},
                        "/dev/null");
  session_.pause(between(80 * kMs, 200 * kMs));
  client.send(signal);
  session_.pause(between(50 * kMs, signal == SIGSTOP ? 400 * kMs : 60 * kMs));
  client.kill();
  done.over_ns = now_ns();
  done.whole_from_ns = done.begin_ns;
  return done;
}

FaultInjector::Done FaultInjector::fell_many_clients() {
  Done done{.begin_ns = now_ns(), .recovers = false};
  std::vector<std::unique_ptr<SessionProcess>> clients;
  for (size_t i = 0; i < kManyClients; ++i) {
    clients.push_back(std::make_unique<SessionProcess>(
        "hapt",
        std::vector<std::string>{"top", "--json", "-d", "0.02", "--session", session_.name()},
        "/dev/null"));
    // sleeps: a real-time thread that starts 64 processes without a rest is ended after 2 s
    session_.pause(kMs);
  }
  // by then most are attached, and some die while attaching
  session_.pause(between(300 * kMs, 800 * kMs));
  for (const auto& client : clients) {
    session_.pause(between(0, 10 * kMs));
    client->kill();
  }
  done.over_ns = now_ns();
  done.whole_from_ns = done.begin_ns;
  return done;
}

/// Long enough that the driver's last command is zero (WoodenHaptics::write).
FaultInjector::Done FaultInjector::silence_device() {
  return stop_for([this](int signal) { session_.emulator().send(signal); }, 80 * kMs, 250 * kMs);
}

FaultInjector::Done FaultInjector::stress(const std::vector<std::string>& words) {
  if (find_on_path("stress-ng").empty()) {
    return {.left_out = "stress-ng is not installed: apt-get install stress-ng"};
  }
  Done done{.begin_ns = now_ns(), .recovers = false};
  std::vector<std::string> all = words;
  all.insert(all.end(), {"--timeout", kStressTime, "--temp-path", session_.folder()});
  SessionProcess program("stress-ng", all, session_.folder() + "/said-by-stress-ng");
  session_.wait_until([&] { return program.exit_code().has_value(); }, kPatienceNs);
  if (program.exit_code() != 0) {
    done.problems.push_back("stress-ng failed; what it said is in " + session_.folder());
  }
  done.over_ns = done.whole_from_ns = now_ns();
  return done;
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

void FaultInjector::judge(const FaultInfo& info, const Done& done, FaultOutcome& outcome) {
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

/// Where there are bodies the hand holds one in every other turn, and presses it in between.
void FaultInjector::change_hands(FaultOutcome& outcome) {
  if (!session_.has_bodies() || n_faults_++ % kFaultsPerTurn != 0) return;
  const bool takes = n_faults_ / kFaultsPerTurn % 2 == 0;
  const bool done = takes ? session_.take(kPatienceNs) : session_.let_go(kPatienceNs);
  if (!done) {
    outcome.violations.push_back(takes ? "the block cannot be taken"
                                       : "the block cannot be pressed again");
  }
  judged_ns_ = now_ns();
}

/// A grasp ends with whatever ends a force, and begins only when the button goes down again.
void FaultInjector::take_again(FaultOutcome& outcome) {
  if (!session_.holds()) return;
  const auto recent = session_.records_since(now_ns() - kEmptyNs);
  const bool is_empty = std::ranges::all_of(
      recent, [](const EmulatorRecord& r) { return norm(r.force_B) < ForceRules{}.step; });
  if (!is_empty && session_.wait_calm(kCalmNs)) return;
  if (session_.take(kPatienceNs)) return;
  outcome.violations.push_back("the block cannot be taken again");
}

FaultOutcome FaultInjector::inject(FaultKind kind) {
  FaultOutcome outcome;
  outcome.kind = kind;
  change_hands(outcome);
  session_.pause(kBeforeNs);
  const int64_t from_ns = now_ns();
  if (judged_ns_ != 0) outcome.before = judge_calm(from_ns);
  Done done = inflict(kind);
  done.from_ns = from_ns;
  outcome.begin_ns = done.begin_ns;
  outcome.left_out = done.left_out;
  outcome.violations.insert(outcome.violations.end(), done.problems.begin(), done.problems.end());
  if (!done.left_out.empty()) return outcome;
  const bool may_end_hold = session_.holds() && info_of(kind).effect != Effect::kNothing;
  const auto whole_ns =
      may_end_hold ? std::nullopt : session_.wait_whole(done.whole_from_ns, kPatienceNs);
  if (may_end_hold) {
    session_.pause(kBeforeNs);
  } else if (!whole_ns) {
    outcome.violations.push_back("not whole again within " + milliseconds(kPatienceNs));
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
