// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/giver_faults.h"

#include <csignal>

#include "proto/math/units.h"
#include "proto/os/queued_order.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

// documented: a client at 100 Hz is held for three periods and fades within 50 ms; a period may
// have been twice as long where it was started
constexpr int64_t kGivenFadeNs = (2 * 30 + 50) * kMs;

/// State of the others, which does not change while a client misbehaves.
struct Others {
  uint64_t servo, contact, sim;  // generations
  uint64_t refused;              // frames of the honest client
};

Others look_at_others(const TortureSession& session) {
  Others others{session.servo().generation, session.contact().generation, session.sim().generation,
                0};
  for (const GiverState& giver : session.scene()->givers) {
    if (giver.client == kBystander) others.refused = giver.refused;
  }
  return others;
}

void check_others(TortureSession& session, const Others& before, Inflicted& done) {
  session.update();
  const Others now = look_at_others(session);
  const auto check = [&](bool is_as_before, const char* problem) {
    if (!is_as_before) done.problems.emplace_back(problem);
  };
  check(now.servo == before.servo, "the servo was replaced");
  check(now.contact == before.contact, "contact was replaced");
  check(now.sim == before.sim, "sim was replaced");
  check(now.refused <= before.refused, "frames of an honest client were refused");
  const auto is_let_in = [&] { return session.given_object(kBystander)->reduction == 0; };
  check(session.wait_until(is_let_in, kFaultPatienceNs), "what an honest client moves has faded");
}

/// Waits for the end of the fade of what it moves, after since_ns.
void check_fade(TortureSession& session, int64_t since_ns, Inflicted& done) {
  const uint32_t client = session.giver_number();
  const auto is_let_go = [&] { return session.given_object(client)->reduction == 1; };
  const bool fades = session.wait_until(is_let_go, kFaultPatienceNs);
  const int64_t faded_ns = session.scene()->t_ns - since_ns;
  const int64_t stated_ns =
      kGivenFadeNs + held_up(session.stalls_of_starts(since_ns), since_ns - kGivenFadeNs, now_ns());
  if (!fades) {
    done.problems.emplace_back("what it moves does not fade");
  } else if (faded_ns > stated_ns) {
    done.problems.push_back("what it moves faded after " + milliseconds(faded_ns) + ", " +
                            milliseconds(stated_ns) + " allowed");
  }
}

}  // namespace

Inflicted harm_giver(Torturer& t, GivenFade fade,
                     const std::function<void(SessionProcess&)>& fault) {
  TortureSession& session = t.session;
  Inflicted done{.begin_ns = now_ns(), .recovers = false};
  if (!session.start_giver(kFaultPatienceNs)) {
    done.problems.emplace_back("clients that give are not let in");
  } else {
    const Others before = look_at_others(session);
    fault(session.giver());
    if (fade == GivenFade::kFades) check_fade(session, now_ns(), done);
    session.pause(t.between(50 * kMs, 300 * kMs));
    check_others(session, before, done);
  }
  session.giver().kill();
  session.pause(t.between(5 * kMs, 100 * kMs));
  done.over_ns = now_ns();
  done.whole_from_ns = done.begin_ns;
  return done;
}

Inflicted mislead_giver(Torturer& t, GiverFault fault, GivenFade fade) {
  return harm_giver(
      t, fade, [&](SessionProcess& giver) { send_order(giver.pid(), static_cast<int>(fault)); });
}

namespace {

/// The cause is over, and recovery begins.
void end_holder_fault(Inflicted& done) {
  done.over_ns = done.whole_from_ns = done.recovery_from_ns = now_ns();
}

/// It is gone for a while, and another one comes.
Inflicted replace_holder(Torturer& t, Inflicted done) {
  t.session.pause(t.between(150 * kMs, 400 * kMs));
  t.session.holder().kill();
  end_holder_fault(done);
  t.session.start_holder();
  return done;
}

}  // namespace

Inflicted fell_holder(Torturer& t) {
  t.session.holder().send(SIGKILL);
  return replace_holder(t, {.begin_ns = now_ns()});
}

Inflicted spoil_holder(Torturer& t) {
  send_order(t.session.holder().pid(), static_cast<int>(GiverFault::kGarbage));
  return replace_holder(t, {.begin_ns = now_ns()});
}

Inflicted stop_holder(Torturer& t) {
  t.session.holder().send(SIGSTOP);
  Inflicted done{.begin_ns = now_ns()};
  t.session.pause(t.between(100 * kMs, 400 * kMs));
  end_holder_fault(done);
  t.session.holder().send(SIGCONT);
  return done;
}

Inflicted mislead_holder(Torturer& t, GiverFault fault) {
  const pid_t holder = t.session.holder().pid();
  send_order(holder, static_cast<int>(fault));
  Inflicted done{.begin_ns = now_ns()};
  t.session.pause(t.between(150 * kMs, 400 * kMs));
  end_holder_fault(done);
  send_order(holder, static_cast<int>(GiverFault::kHealthy));
  return done;
}

}  // namespace haptic
