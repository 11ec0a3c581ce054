// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "clients/lab/bench/peers/qp.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/selftest/rt_guard.h"
#include "clients/lab/support/dice.h"
#include "proto/config/command_line.h"
#include "proto/math/coulomb.h"
#include "proto/math/lcp.h"
#include "proto/math/qp.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr size_t kChunk = 50;                      // queries of one contestant per turn
constexpr double kGoal20 = 5e-6, kGoal64 = 20e-6;  // p99 of a solve with warm start [s]
constexpr double kRadius = 0.05;                   // of the tool [m]
constexpr double kMass = 0.2;                      // [kg]
constexpr double kPull = 20;          // [1/s]; a hand 5 mm away pulls the tool at 0.1 m/s
constexpr double kFriction = 0.3;     // coefficient of friction
constexpr size_t kSameContacts = 50;  // ticks with the same contacts

struct Options {
  int rounds = 3;
  size_t ticks = 5000;
  size_t exact_ticks = 100;  // CGAL's solver takes milliseconds
};

/// The problem of one tick.
struct Question {
  Twist a_u;  // towards the hand; contacts allow a part of it
  const std::vector<MotionRow>* rows = nullptr;
  const std::vector<FrictionContact>* contacts = nullptr;
};

/// Sets of contacts and a hand that moves against them.
struct Work {
  Mat6 M;
  MotionMetric metric;
  std::vector<std::vector<MotionRow>> rows;
  std::vector<std::vector<FrictionContact>> contacts;
  std::vector<Question> questions;
};

/// Adds `n` contacts on a plane, in a bowl, around a peg or all round, with gaps of up to 50 µm.
void add_contacts(Work& work, size_t n, Dice& dice) {
  const Vec3 axis = dice.direction();
  const size_t arrangement = work.rows.size() % 4;
  std::vector<MotionRow>& rows = work.rows.emplace_back();
  std::vector<FrictionContact>& contacts = work.contacts.emplace_back();
  for (size_t i = 0; i < n; ++i) {
    Vec3 normal = dice.direction(), r = kRadius * dice.uniform(0, 1) * dice.direction();
    if (arrangement == 0) normal = axis, r = r - (dot(r, axis) + 0.3 * kRadius) * axis;
    if (arrangement == 1) normal = normalized(axis + 0.7 * normal);
    if (arrangement == 2) normal = normalized(cross(axis, normal));
    const double gap = i % 2 == 0 ? 0 : dice.uniform(0, 5e-5);
    rows.push_back(contact_row(r, normal, gap, 1e-4));
    contacts.push_back({r, normal, -gap / kTick, kFriction, {}});
  }
}

Twist draw_motion(double size, Dice& dice) {
  return {size * dice.direction(), size / kRadius * dice.uniform(0, 1) * dice.direction()};
}

/// `coherent`: the contacts stay for fifty ticks while the hand, 5 mm behind them, moves at
/// 0.1 m/s; otherwise every tick has new contacts.
Work make_work(size_t n, size_t ticks, bool coherent) {
  Dice dice(n + (coherent ? 1000 : 0));
  Work work;
  const double inertia = 0.4 * kMass * kRadius * kRadius;
  work.M = mass_matrix(kMass, {{{inertia, 0, 0}, {0, 0.7 * inertia, 0}, {0, 0, 0.5 * inertia}}});
  work.metric = factor_metric(work.M);
  const size_t sets = coherent ? (ticks + kSameContacts - 1) / kSameContacts : ticks;
  for (size_t k = 0; k < sets; ++k) add_contacts(work, n, dice);
  Twist hand, drift;
  for (size_t tick = 0; tick < ticks; ++tick) {
    const size_t set = coherent ? tick / kSameContacts : tick;
    if (!coherent || tick % kSameContacts == 0) {
      hand = draw_motion(5e-3, dice), drift = draw_motion(1e-4, dice);
    }
    hand = hand + drift;
    work.questions.push_back({hand, &work.rows[set], &work.contacts[set]});
  }
  return work;
}

/// A solver with its own memory.
struct Solver {
  std::string name;
  std::function<bool(const Question&)> converges;
  size_t failed = 0;  // number of questions
};

/// Solves from scratch, from the last active set (which is only a guess for other contacts), by
/// pivoting, by at most two hundred sweeps (as a fallback would), and with friction.
std::vector<Solver> solvers_of(const Work& work, size_t n) {
  const MotionMetric& metric = work.metric;
  const auto by = [&](LcpMethod method) {
    return [&metric, method, own = std::make_shared<LcpSolver>(n)](const Question& q) {
      return own->step(method, metric, q.a_u, *q.rows).converged;
    };
  };
  const auto cold = [&metric](const Question& q) {
    return least_constraint(metric, q.a_u, *q.rows).converged;
  };
  const auto warm = [&metric, last = ConstrainedMotion{}](const Question& q) mutable {
    last = least_constraint(metric, q.a_u, *q.rows,
                            {last.active.data(), static_cast<size_t>(last.n_active)});
    return last.converged;
  };
  const auto coulomb = [&metric, own = std::make_shared<CoulombSolver>(n)](const Question& q) {
    return own->step(metric, kPull * q.a_u, *q.contacts).converged;
  };
  return {{"cold", cold},
          {"warm", warm},
          {"pivoting", by(LcpMethod::kPivoting)},
          {"Gauss-Seidel", by(LcpMethod::kGaussSeidel)},
          {"Coulomb", coulomb}};
}

/// The solvers as contestants, which count the questions on which they fail.
std::vector<Contestant> contestants_of(std::span<Solver> solvers, const Work& work) {
  std::vector<Contestant> contestants;
  for (Solver& solver : solvers) {
    contestants.push_back(
        {solver.name, [&](size_t i) { solver.failed += !solver.converges(work.questions[i]); }});
  }
  return contestants;
}

/// Compared with Bullet's pivoting; both get A and b ready-made.
void bench_dantzig(Rows& rows, const Work& work, size_t n, const Options& options) {
  const DantzigPeer bullet = make_bullet_dantzig();
  if (!bullet) return rows.note("Bullet's Dantzig", kLeftOut);
  struct Lcp {
    std::vector<double> A, b;
  };
  const size_t ticks = std::min<size_t>(options.ticks, 1000);
  std::vector<Lcp> lcps(ticks);
  for (size_t k = 0; k < ticks; ++k) {
    const Question& q = work.questions[k];
    Lcp& lcp = lcps[k];
    for (const MotionRow& i : *q.rows) {
      for (const MotionRow& j : *q.rows) {
        lcp.A.push_back(dot(i.J, response(work.metric, {j.J.v, j.J.w})));
      }
      lcp.b.push_back(dot(i.J, q.a_u) - i.b);
    }
  }
  LcpSolver own(n);
  std::vector<double> f;
  double failed = 0;
  std::vector<Contestant> contestants{
      {"pivoting on a ready matrix",
       [&](size_t i) { own.solve(LcpMethod::kPivoting, lcps[i].A, lcps[i].b); }},
      {"Bullet's Dantzig", [&](size_t i) { failed += !bullet(lcps[i].A, lcps[i].b, f); }}};
  take_turns(contestants, ticks, kChunk, options.rounds);
  add_beside(rows, contestants[0].name, contestants[0].times, contestants[1].name,
             contestants[1].times);
  rows.add("Bullet's Dantzig says it failed", failed);
}

void bench_cgal(Rows& rows, const Work& work, const Options& options) {
  const size_t ticks = std::min(options.exact_ticks, work.questions.size());
  ConstrainedMotion cold;
  Twist exact;
  const auto solve = [&](size_t i) {
    cold = least_constraint(work.metric, work.questions[i].a_u, *work.questions[i].rows);
  };
  const auto solve_exactly = [&](size_t i) {
    exact = cgal_least_constraint(work.M, work.questions[i].a_u, *work.questions[i].rows);
  };
  std::vector<Contestant> contestants{{"cold", solve}, {"CGAL, exact", solve_exactly}};
  take_turns(contestants, ticks, std::max<size_t>(1, ticks / 10), 1);
  rows.add_beside("cold, CGAL's questions, p50", percentile(contestants[0].times, 50), "s",
                  contestants[1].name, percentile(contestants[1].times, 50));
  double different = 0;
  for (size_t i = 0; i < ticks; ++i) {
    solve(i);
    solve_exactly(i);
    const Twist d = cold.a - exact, a_u = work.questions[i].a_u;
    different = std::max(different, std::sqrt(dot(work.M * d, d) / dot(work.M * a_u, a_u)));
  }
  rows.add("farthest from CGAL's answer, of the motion", different, "", at_most(1e-9));
}

void bench_contacts(size_t n, bool coherent, const Options& options, const Rows& all) {
  Rows rows = all.of((coherent ? "the same contacts, " : "new contacts, ") + std::to_string(n));
  const Work work = make_work(n, options.ticks, coherent);
  std::vector<Solver> solvers = solvers_of(work, n);
  const std::span<Solver> fast = std::span(solvers).first(3), slow = std::span(solvers).last(2);
  std::vector<Contestant> contestants = contestants_of(fast, work);
  take_turns(contestants, options.ticks, kChunk, options.rounds);
  // the goal is for the servo's case: contacts that persist, with warm start
  const bool has_goal = coherent && (n == 20 || n == 64);
  for (const Contestant& c : contestants) {
    add_times(rows, c.name, c.times,
              goal_if(has_goal && c.name == "warm", n == 20 ? kGoal20 : kGoal64));
  }
  const auto share = [](const Solver& solver, const Contestant& asked) {
    return static_cast<double>(solver.failed) / static_cast<double>(asked.times.size());
  };
  rows.add({{"not converged", fast[0].failed + fast[1].failed, "", kMustBeZero},
            {"pivoting not converged", share(fast[2], contestants[2])}});
  if (!coherent) return;

  const size_t fewer = std::min<size_t>(options.ticks, 500);
  std::vector<Contestant> slower = contestants_of(slow, work);
  take_turns(slower, fewer, kChunk, options.rounds);
  for (const Contestant& c : slower) add_times(rows, c.name, c.times);
  rows.add({{"Gauss-Seidel not settled in 200 sweeps", share(slow[0], slower[0])},
            {"Coulomb not converged", share(slow[1], slower[1])}});
  bench_dantzig(rows, work, n, options);
  bench_cgal(rows, work, options);
  rows.add("allocations", allocations_of([&] {
             for (size_t i = 0; i < fewer; ++i) {
               for (const Solver& solver : solvers) solver.converges(work.questions[i]);
             }
           }),
           "", kMustBeZero);
}

void all_rows(const Options& options, const Rows& all) {
  all.machine("qp");
  for (const size_t n : {1, 4, 5, 20, 64}) {
    for (const bool coherent : {false, true}) bench_contacts(n, coherent, options, all);
  }
}

}  // namespace

/// Times of the solvers in proto/math for one body at 1 to 64 contacts, compared with CGAL's exact
/// quadratic program and Bullet's Dantzig pivoting.
Measured bench_qp(Command& command) {
  const auto options = std::make_shared<Options>();
  add_counts(command,
             {{"--ticks", &options->ticks, "questions of each kind", 100, 1000000},
              {"--exact-ticks", &options->exact_ticks, "of them, also asked of CGAL", 1, 100000},
              rounds_of(options->rounds, "times each question is asked")});
  return measured(all_rows, options);
}

}  // namespace haptic
