// SPDX-License-Identifier: GPL-3.0-or-later
// Forces on the hand when contact or sim dies, hangs, slows down or sends invalid answers.
#include "proto/os/programs.h"
#include "tests/process/faulted_session.h"

namespace haptic {
namespace {

using test::FaultedSession;
using test::programs_are_built;

constexpr int64_t kMs = 1'000'000;

}  // namespace

TEST_CASE("fault: contact is killed, the force is held or fades, and is whole again") {
  if (!programs_are_built()) return;
  FaultedSession s;
  REQUIRE(s.is_pressing());
  const WriterSeen before = s.session.contact();
  const FaultOutcome outcome = s.inject(FaultKind::kContactKill);
  CHECK(s.session.contact().generation > before.generation);
  CHECK_FALSE(is_running(before.pid));
  CHECK(outcome.recovery_ns);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: contact hangs, the force fades to zero, and hapticd replaces it") {
  if (!programs_are_built()) return;
  FaultedSession s;
  const WriterSeen before = s.session.contact();
  const FaultOutcome outcome = s.inject(FaultKind::kContactHang);
  CHECK(s.session.contact().generation > before.generation);
  // at least the shortest hold and the fade, on any machine
  REQUIRE(outcome.zero_after_ns);
  CHECK(*outcome.zero_after_ns >= 50 * kMs);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: contact stands still for a while and goes on, the force comes back by a ramp") {
  if (!programs_are_built()) return;
  FaultedSession s;
  for (int i = 0; i < 3; ++i) s.inject(FaultKind::kContactStop);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: contacts that are not finite close the force until the fault is cleared") {
  if (!programs_are_built()) return;
  FaultedSession s;
  const FaultKind kind = GENERATE(FaultKind::kContactNaN, FaultKind::kContactInfinity);
  const FaultOutcome outcome = s.inject(kind);
  CHECK(outcome.zero_after_ns);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: contacts at a tenth of the rate carry the wall as before") {
  if (!programs_are_built()) return;
  FaultedSession s;
  s.inject(FaultKind::kContactTenTimes);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: contacts a second late are never rendered") {
  if (!programs_are_built()) return;
  FaultedSession s;
  const FaultOutcome outcome = s.inject(FaultKind::kContactThousandTimes);
  CHECK(outcome.zero_after_ns);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: planes that are not there push no faster than slew and hand allow") {
  if (!programs_are_built()) return;
  FaultedSession s;
  s.inject(FaultKind::kContactLies);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: sim is killed or stands still, and the hand does not notice") {
  if (!programs_are_built()) return;
  FaultedSession s;
  const WriterSeen before = s.session.sim();
  CHECK(s.inject(FaultKind::kSimKill).recovery_ns);
  CHECK(s.session.sim().generation > before.generation);
  s.inject(FaultKind::kSimStop);
  CHECK(s.is_pressing());
}

}  // namespace haptic
