// SPDX-License-Identifier: GPL-3.0-or-later
// The functions that inflict the faults, and the table of all faults.
#include <algorithm>
#include <array>
#include <csignal>
#include <functional>
#include <memory>
#include <thread>

#include "clients/lab/torture/fault_kinds.h"
#include "clients/lab/torture/faulty/fault_order.h"
#include "clients/lab/torture/giver_faults.h"
#include "device-io/emulator/fault_order.h"
#include "device-io/woodenhaptics/protocol.h"
#include "proto/ipc/process.h"
#include "proto/math/units.h"
#include "proto/os/programs.h"
#include "proto/os/queued_order.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

// documented times to recovery
constexpr int64_t kRestartGoal = 200 * kMs, kServoGoal = 3000 * kMs;
constexpr int64_t kFoundNs = 100 * kMs;  // documented: time to detect a lying device
// documented: the motors of a wrist turn its encoders so fast that noise is found later
constexpr int64_t kTurnFoundNs = 200 * kMs;
constexpr int64_t kReplacedGoal = 50 * kMs;  // from contact's death until its spare answers

constexpr int64_t kLatchPatienceNs = 150 * kMs;  // per attempt, until safety has latched a fault
constexpr int64_t kTrustNs = 500 * kMs;          // until the driver trusts an honest device again
constexpr int kLatchAttempts = 5;                // a faulty answer may be overwritten unread
constexpr int64_t kGoneNs = 2 * kNsPerSecond;    // limit for children to end and firmware to let go
constexpr int64_t kStopNs = 2 * kMs;             // until SIGSTOP has reached every thread
constexpr size_t kManyClients = 64;              // more than anybody attaches at once
constexpr const char* kStressTime = "2s";        // of stress-ng

using Seen = const WriterSeen& (TortureSession::*)() const;

void send(pid_t pid, int signal) {
  if (pid > 0) kill(pid, signal);
}

void order(pid_t pid, auto what) {
  send_order(pid, static_cast<int>(what));
}

/// The fault is over, and recovery begins.
void end(Inflicted& done) {
  done.over_ns = done.whole_from_ns = done.recovery_from_ns = now_ns();
}

/// Ends a fault during which no command may change.
void end_without_effect(Inflicted& done) {
  done.over_ns = now_ns();
  done.whole_from_ns = done.begin_ns;
}

/// Waits for the next process of this kind.
void wait_for_next(TortureSession& session, Seen seen, uint64_t generation, const char* problem,
                   Inflicted& done) {
  const auto is_back = [&] { return (session.*seen)().generation > generation; };
  if (!session.wait_until(is_back, kFaultPatienceNs)) done.problems.emplace_back(problem);
}

/// The documented times for a contact's death assume that a spare is ready.
void wait_for_spare(TortureSession& session, Inflicted& done) {
  const auto waits = [&] {
    return session.ask("status").find("\"ready\": true") != std::string::npos;
  };
  if (!session.wait_until(waits, kFaultPatienceNs))
    done.problems.emplace_back("no spare contact waits");
}

/// Kills contact at once, or stops it until hapticd kills it.
template <int kSignal>
Inflicted kill_contact(Torturer& t) {
  Inflicted done;
  wait_for_spare(t.session, done);
  const WriterSeen before = t.session.contact();
  send(before.pid, kSignal);
  done.begin_ns = done.recovery_from_ns = now_ns();
  if (kSignal == SIGSTOP) {
    t.session.wait_until([&] { return !is_running(before.pid); }, kFaultPatienceNs);
    done.recovery_from_ns = now_ns();
  }
  wait_for_next(t.session, &TortureSession::contact, before.generation, "contact did not come back",
                done);
  done.over_ns = done.whole_from_ns = t.session.contact().first_ns;
  const int64_t replaced_ns = done.over_ns - done.recovery_from_ns;
  const int64_t stated_ns = kReplacedGoal + held_up(t.session.stalls(done.begin_ns, true),
                                                    done.recovery_from_ns, done.over_ns);
  if (replaced_ns > stated_ns) {
    done.problems.push_back("replaced after " + milliseconds(replaced_ns) + ", " +
                            milliseconds(stated_ns) + " allowed");
  }
  return done;
}

Inflicted stop_for(Torturer& t, const std::function<void(int)>& send_signal, int64_t least_ns,
                   int64_t most_ns) {
  Inflicted done;
  send_signal(SIGSTOP);
  done.begin_ns = now_ns();
  t.session.pause(t.between(least_ns, most_ns));
  end(done);
  send_signal(SIGCONT);
  return done;
}

Inflicted stop_for(Torturer& t, Seen seen, int64_t least_ns, int64_t most_ns) {
  const pid_t pid = (t.session.*seen)().pid;
  return stop_for(
      t, [pid](int signal) { send(pid, signal); }, least_ns, most_ns);
}

Inflicted stop_for(Torturer& t, SessionProcess& process, int64_t least_ns, int64_t most_ns) {
  return stop_for(
      t, [&](int signal) { process.send(signal); }, least_ns, most_ns);
}

/// Nothing of it may be felt.
Inflicted unfelt(Inflicted done) {
  done.recovers = false;
  return done;
}

/// Short enough that hapticd does not treat contact as hung.
Inflicted stop_contact(Torturer& t) {
  return stop_for(t, &TortureSession::contact, 40 * kMs, 200 * kMs);
}

Inflicted stop_sim(Torturer& t) {
  return unfelt(stop_for(t, &TortureSession::sim, 40 * kMs, 200 * kMs));
}

/// hapticd releases the device in the meantime, so the force restarts from zero.
Inflicted pause_servo(Torturer& t) {
  return stop_for(t, &TortureSession::servo, 20 * kMs, 150 * kMs);
}

Inflicted stop_hapticd(Torturer& t) {
  return unfelt(stop_for(t, t.session.hapticd(), 100 * kMs, 400 * kMs));
}

/// Long enough that the driver's last command is zero (WoodenHaptics::write).
Inflicted silence_device(Torturer& t) {
  return stop_for(t, t.session.emulator(), 80 * kMs, 250 * kMs);
}

/// Clearing is accepted once the hand is calm: without force, nothing holds it up.
void clear_fault(TortureSession& session, Inflicted& done) {
  const int64_t give_up_ns = now_ns() + kFaultPatienceNs;
  for (;;) {
    const std::string answer = session.ask("clear-fault");
    if (answer == "ok") return;
    if (now_ns() < give_up_ns) continue;
    done.problems.push_back("clear-fault was answered with " + answer);
    return;
  }
}

/// Applies a cause that makes safety latch zero force, until the fault is cleared.
Inflicted close_by(Torturer& t, const std::function<void()>& cause,
                   const std::function<void()>& cure = {}) {
  Inflicted done;
  // zero force alone may have another cause: hapticd releases the device of a stalled servo
  const auto is_closed = [&] { return t.session.servo().fault_ns > done.begin_ns; };
  for (int i = 0; i < kLatchAttempts; ++i) {
    cause();
    done.begin_ns = now_ns();
    if (t.session.wait_until(is_closed, kLatchPatienceNs)) break;
  }
  t.session.pause(t.between(20 * kMs, 60 * kMs));
  end(done);
  if (cure) cure();
  clear_fault(t.session, done);
  return done;
}

/// Orders contact to answer once with NaN or infinity.
template <ContactFault kFault>
Inflicted spoil_an_answer(Torturer& t) {
  return close_by(t, [&] { order(t.session.contact().pid, kFault); });
}

template <EmulatorFault kFault>
Inflicted jump(Torturer& t) {
  return close_by(t, [&] { order(t.session.emulator().pid(), kFault); });
}

/// A device that answers with false data until it is cured.
template <EmulatorFault kFault>
Inflicted deceive(Torturer& t) {
  const pid_t device = t.session.emulator().pid();
  const auto cure = [&] {
    order(device, EmulatorFault::kHealthy);
    t.session.pause(kTrustNs);
  };
  return close_by(
      t, [&] { order(device, kFault); }, cure);
}

/// A contact that is not healthy for a while, the first `unjudged_ns` of which are not checked.
Inflicted spoil_contact(Torturer& t, ContactFault fault, int64_t unjudged_ns, int64_t least_ns,
                        int64_t most_ns) {
  const pid_t pid = t.session.contact().pid;
  Inflicted done;
  order(pid, fault);
  done.begin_ns = now_ns();
  if (unjudged_ns > 0) t.session.pause(unjudged_ns);
  done.begin_ns += unjudged_ns;
  t.session.pause(t.between(least_ns, most_ns));
  end(done);
  order(pid, ContactFault::kHealthy);
  return done;
}

Inflicted slow_contact_a_little(Torturer& t) {
  // until the servo has measured the new period, a set may be older than the hold by a few
  // milliseconds: five of nine intervals
  constexpr int64_t kLearnNs = 150 * kMs;
  return unfelt(spoil_contact(t, ContactFault::kTenTimes, kLearnNs, 200 * kMs, 350 * kMs));
}

Inflicted slow_contact(Torturer& t) {
  return spoil_contact(t, ContactFault::kThousandTimes, 0, 200 * kMs, 350 * kMs);
}

Inflicted lie_in_contact(Torturer& t) {
  return spoil_contact(t, ContactFault::kLies, 0, 100 * kMs, 300 * kMs);
}

Inflicted kill_sim(Torturer& t) {
  const WriterSeen before = t.session.sim();
  Inflicted done;
  send(before.pid, SIGKILL);
  done.begin_ns = done.whole_from_ns = done.recovery_from_ns = now_ns();
  wait_for_next(t.session, &TortureSession::sim, before.generation, "sim did not come back", done);
  done.over_ns = now_ns();
  done.waited_ns = time_waited(t.session.sim().pid);
  done.recovered_ns = t.session.sim().first_ns;
  return done;
}

/// A new servo, after which forces begin softly.
void wait_for_servo(TortureSession& session, uint64_t generation, Inflicted& done) {
  wait_for_next(session, &TortureSession::servo, generation, "the servo did not come back", done);
  done.over_ns = done.soft_ns = done.whole_from_ns = session.servo().first_ns;
}

template <int kSignal>
Inflicted fell_servo(Torturer& t) {
  const WriterSeen before = t.session.servo();
  Inflicted done;
  send(before.pid, kSignal);
  done.begin_ns = done.recovery_from_ns = now_ns();
  wait_for_servo(t.session, before.generation, done);
  done.waited_ns = time_waited(t.session.servo().pid);
  return done;
}

/// True if the firmware's watchdog has switched the motors off since then.
bool has_let_go(const TortureSession& session, int64_t since_ns) {
  return std::ranges::any_of(session.records(), [&](const EmulatorRecord& r) {
    return r.t_ns > since_ns && r.event == EmulatorEvent::kWatchdog;
  });
}

/// Kills hapticd alone, or together with the servo: hapticd is stopped first, so that it cannot
/// release the device on the servo's death.
template <bool kServoToo>
Inflicted kill_hapticd(Torturer& t) {
  TortureSession& session = t.session;
  const std::array children{session.contact().pid, session.sim().pid, session.servo().pid};
  if (kServoToo) {
    session.hapticd().send(SIGSTOP);
    session.pause(kStopNs);
    send(session.servo().pid, SIGKILL);
  }
  Inflicted done;
  done.begin_ns = session.kill_hapticd();
  const auto all_gone = [&] { return std::ranges::none_of(children, is_running); };
  if (!session.wait_until(all_gone, kGoneNs)) {
    done.problems.push_back("a process of the session outlived hapticd by " +
                            milliseconds(kGoneNs));
  }
  // a new servo is ready sooner than that, and its first line would be the zero
  const auto has_dropped = [&] { return has_let_go(session, done.begin_ns); };
  if (kServoToo && !session.wait_until(has_dropped, kGoneNs)) {
    done.problems.push_back("the firmware did not switch the motors off within " +
                            milliseconds(kGoneNs));
  }
  done.recovery_from_ns = now_ns();
  session.restart_hapticd();
  wait_for_servo(session, 0, done);
  return done;
}

Inflicted kill_recorder(Torturer& t) {
  if (t.session.recorder() == nullptr) return {.left_out = "nothing is recorded"};
  Inflicted done{.begin_ns = now_ns(), .recovers = false};
  t.session.kill_recorder();
  t.session.pause(t.between(5 * kMs, 50 * kMs));
  t.session.start_recorder();
  // the next recorder must have started before it may be killed
  t.session.pause(t.between(150 * kMs, 300 * kMs));
  end_without_effect(done);
  return done;
}

Inflicted stop_recorder(Torturer& t) {
  if (t.session.recorder() == nullptr) return {.left_out = "nothing is recorded"};
  // the rings hold four seconds
  return unfelt(stop_for(t, *t.session.recorder(), 100 * kMs, 1000 * kMs));
}

std::unique_ptr<SessionProcess> start_client(const TortureSession& session) {
  return std::make_unique<SessionProcess>(
      "hapt", std::vector<std::string>{"top", "--json", "-d", "0.02", "--session", session.name()},
      "/dev/null");
}

template <int kSignal>
Inflicted fell_client(Torturer& t) {
  Inflicted done{.begin_ns = now_ns(), .recovers = false};
  const std::unique_ptr<SessionProcess> client = start_client(t.session);
  t.session.pause(t.between(80 * kMs, 200 * kMs));
  client->send(kSignal);
  t.session.pause(t.between(50 * kMs, kSignal == SIGSTOP ? 400 * kMs : 60 * kMs));
  client->kill();
  end_without_effect(done);
  return done;
}

Inflicted fell_many_clients(Torturer& t) {
  Inflicted done{.begin_ns = now_ns(), .recovers = false};
  std::vector<std::unique_ptr<SessionProcess>> clients;
  for (size_t i = 0; i < kManyClients; ++i) {
    clients.push_back(start_client(t.session));
    // sleeps: a real-time thread that starts 64 processes without a rest is ended after 2 s
    t.session.pause(kMs);
  }
  // by then most are attached, and some die while attaching
  t.session.pause(t.between(300 * kMs, 800 * kMs));
  for (const auto& client : clients) {
    t.session.pause(t.between(0, 10 * kMs));
    client->kill();
  }
  end_without_effect(done);
  return done;
}

Inflicted stress(TortureSession& session, std::vector<std::string> words) {
  if (find_on_path("stress-ng").empty()) {
    return {.left_out = "stress-ng is not installed: apt-get install stress-ng"};
  }
  Inflicted done{.begin_ns = now_ns(), .recovers = false};
  words.insert(words.end(), {"--timeout", kStressTime, "--temp-path", session.folder()});
  SessionProcess program("stress-ng", words, session.folder() + "/said-by-stress-ng");
  session.wait_until([&] { return program.exit_code().has_value(); }, kFaultPatienceNs);
  if (program.exit_code() != 0) {
    done.problems.push_back("stress-ng failed; what it said is in " + session.folder());
  }
  done.over_ns = done.whole_from_ns = now_ns();
  return done;
}

Inflicted press_memory(Torturer& t) {
  return stress(t.session, {"--vm", "1", "--vm-bytes", "50%"});
}

Inflicted keep_cores_busy(Torturer& t) {
  return stress(t.session, {"--cpu", std::to_string(std::thread::hardware_concurrency())});
}

const std::array kFaults{
#define FAULT(id, words, portion, felt, does, ...) \
  FaultInfo{.kind = FaultKind::id,                 \
            .name = words,                         \
            .share = portion,                      \
            .effect = Effect::felt,                \
            .inflict = does __VA_OPT__(, ) __VA_ARGS__},
#include "clients/lab/torture/faults.def"
};

}  // namespace

int64_t Torturer::between(int64_t least_ns, int64_t most_ns) {
  return std::uniform_int_distribution<int64_t>(least_ns, most_ns)(random);
}

std::span<const FaultInfo> all_faults() {
  return kFaults;
}

const FaultInfo& info_of(FaultKind kind) {
  return kFaults[static_cast<size_t>(kind)];
}

std::string milliseconds(int64_t ns) {
  return std::to_string(ns / kMs) + " ms";
}

}  // namespace haptic
