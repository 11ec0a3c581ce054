// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/moving.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "clients/lab/eval/oracle/exact_cgal.h"
#include "clients/lab/eval/rigid.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/offline_session.h"
#include "clients/lab/support/scripted_hand.h"
#include "proto/os/progress.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kFelt = 1e-9;       // [N]; a closed device is commanded exactly zero
constexpr double kElsewhere = 1e-4;  // [m]; above the extrapolation error at 120 Hz
constexpr std::array kMovingRenderers{Renderer::kGodObject6, Renderer::kConstrained6};

SessionConfig moving_session(const MovingScene& scene, Renderer renderer) {
  RigidScene named;
  named.name = scene.kind;
  SessionConfig config = rigid_session(named, renderer);
  config.n_objects = static_cast<uint32_t>(scene.moves.size());
  std::copy(scene.moves.begin(), scene.moves.end(), config.objects.begin());
  return config;
}

struct MovingCount {
  const char* name;
  uint64_t MovingFound::*count;
  bool has_goal = false;  // none
};
constexpr std::array kMovingCounts{
    MovingCount{"scenes", &MovingFound::scenes},
    MovingCount{"ticks", &MovingFound::ticks},
    MovingCount{"ticks with a force", &MovingFound::felt},
    MovingCount{"ticks not finite", &MovingFound::not_finite, true},
    MovingCount{"verified poses", &MovingFound::poses},
    MovingCount{"of them inside or meeting", &MovingFound::inside, true},
    MovingCount{"scenes with a change of side", &MovingFound::sides_changed, true},
    MovingCount{"ticks with a force across an object", &MovingFound::across, true},
    MovingCount{"placed anew", &MovingFound::placed_anew, true},
    MovingCount{"ticks closed though there is a free way", &MovingFound::closed, true},
    MovingCount{"sets behind their objects", &MovingFound::behind}};

void add_moving(const MovingFound& found, Rows& rows) {
  for (const MovingCount& row : kMovingCounts) {
    rows.add(row.name, found.*row.count, "", row.has_goal ? kMustBeZero : Goal{});
  }
  rows.add({{"behind its objects, max", found.most_behind, "m"},
            {"force, max", found.largest_force, "N"}});
}

}  // namespace

void MovingFound::add(const MovingFound& other) {
  for (const MovingCount& row : kMovingCounts) this->*row.count += other.*row.count;
  most_behind = std::max(most_behind, other.most_behind);
  largest_force = std::max(largest_force, other.largest_force);
}

bool MovingFound::has_missed() const {
  return std::ranges::any_of(
      kMovingCounts, [&](const MovingCount& row) { return row.has_goal && this->*row.count > 0; });
}

bool MovingJudge::is_on_side(const Pose& X_WT, double t) const {
  return scene_.is_on_side(X_WT, object_poses(scene_, t));
}

void MovingJudge::judge_pose(const ContactSet& set, double t) {
  if ((set.flags & kContactReseeded) != 0) ++found_.placed_anew;
  if ((set.flags & kContactNoFreePose) != 0) return;
  ++found_.poses;
  const size_t n = scene_.objects.size();
  double elsewhere = 0;
  const std::vector<Pose> then = object_poses(scene_, t);
  bool meets = false;
  for (size_t i = 0; i < n; ++i) {
    const Pose X_OT = inverse(set.objects[i].X_WO) * set.X_WG;
    meets |= surfaces_meet_by_cgal(scene_.objects[i].mesh, scene_.tool.mesh, X_OT);
    elsewhere = std::max(elsewhere, norm(then[i].p - set.objects[i].X_WO.p));
  }
  found_.inside += meets;
  found_.behind += elsewhere > kElsewhere;
  found_.most_behind = std::max(found_.most_behind, elsewhere);
  std::vector<Pose> X_WO;
  for (const ObjectSeen& object : set.objects) X_WO.push_back(object.X_WO);
  if (!scene_.is_on_side(set.X_WG, X_WO)) found_.sides_changed = 1;
}

void MovingJudge::add(const ServoFrame& frame, const ContactSet* set, double t) {
  ++found_.ticks;
  const double force = norm(frame.F_device_B.f) + norm(frame.F_device_B.t);
  if (!std::isfinite(force) || !is_finite(frame.X_WP)) {
    ++found_.not_finite;
    return;
  }
  if (set == nullptr) return;
  if (!has_set_ || set->seq != last_seq_) {
    judge_pose(*set, t - static_cast<double>(frame.t_ns - set->answers_t_ns) * 1e-9);
    last_seq_ = set->seq;
    has_set_ = true;
  }
  found_.closed += (set->flags & kContactNoFreePose) != 0;
  if (force <= kFelt) return;
  ++found_.felt;
  found_.largest_force = std::max(found_.largest_force, norm(frame.F_device_B.f));
  found_.across += !is_on_side(frame.X_WP, t);
}

MovingFound run_moving(const MovingScene& scene, Renderer renderer,
                       const LockstepOptions& options) {
  ContactShapes shapes(scene.objects);
  shapes.bodies.tool = scene.tool;
  ScriptedHand hand(scene.hand_W);
  const SessionConfig config = moving_session(scene, renderer);
  Lockstep session(config, shapes, hand, options);
  MovingJudge judge(scene);
  const double dt = 1 / config.servo_rate;
  const auto ticks = static_cast<uint64_t>(scene.seconds / dt);
  for (uint64_t k = 0; k < ticks && session.step(); ++k) {
    judge.add(session.frame(), session.contacts(), static_cast<double>(k) * dt);
  }
  return judge.found();
}

void eval_moving(const MovingEval& eval, const Rows& all) {
  all.machine("moving");
  std::map<std::string, MovingFound> found;
  std::map<std::string, std::string> bad;
  Progress progress("eval moving", static_cast<double>(eval.scenes));
  for (uint64_t k = 0; k < eval.scenes; ++k) {
    progress.at(static_cast<double>(k));
    const MovingScene scene = make_moving_scene(eval.first_seed + k);
    for (const Renderer renderer : kMovingRenderers) {
      const MovingFound one = run_moving(scene, renderer, eval.lockstep);
      const std::string name = std::string(row_of(renderer).name) + ", " + scene.kind;
      found[name].add(one);
      if (one.has_missed()) {
        bad[name] += (bad[name].empty() ? "" : " ") + std::to_string(scene.seed);
      }
    }
  }
  for (const auto& [name, sum] : found) {
    Rows rows = all.of(name);
    add_moving(sum, rows);
    if (!bad[name].empty()) rows.note("seeds of scenes that miss a goal", bad[name]);
  }
}

Measured suite_moving(Command& command) {
  const auto eval = std::make_shared<MovingEval>();
  add_counts(command, {{"--scenes", &eval->scenes, "how many", 1, 1'000'000}});
  add_lockstep(command, eval->lockstep);
  return measured(eval_moving, eval);
}

}  // namespace haptic
