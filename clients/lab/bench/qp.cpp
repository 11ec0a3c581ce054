// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "clients/lab/bench/peers/qp.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/selftest/rt_guard.h"
#include "clients/lab/support/dice.h"
#include "clients/lab/support/lab_rows.h"
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

class Maker {
 public:
  explicit Maker(uint64_t seed) : dice_(seed) {}

  /// `n` contacts on a plane, in a bowl, around a peg or all round, with gaps of up to 50 µm.
  void add_contacts(Work& work, size_t n) {
    const Vec3 axis = direction();
    const size_t arrangement = work.rows.size() % 4;
    std::vector<MotionRow> rows;
    std::vector<FrictionContact> contacts;
    for (size_t i = 0; i < n; ++i) {
      Vec3 normal = direction(), r = kRadius * uniform(0, 1) * direction();
      if (arrangement == 0) normal = axis, r = r - (dot(r, axis) + 0.3 * kRadius) * axis;
      if (arrangement == 1) normal = normalized(axis + 0.7 * normal);
      if (arrangement == 2) normal = normalized(cross(axis, normal));
      const double gap = i % 2 == 0 ? 0 : uniform(0, 5e-5);
      rows.push_back(contact_row(r, normal, gap, 1e-4));
      contacts.push_back({r, normal, -gap / kTick, kFriction, {}});
    }
    work.rows.push_back(std::move(rows));
    work.contacts.push_back(std::move(contacts));
  }

  Twist motion(double size) {
    return {size * direction(), size / kRadius * uniform(0, 1) * direction()};
  }

 private:
  Vec3 direction() { return dice_.direction(); }
  double uniform(double low, double high) { return dice_.uniform(low, high); }

  Dice dice_;
};

/// `coherent`: the contacts stay for fifty ticks while the hand, 5 mm behind them, moves at
/// 0.1 m/s; otherwise every tick has new contacts.
Work make_work(size_t n, size_t ticks, bool coherent) {
  Maker make(n + (coherent ? 1000 : 0));
  Work work;
  const double inertia = 0.4 * kMass * kRadius * kRadius;
  work.M = mass_matrix(kMass, {{{inertia, 0, 0}, {0, 0.7 * inertia, 0}, {0, 0, 0.5 * inertia}}});
  work.metric = factor_metric(work.M);
  const size_t sets = coherent ? (ticks + kSameContacts - 1) / kSameContacts : ticks;
  for (size_t k = 0; k < sets; ++k) make.add_contacts(work, n);
  Twist hand, drift;
  for (size_t tick = 0; tick < ticks; ++tick) {
    const size_t set = coherent ? tick / kSameContacts : tick;
    if (!coherent || tick % kSameContacts == 0) hand = make.motion(5e-3), drift = make.motion(1e-4);
    hand = hand + drift;
    work.questions.push_back({hand, &work.rows[set], &work.contacts[set]});
  }
  return work;
}

/// All solvers for the problem of a tick, each with its own memory.
class Solvers {
 public:
  explicit Solvers(const Work& work, size_t n)
      : work_(work), pivoting_(n), seidel_(n), coulomb_(n) {}

  void cold(size_t i) {
    const Question& q = work_.questions[i];
    motion = least_constraint(work_.metric, q.a_u, *q.rows);
    failed += !motion.converged;
  }
  /// Warm start from the last active set, which is only a guess for other contacts.
  void warm(size_t i) {
    const Question& q = work_.questions[i];
    warm_ = least_constraint(work_.metric, q.a_u, *q.rows,
                             {warm_.active.data(), static_cast<size_t>(warm_.n_active)});
    failed += !warm_.converged;
  }
  void pivoting(size_t i) {
    const Question& q = work_.questions[i];
    unpivoted += !pivoting_.step(LcpMethod::kPivoting, work_.metric, q.a_u, *q.rows).converged;
  }
  /// At most two hundred sweeps, as a fallback would use.
  void seidel(size_t i) {
    const Question& q = work_.questions[i];
    unsettled += !seidel_.step(LcpMethod::kGaussSeidel, work_.metric, q.a_u, *q.rows).converged;
  }
  void coulomb(size_t i) {
    const Question& q = work_.questions[i];
    const FrictionStep out = coulomb_.step(work_.metric, kPull * q.a_u, *q.contacts);
    unsettled_friction += !out.converged;
  }

  ConstrainedMotion motion;
  size_t failed = 0, unpivoted = 0, unsettled = 0, unsettled_friction = 0;

 private:
  const Work& work_;
  ConstrainedMotion warm_;
  LcpSolver pivoting_, seidel_;
  CoulombSolver coulomb_;
};

uint64_t allocations(Solvers& solvers, size_t ticks) {
  return allocations_of([&] {
    for (size_t i = 0; i < ticks; ++i) {
      solvers.cold(i), solvers.warm(i), solvers.pivoting(i), solvers.seidel(i), solvers.coulomb(i);
    }
  });
}

/// Compared with Bullet's pivoting; both get A and b ready-made.
void bench_dantzig(Rows& rows, const Work& work, size_t n, const Options& options) {
  const std::unique_ptr<DantzigPeer> bullet = make_bullet_dantzig();
  if (!bullet) {
    rows.note("Bullet's Dantzig", kLeftOut);
    return;
  }
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
      {"Bullet's Dantzig", [&](size_t i) { failed += !bullet->solve(lcps[i].A, lcps[i].b, f); }}};
  take_turns(contestants, ticks, kChunk, options.rounds);
  for (const double q : {50.0, 99.0}) {
    rows.add_beside(contestants[0].name + (q < 60 ? " p50" : " p99"),
                    percentile(contestants[0].times, q), "s", contestants[1].name,
                    percentile(contestants[1].times, q));
  }
  rows.add("Bullet's Dantzig says it failed", failed);
}

void bench_cgal(Rows& rows, const Work& work, Solvers& solvers, const Options& options) {
  const size_t ticks = std::min(options.exact_ticks, work.questions.size());
  double different = 0;
  Twist exact;
  std::vector<Contestant> contestants{{"cold", [&](size_t i) { solvers.cold(i); }},
                                      {"CGAL, exact", [&](size_t i) {
                                         const Question& q = work.questions[i];
                                         exact = cgal_least_constraint(work.M, q.a_u, *q.rows);
                                       }}};
  take_turns(contestants, ticks, std::max<size_t>(1, ticks / 10), 1);
  rows.add_beside("cold, CGAL's questions, p50", percentile(contestants[0].times, 50), "s",
                  contestants[1].name, percentile(contestants[1].times, 50));
  for (size_t i = 0; i < ticks; ++i) {
    const Question& q = work.questions[i];
    solvers.cold(i);
    exact = cgal_least_constraint(work.M, q.a_u, *q.rows);
    const Twist d = solvers.motion.a - exact;
    different = std::max(different, std::sqrt(dot(work.M * d, d) / dot(work.M * q.a_u, q.a_u)));
  }
  rows.add("farthest from CGAL's answer, of the motion", different, "", at_most(1e-9));
}

std::vector<Row> bench_contacts(size_t n, bool coherent, const Options& options) {
  Rows rows((coherent ? "the same contacts, " : "new contacts, ") + std::to_string(n));
  const Work work = make_work(n, options.ticks, coherent);
  Solvers solvers(work, n);
  std::vector<Contestant> contestants{{"cold", [&](size_t i) { solvers.cold(i); }},
                                      {"warm", [&](size_t i) { solvers.warm(i); }},
                                      {"pivoting", [&](size_t i) { solvers.pivoting(i); }}};
  take_turns(contestants, options.ticks, kChunk, options.rounds);
  // the goal is for the servo's case: contacts that persist, with warm start
  const bool has_goal = coherent && (n == 20 || n == 64);
  add_times(rows, contestants[0].name, contestants[0].times);
  add_times(rows, contestants[1].name, contestants[1].times,
            goal_if(has_goal, n == 20 ? kGoal20 : kGoal64));
  add_times(rows, contestants[2].name, contestants[2].times);
  rows.add({{"not converged", solvers.failed, "", kMustBeZero},
            {"pivoting not converged", static_cast<double>(solvers.unpivoted) /
                                           static_cast<double>(contestants[2].times.size())}});
  if (!coherent) return rows.rows();

  const size_t fewer = std::min<size_t>(options.ticks, 500);
  std::vector<Contestant> slower{{"Gauss-Seidel", [&](size_t i) { solvers.seidel(i); }},
                                 {"Coulomb", [&](size_t i) { solvers.coulomb(i); }}};
  take_turns(slower, fewer, kChunk, options.rounds);
  for (const Contestant& c : slower) add_times(rows, c.name, c.times);
  const double asked = static_cast<double>(slower[0].times.size());
  rows.add(
      {{"Gauss-Seidel not settled in 200 sweeps", static_cast<double>(solvers.unsettled) / asked},
       {"Coulomb not converged", static_cast<double>(solvers.unsettled_friction) / asked}});
  bench_dantzig(rows, work, n, options);
  bench_cgal(rows, work, solvers, options);
  rows.add("allocations", allocations(solvers, fewer), "", kMustBeZero);
  return rows.rows();
}

std::vector<Row> all_rows(const Options& options) {
  Rows rows = machine_rows("qp");
  for (const size_t n : {1, 4, 5, 20, 64}) {
    for (const bool coherent : {false, true}) rows.append(bench_contacts(n, coherent, options));
  }
  return rows.rows();
}

}  // namespace

/// Times of the solvers in proto/math for one body at 1 to 64 contacts, compared with CGAL's exact
/// quadratic program and Bullet's Dantzig pivoting.
Measured bench_qp(Command& command) {
  const auto options = std::make_shared<Options>();
  command.option("--ticks", options->ticks, "questions of each kind")
      .range(100, 1000000)
      .show_default();
  command.option("--exact-ticks", options->exact_ticks, "of them, also asked of CGAL")
      .range(1, 100000)
      .show_default();
  add_rounds(command, options->rounds, "times each question is asked");
  return [options] { return all_rows(*options); };
}

}  // namespace haptic
