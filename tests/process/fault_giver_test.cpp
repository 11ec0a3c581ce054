// SPDX-License-Identifier: GPL-3.0-or-later
// Clients that give and die, hang, lie or write anything into their rings, beside a hand that
// presses something else.
#include <catch2/catch.hpp>
#include <csignal>
#include <random>

#include "clients/lab/torture/giver_faults.h"
#include "tests/process/faulted_session.h"

namespace haptic {
namespace {

using namespace test;

}  // namespace

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
