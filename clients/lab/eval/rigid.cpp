// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/rigid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "clients/hapt/options.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/offline_session.h"
#include "clients/lab/support/scan.h"
#include "clients/lab/support/scripted_hand.h"
#include "contact/shape/mesh/tool_body.h"
#include "proto/math/units.h"
#include "proto/os/progress.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kStiffness = 1000, kTurnStiffness = 2;  // [N/m], [N·m/rad]
constexpr double kDamping = 4, kTurnDamping = 5e-3;  // for proxies with mass [N·s/m], [N·m·s/rad]
constexpr double kMass = 0.05;                       // [kg]
constexpr double kClearance = 0.2e-3;                // of the peg in the hole [m]
constexpr double kFreeSpeed = 2, kFreeTurn = 10;     // [m/s], [rad/s]
constexpr double kFreeHeight = 0.1;  // [m]; about twice what the tool covers within kOldest ticks
constexpr uint32_t kOldest = 20;     // age of the answers in free space [ticks]
constexpr double kPushSpeed = 0.05;  // [m/s]
constexpr double kLeastPush = 0.01;  // [N]; weaker pushes are not evaluated
constexpr double kSlantGoal = 1e-9;  // tangential over normal force, at most
constexpr uint64_t kFreeTicks = 500, kPushTicks = 300;  // duration of both tests
constexpr std::array kFrictions{std::pair{0.0, ""}, std::pair{0.05, ", friction 0.05"},
                                std::pair{0.3, ", friction 0.3"}};
constexpr size_t kManyTriangles = 10000;  // beyond it the runs with friction are left out: two
                                          // scans take most of the time already
constexpr std::array kRigidRenderers{Renderer::kGodObject6, Renderer::kConstrained6};

bool is_massless(Renderer renderer) {
  return renderer == Renderer::kGodObject6;
}

RigidJudge judge_of(const RigidScene& scene, Renderer renderer, double friction) {
  const SessionConfig config = rigid_session(scene, renderer, friction);
  const ToolBody body = tool_body(scene.tool.mesh, config.tool);
  return RigidJudge(scene.object, scene.tool,
                    {.springs = {kStiffness, kTurnStiffness},
                     .margin = god_object_options(config, body).margin,
                     .dt = 1 / config.servo_rate,
                     .is_massless = is_massless(renderer),
                     .has_friction = friction > 0});
}

void judge_plane(Renderer renderer, const LockstepOptions& lockstep, const Rows& all) {
  Rows rows = all.of(std::string(row_of(renderer).name) + ", box on plate");
  double free = 0;
  for (uint32_t age = 1; age <= kOldest; ++age) {
    free = std::max(free, force_in_free_space(renderer, {lockstep.contact_period, age}));
  }
  rows.add({{"free at 2 m/s and 10 rad/s, 1 to 20 late: force, max", free, "N",
             at_most(goal_if(is_massless(renderer), 0))},
            {"pushed at 45°: force along/across the plane, max", slant_of_push(renderer, lockstep),
             "", at_most(goal_if(is_massless(renderer), kSlantGoal))}});
}

}  // namespace

SessionConfig rigid_session(const RigidScene& scene, Renderer renderer, double friction) {
  SessionConfig config = plain_session(kStiffness);
  config.renderer = renderer;
  config.coupling.rotational_stiffness = kTurnStiffness;
  if (!is_massless(renderer)) {
    config.coupling.translational_damping = kDamping;
    config.coupling.rotational_damping = kTurnDamping;
  }
  config.tool.mass = kMass;
  MaterialConfig& material = config.objects[0].material;
  material.friction_static = material.friction_dynamic = friction;
  assign(config.name, scene.name);
  return config;
}

void run_rigid(const RigidScene& scene, Renderer renderer, const std::function<Pose(double)>& path,
               uint64_t ticks, const LockstepOptions& lockstep, const SeeTick& see,
               double friction) {
  ContactShapes shapes(std::array{scene.object});
  shapes.bodies.tool = scene.tool;
  ScriptedHand hand(path);
  Lockstep session(rigid_session(scene, renderer, friction), shapes, hand, lockstep);
  for (uint64_t k = 0; k < ticks && session.step(); ++k) see(session.frame(), session.contacts());
}

RigidJudge shake_rigid(const RigidScene& scene, Renderer renderer, const RigidEval& eval) {
  const ShakingHand hand(scene.home, scene.shaking, eval.seed);
  RigidJudge judge = judge_of(scene, renderer, eval.friction);
  // the session starts at home, which is free, and the hand leaves from there
  const auto path = [&](double t) {
    constexpr double kLeave = 0.2;  // [s]
    const double share = std::clamp(t / kLeave, 0.0, 1.0);
    return moved(scene.home, share * way_between(scene.home, hand.at(t)));
  };
  const auto see = [&](const ServoFrame& frame, const ContactSet* set) { judge.add(frame, set); };
  run_rigid(scene, renderer, path, eval.ticks, eval.lockstep, see, eval.friction);
  return judge;
}

double force_in_free_space(Renderer renderer, const LockstepOptions& lockstep) {
  constexpr double kWay = 0.08;  // [m]
  const auto path = [](double t) {
    const double phase = kFreeSpeed / kWay * t;
    return Pose{{kWay * std::sin(phase), 0, kFreeHeight},
                from_rotation_vector({0, kFreeTurn * t, 0})};
  };
  double most = 0;
  run_rigid(box_on_plate(), renderer, path, kFreeTicks, lockstep,
            [&](const ServoFrame& frame, const ContactSet*) {
              most = std::max({most, norm(frame.F_coupling_W.f), norm(frame.F_coupling_W.t)});
            });
  return most;
}

double slant_of_push(Renderer renderer, const LockstepOptions& lockstep) {
  const RigidScene scene = box_on_plate();
  const auto path = [&](double t) {
    const double way = kPushSpeed * t / std::numbers::sqrt2;
    return Pose{scene.home.p + Vec3{way, 0, -way}, scene.home.q};
  };
  double most = 0;
  uint64_t pressed = 0;
  run_rigid(scene, renderer, path, kPushTicks, lockstep,
            [&](const ServoFrame& frame, const ContactSet*) {
              const Vec3& f = frame.F_coupling_W.f;
              if (f.z < kLeastPush) return;
              ++pressed;
              most = std::max(most, std::hypot(f.x, f.y) / f.z);
            });
  // no force, no ratio
  return pressed > 0 ? most : std::numeric_limits<double>::quiet_NaN();
}

void eval_rigid(RigidEval eval, const Rows& all) {
  Rows rows = all.machine("rigid");
  std::vector<RigidScene> scenes{peg_in_hole(kClearance), box_on_plate()};
  if (std::optional<RigidScene> bunny = bunny_on_bunny(eval.meshes)) {
    scenes.push_back(*std::move(bunny));
  } else {
    rows.note("bunny on bunny",
              "LEFT OUT: no bunny00.off in '" + eval.meshes + "'; say where: HAPTICD_MESHES");
  }
  Progress progress("eval rigid", static_cast<double>(kRigidRenderers.size() * scenes.size()));
  for (const Renderer renderer : kRigidRenderers) {
    judge_plane(renderer, eval.lockstep, all);
    for (const RigidScene& scene : scenes) {
      const std::string name = std::string(row_of(renderer).name) + ", " + scene.name + ", shaken";
      for (const auto& [friction, words] : kFrictions) {
        // two scans take most of the time already
        if (friction > 0 && scene.object.mesh.triangles.size() > kManyTriangles) continue;
        eval.friction = friction;
        shake_rigid(scene, renderer, eval).add_rows(name + words, all);
      }
      progress.step();
    }
  }
}

Measured suite_rigid(Command& command) {
  struct Options {
    RigidEval eval;
    double seconds = 4;
  };
  const auto options = std::make_shared<Options>();
  options->eval.meshes = meshes_folder();
  add_duration(command, "--for", options->seconds, "how long the hand shakes in each scene")
      .show_default();
  add_lockstep(command, options->eval.lockstep);
  return [options](Report& report) {
    options->eval.ticks = static_cast<uint64_t>(options->seconds / kTick);
    eval_rigid(options->eval, report.rows);
  };
}

}  // namespace haptic
