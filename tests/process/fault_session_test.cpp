// SPDX-License-Identifier: GPL-3.0-or-later
// Forces on the hand when a process of the session or a watching client dies or hangs: what needs
// real processes. What a single step has to do is in tests/servo/safety/faults_test.cpp.
#include <sched.h>

#include <atomic>
#include <thread>
#include <vector>

#include "clients/lab/torture/account.h"
#include "clients/lab/torture/giver_faults.h"
#include "proto/os/programs.h"
#include "tests/process/faulted_session.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using test::FaultedSession;

/// Number of clients reported by hapticd.
std::string clients_of(const FaultedSession& s) {
  const std::string status = s.session.ask("status"), key = "\"clients\": ";
  const size_t at = status.find(key) + key.size();
  return status.substr(at, status.find(',', at) - at);
}

bool is_realtime(pid_t pid) {
  return (sched_getscheduler(pid) & ~SCHED_RESET_ON_FORK) == SCHED_FIFO;
}

/// A load of four busy threads of normal priority per processor.
class BusyProcessors {
 public:
  BusyProcessors() {
    for (unsigned i = 0; i < 4 * std::thread::hardware_concurrency(); ++i) {
      threads_.emplace_back([this] {
        while (!ending_.load(std::memory_order_relaxed)) {
        }
      });
    }
  }
  ~BusyProcessors() {
    ending_ = true;
    for (std::thread& thread : threads_) thread.join();
  }
  BusyProcessors(const BusyProcessors&) = delete;

 private:
  std::atomic<bool> ending_{false};
  std::vector<std::thread> threads_;
};

}  // namespace

TEST_CASE("fault: contact and sim are killed or stand still, and the force is whole again") {
  FaultedSession s;
  REQUIRE(s.is_pressing());
  const WriterSeen contact = s.session.contact(), sim = s.session.sim();
  CHECK(s.inject(FaultKind::kContactKill).recovery_ns);
  CHECK(s.session.contact().generation > contact.generation);
  CHECK_FALSE(is_running(contact.pid));
  CHECK(s.is_pressing());
  // the force comes back by a ramp
  for (int i = 0; i < 3; ++i) s.inject(FaultKind::kContactStop);
  CHECK(s.is_pressing());
  // what contact answers reaches the servo, and clear-fault too
  for (const FaultKind kind : {FaultKind::kContactNaN, FaultKind::kContactInfinity}) {
    CHECK(s.inject(kind).zero_after_ns);
    CHECK(s.is_pressing());
  }
  // at a tenth of the rate it carries the wall as before, a second late it is never rendered
  s.inject(FaultKind::kContactTenTimes);
  CHECK(s.is_pressing());
  CHECK(s.inject(FaultKind::kContactThousandTimes).zero_after_ns);
  CHECK(s.is_pressing());
  CHECK(s.inject(FaultKind::kSimKill).recovery_ns);
  CHECK(s.session.sim().generation > sim.generation);
  s.inject(FaultKind::kSimStop);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: contact hangs, the force fades to zero, and hapticd replaces it") {
  FaultedSession s;
  const WriterSeen before = s.session.contact();
  const FaultOutcome outcome = s.inject(FaultKind::kContactHang);
  CHECK(s.session.contact().generation > before.generation);
  // at least the shortest hold and the fade, on any machine
  REQUIRE(outcome.zero_after_ns);
  CHECK(*outcome.zero_after_ns >= 50'000'000);
  CHECK(s.is_pressing());
}

TEST_CASE(
    "fault: the servo stands still, is killed or hangs, zero within 20 ms, whole within 3 s") {
  FaultedSession s;
  REQUIRE(s.is_pressing());
  for (int i = 0; i < 3; ++i) s.inject(FaultKind::kServoPause);
  for (const FaultKind kind : {FaultKind::kServoKill, FaultKind::kServoStop}) {
    REQUIRE(s.is_pressing());
    const WriterSeen before = s.session.servo();
    const FaultOutcome outcome = s.inject(kind);
    CHECK(s.session.servo().generation > before.generation);
    CHECK(outcome.zero_after_ns);
  }
  CHECK(s.is_pressing());
}

TEST_CASE("fault: hapticd stands still and is killed, zero, and nothing of the session is left") {
  FaultedSession s;
  // while it stands still the hand does not notice
  s.inject(FaultKind::kHapticdStop);
  CHECK(s.is_pressing());
  const std::array children{s.session.contact().pid, s.session.sim().pid, s.session.servo().pid};
  CHECK(s.inject(FaultKind::kHapticdKill).zero_after_ns);
  for (const pid_t pid : children) CHECK_FALSE(is_running(pid));
  // the next hapticd found no stale lock, socket or device
  CHECK(s.is_pressing());
  // with the servo at once: the firmware lets go, no other process, and not later than it says
  const FaultOutcome both = s.inject(FaultKind::kHapticdServoKill);
  REQUIRE(both.zero_after_ns);
  CHECK(*both.zero_after_ns > 50'000'000);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: every processor is busy, and neither a zero nor a new contact waits for one") {
  FaultedSession s;
  if (!is_realtime(s.session.servo().pid)) {
    WARN("no right to real-time priority here: what is stated for it is not shown");
    return;
  }
  const BusyProcessors busy;
  s.inject(FaultKind::kContactKill);
  s.inject(FaultKind::kHapticdKill);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: recorders die and stand still, the hand notices nothing and no sample is lost") {
  FaultedSession s(true);
  s.session.pause(kNsPerSecond / 2);
  s.inject(FaultKind::kRecorderStop);
  s.inject(FaultKind::kRecorderKill);
  // the recorder survived: all that contact and sim had published is in the log
  s.inject(FaultKind::kContactKill);
  s.session.pause(kNsPerSecond / 2);
  CHECK(s.is_pressing());
  s.session.stop();
  const SampleAccount account = account_for_samples(s.session.parts(), s.session.published());
  REQUIRE(account.unreadable.empty());
  CHECK(s.session.parts().size() >= 2);
  CHECK(s.session.unseen() == 0);
  CHECK(account.unexplained == 0);
  CHECK(account.told == 0);
  CHECK(account.recorded + account.explained == account.published);
  // what passes while a recorder starts is explained; sanitizers make that longer
  CHECK(account.recorded > account.published / (test::kSlowdown > 1 ? 4 : 2));
}

TEST_CASE("fault: watching clients die and stand still, 64 attach, and the hand does not notice") {
  FaultedSession s;
  s.inject(FaultKind::kClientKill);
  s.inject(FaultKind::kClientStop);
  const std::string before = clients_of(s);
  s.inject(FaultKind::kManyClients);
  CHECK(s.is_pressing());
  // hapticd has dropped them all
  CHECK(s.session.wait_until([&] { return clients_of(s) == before; }, test::kPatienceNs));
}

TEST_CASE("fault: clients that give die, hang and lie, and neither hand nor others notice") {
  FaultedSession s;
  for (const FaultInfo& info : all_faults()) {
    if (info.kind < FaultKind::kGiverKill || info.kind > FaultKind::kGiverGarbage) continue;
    CAPTURE(info.name);
    s.inject(info.kind);
    CHECK(s.is_pressing());
  }
}

TEST_CASE("fault: a sim that dies while a client misbehaves is no harmless client") {
  FaultedSession s;
  Torturer torturer{s.session, std::mt19937_64(1)};
  const Inflicted done = harm_giver(torturer, GivenFade::kMayFade, [&](SessionProcess&) {
    ::kill(s.session.sim().pid, SIGKILL);
    s.session.pause(kNsPerSecond / 2);
  });
  REQUIRE(done.problems.size() == 1);
  CHECK(done.problems[0] == "sim was replaced");
}

}  // namespace haptic
