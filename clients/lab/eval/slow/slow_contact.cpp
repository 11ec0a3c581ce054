// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/slow/slow_contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "clients/lab/support/measurement.h"
#include "clients/lab/support/scripted_hand.h"
#include "clients/lab/support/spectrum.h"
#include "clients/lockstep/lockstep.h"
#include "proto/math/units.h"
#include "proto/os/progress.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kObjectRadius = 50 * kMm,
                 kToolRadius = 8 * kMm;           // [m], balls whose contact is known
constexpr double kDepth = 0.5 * kMm;              // [m], of the hand in the ball
constexpr double kSpeed = 0.1, kEdgeSpeed = 0.5;  // of the hand [m/s]
constexpr double kPressTime = 0.2;                // in which it reaches the depth [s]
constexpr double kRoughAbove = 50;                // [Hz]
constexpr double kMostRough = 0.02;               // [N]; root mean square
constexpr double kBlockHalf = 20 * kMm, kBlockHeight = 20 * kMm;  // [m]
constexpr double kPast = 1 * kMm;   // two ticks of the hand: an answer is seen one tick late, and
                                    // a plane is eased by where the proxy was a tick ago
constexpr double kTorqueLimit = 1;  // of the device, which holds the torque that it is told [N·m]

/// The proxy may move half the band of the field while it waits for contact (max_travel): enough to
/// follow a hand of this speed with contacts at 50 Hz, which are 21 ticks old at most.
double least_band(double speed) {
  constexpr double kMostAge = 21 * kTick, kReserve = 1.3;
  return 2 * kReserve * kMostAge * speed;
}

/// From just above the surface to the depth, smoothly [m].
double pressed(double t) {
  const double share = std::clamp(t / kPressTime, 0.0, 1.0);
  return kDepth * (1 - 2 * std::cos(0.5 * std::numbers::pi * share));
}

}  // namespace

const std::vector<JudgedRenderer>& slow_renderers() {
  static const std::vector<JudgedRenderer> kAll{
      {"voxel", Renderer::kVoxel, SoftSolver::kQuasiStatic, true, true, false},
      {"voxel, penalty dynamics", Renderer::kVoxel, SoftSolver::kPenaltyDynamics, true, true, true},
      {"direct6", Renderer::kDirect6, SoftSolver::kDirect, true, false, false},
      {"localized", Renderer::kLocalized, SoftSolver::kDirect, true, false, false},
      {"sensation", Renderer::kSensation, SoftSolver::kPenaltyDynamics, true, true, true},
      {"god-object6", Renderer::kGodObject6, std::nullopt, true, true, false},
      {"constrained6", Renderer::kConstrained6, std::nullopt, true, false, true}};
  return kAll;
}

SlowScene ball_over_ball(uint32_t fineness) {
  SlowScene slow{make_free_scene("ball over ball", {make_icosphere(kObjectRadius, fineness)},
                                 make_icosphere(kToolRadius, fineness - 1),
                                 {kMm, 0, least_band(kSpeed)})};
  slow.hand = {
      "slides", [](double t) {
        // askew to the meshes, so that the way follows no edges
        const double angle = kSpeed / kObjectRadius * std::max(t - kPressTime, 0.0) - 0.6;
        const double height = kObjectRadius + kToolRadius - pressed(t);
        const Vec3 u = normalized(Vec3{0.3, 0.2, 1}), v = normalized(cross(u, {0, 1, 0.3}));
        return Pose{height * (std::cos(angle) * u + std::sin(angle) * v), {}};
      }};
  slow.first = 300;
  slow.ticks = 812;  // 512 are judged
  return slow;
}

SlowScene off_an_edge(bool with_box) {
  const double half = 3 * kMm;
  SlowScene slow{
      make_free_scene(with_box ? "box off an edge" : "ball off an edge",
                      {make_box({2 * kBlockHalf, 4 * kBlockHalf, kBlockHeight})},
                      with_box ? make_box({2 * half, 2 * half, 2 * half}) : make_icosphere(half, 3),
                      {kMm, 0, least_band(kEdgeSpeed)})};
  slow.hand = {"slides off", [half](double t) {
                 const double x = kEdgeSpeed * std::max(t - kPressTime - 0.02, 0.0);
                 return Pose{{x, 0, 0.5 * kBlockHeight + half - pressed(t)}, {}};
               }};
  slow.ticks = 320;
  // a ball touches the edge until its centre is this far past it
  const double beside = with_box ? half : std::sqrt(half * half - std::pow(half - kDepth, 2));
  slow.leaves = kBlockHalf + beside;
  return slow;
}

SlowRun run_slowly(const SlowScene& scene, const JudgedRenderer& renderer, uint32_t period,
                   uint32_t late) {
  // the phase of contact against the hand
  const double ahead = kTick * late;
  ScriptedHand hand([&](double t) { return scene.hand.path(std::max(t - ahead, 0.0)); },
                    kTorqueLimit);
  Lockstep session(renderer.in(scene.scene.config), scene.scene.shapes, hand, {period, 1});
  SlowRun run;
  for (uint64_t k = 0; k < scene.ticks + late && session.step(); ++k) {
    if (k < late) continue;
    const ServoFrame& frame = session.frame();
    run.force_W.push_back(frame.F_coupling_W.f);
    run.is_felt.push_back(renderer.has_mass ? frame.n_contacts > 0
                                            : !(frame.F_coupling_W == Wrench{}));
    run.x.push_back(renderer.has_mass ? frame.X_WP.p.x : frame.X_WT.p.x);
  }
  return run;
}

Slowness compare_runs(const SlowScene& scene, const SlowRun& fresh, const SlowRun& slow) {
  Slowness found;
  std::vector<Vec3> judged;
  for (size_t k = scene.first; k < scene.ticks; ++k) {
    found.error += norm_squared(slow.force_W[k] - fresh.force_W[k]);
    found.mean += norm(slow.force_W[k]);
    found.most = std::max(found.most, norm(slow.force_W[k]));
    judged.push_back(slow.force_W[k]);
  }
  const auto n = static_cast<double>(judged.size());
  found.error = std::sqrt(found.error / n);
  found.mean /= n;
  found.rough = rms_above(judged, 1 / kTick, kRoughAbove);
  return found;
}

uint64_t ghost_ticks(const SlowScene& scene, const SlowRun& run) {
  uint64_t ghosts = 0;
  for (size_t k = 0; k < run.x.size(); ++k) {
    ghosts += run.x[k] > scene.leaves + kPast && run.is_felt[k];
  }
  return ghosts;
}

void eval_slow_contact(const SlowEval& eval, const Rows& all) {
  all.machine("slow-contact");
  Progress progress("eval slow-contact", 3 * static_cast<double>(slow_renderers().size()));
  const SlowScene ball = ball_over_ball(eval.fineness);
  for (const JudgedRenderer& renderer : slow_renderers()) {
    Rows rows = all.of(renderer.name + ", over a ball");
    const SlowRun fresh = run_slowly(ball, renderer, 1);
    for (const uint32_t period : {1u, 5u, 10u, 20u}) {
      const Slowness found = compare_runs(ball, fresh, run_slowly(ball, renderer, period));
      const std::string at = " at " + std::to_string(1000 / period) + " Hz";
      rows.add({{"force, mean" + at, found.mean, "N"},
                {"error, root mean square" + at, found.error, "N"}});
      const bool is_goal = renderer.is_smooth && period == 20;
      rows.add("force above 50 Hz, root mean square" + at, found.rough, "N",
               at_most(goal_if(is_goal, kMostRough)));
    }
    progress.step();
  }
  for (const bool with_box : {false, true}) {
    const SlowScene edge = off_an_edge(with_box);
    for (const JudgedRenderer& renderer : slow_renderers()) {
      const SlowRun fresh = run_slowly(edge, renderer, 1);
      uint64_t ghosts = 0;
      for (uint32_t late = 0; late < eval.phases; ++late) {
        ghosts += ghost_ticks(edge, run_slowly(edge, renderer, 20, late));
      }
      all.of(renderer.name + ", " + edge.scene.name)
          .add({{"ticks felt on the block",
                 std::count(fresh.is_felt.begin(), fresh.is_felt.end(), true)},
                {"ticks felt past it, contacts up to 20 ms old", ghosts, "", kMustBeZero}});
      progress.step();
    }
  }
}

Measured suite_slow_contact(Command&) {
  return measured(eval_slow_contact, std::make_shared<SlowEval>());
}

}  // namespace haptic
