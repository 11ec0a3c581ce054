// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/free.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "clients/lab/support/measurement.h"
#include "clients/lab/support/scripted_hand.h"
#include "clients/lockstep/lockstep.h"
#include "proto/math/units.h"
#include "proto/os/progress.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kEnough = 0.1;    // range of distances [m]; 2.5 × 2 m/s × 20 ms
constexpr double kProvable = 0.9;  // fraction of a distance that a detector must be able to prove
constexpr uint64_t kRelease = 3;   // in units of the answers' age; a held proxy has let go by then
constexpr uint32_t kOldestAnswer = 20;  // largest default age of an answer [ticks]
constexpr double kMaxTorque = 1;  // of the device, which holds the torque that it is told [N·m]
constexpr double kLowestGap = 0.2e-3;  // [m]; closest approach of the tool when it is lowered

std::vector<FreeScene> free_scenes_of(const FreeEval& eval) {
  std::vector<FreeScene> scenes{peg_over_hole()};
  if (!eval.all_scenes) return scenes;
  scenes.push_back(box_over_moving_plate());
  scenes.push_back(bumpy_balls(eval.seed));
  return scenes;
}

/// Lowers the tool from above to a distance of kLowestGap from the first object.
Vec3 touch_from_above(const FreeScene& scene, bool as_point) {
  const FreeOracle oracle(scene.objects[0], as_point ? Soup{} : scene.tool);
  Vec3 p = scene.over;
  for (double way = kEnough; way > 0; p.z -= way) {
    way = oracle.at_least({p, {}}, kLowestGap, kEnough);
  }
  return p;
}

/// Largest of the forces and torques of a tick; NaN if one is not finite.
double felt_in(const ServoFrame& frame) {
  const Wrench &F = frame.F_coupling_W, &held = frame.F_device_B;
  if (!is_finite(F) || !is_finite(held)) return std::numeric_limits<double>::quiet_NaN();
  return std::max({norm(F.f), norm(F.t), norm(held.f), norm(held.t)});
}

std::vector<uint32_t> ages_of(const FreeEval& eval) {
  if (!eval.ages.empty()) return eval.ages;
  std::vector<uint32_t> ages(kOldestAnswer);
  std::iota(ages.begin(), ages.end(), 1);
  return ages;
}

/// Adds the counts of every renderer of a point, or of a body, in one scene.
void judge_scene(const FreeScene& scene, bool as_point, const FreeEval& eval,
                 std::vector<FreeFound>& found) {
  const std::vector<JudgedRenderer>& renderers = free_renderers();
  for (const FreeHand& hand : free_hands(touch_from_above(scene, as_point), eval.seed)) {
    FreeWay way(scene, hand, as_point);
    for (size_t i = 0; i < renderers.size(); ++i) {
      if (is_of_body(renderers[i].renderer) == as_point) continue;
      for (const uint32_t age : ages_of(eval)) {
        found[i].add(judge_free(renderers[i], way, age, eval.ticks));
      }
    }
  }
}

void add_free(const std::string& name, const FreeFound& found, const Rows& all) {
  Rows rows = all.of(name);
  rows.add({{"ticks", found.ticks},
            {"ticks that may touch, and do", found.touched},
            {"free ticks", found.free},
            {"free ticks in which something is felt", static_cast<double>(found.felt), "",
             given(0, found.felt == 0 && found.free > 0)},
            {"force or torque in them, max", found.largest, "N", kMustBeZero}});
  if (found.felt > 0) rows.note("the most was felt", found.where);
}

}  // namespace

const std::vector<JudgedRenderer>& free_renderers() {
  static const std::vector<JudgedRenderer> kJudged{
      {"god-object3", Renderer::kGodObject3, {}},
      {"virtual-proxy3", Renderer::kVirtualProxy3, {}},
      {"penalty3", Renderer::kPenalty3, {}},
      {"direct6, direct", Renderer::kDirect6, SoftSolver::kDirect},
      {"direct6, quasi-static", Renderer::kDirect6, SoftSolver::kQuasiStatic},
      {"voxel, direct", Renderer::kVoxel, SoftSolver::kDirect},
      {"voxel, quasi-static", Renderer::kVoxel, SoftSolver::kQuasiStatic},
      {"voxel, tangent planes, direct", Renderer::kVoxel, SoftSolver::kDirect, false},
      {"voxel, tangent planes, quasi-static", Renderer::kVoxel, SoftSolver::kQuasiStatic, false},
      {"localized, direct", Renderer::kLocalized, SoftSolver::kDirect},
      {"localized, quasi-static", Renderer::kLocalized, SoftSolver::kQuasiStatic},
      {"sensation, direct", Renderer::kSensation, SoftSolver::kDirect},
      {"sensation, quasi-static", Renderer::kSensation, SoftSolver::kQuasiStatic},
      {"god-object6", Renderer::kGodObject6, {}}};
  return kJudged;
}

void FreeFound::add(const FreeFound& other) {
  ticks += other.ticks, touched += other.touched;
  free += other.free, felt += other.felt;
  if (!(other.largest > largest)) return;
  largest = other.largest;
  where = other.where;
}

FreeWay::FreeWay(const FreeScene& scene, const FreeHand& hand, bool as_point)
    : scene_(scene), hand_(hand), distances_(scene.objects.size()) {
  const Soup tool = as_point ? Soup{} : scene.tool;
  for (const Soup& object : scene.objects) oracles_.emplace_back(object, tool);
  for (const Vec3& v : tool.vertices) {
    middle_T_ += v / static_cast<double>(tool.vertices.size());
  }
  for (const Vec3& v : tool.vertices) radius_ = std::max(radius_, norm(v - middle_T_));
  // a voxel's surface can be off by a diagonal of the band
  layer_ = std::numbers::sqrt3 * scene.config.voxel.band;
  if (as_point) radius_ = scene.config.proxy_radius;
}

Pose FreeWay::in_object(size_t object, uint64_t tick) const {
  const double t = kTick * static_cast<double>(tick);
  return inverse(scripted_pose(scene_.config.objects[object], t)) * hand_.path(t);
}

double FreeWay::distance(size_t object, uint64_t tick) {
  std::vector<double>& known = distances_[object];
  if (known.size() <= tick) known.resize(tick + 1, -1);
  if (known[tick] < 0) {
    known[tick] = oracles_[object].at_least(in_object(object, tick), layer_, kEnough);
  }
  return known[tick];
}

bool FreeWay::is_free(uint64_t asked, uint64_t now) {
  for (size_t object = 0; object < oracles_.size(); ++object) {
    const Pose then = in_object(object, asked), here = in_object(object, now);
    const double way = norm(here * middle_T_ - then * middle_T_);
    const double angle = norm(to_rotation_vector(here.q * conjugate(then.q)));
    const double travel = way + angle * radius_;
    if (!(kProvable * distance(object, asked) > travel + layer_)) return false;
  }
  return true;
}

FreeFound judge_free(const JudgedRenderer& renderer, FreeWay& way, uint32_t age, uint64_t ticks) {
  ScriptedHand hand(way.hand().path, kMaxTorque);
  Lockstep session(renderer.in(way.scene().config), way.scene().shapes, hand, {1, age});
  FreeFound found;
  found.where = way.scene().name + ", " + way.hand().name + ", " + std::to_string(age) + " late";
  uint64_t free_since = 0;
  for (uint64_t k = 0; k < ticks && session.step(); ++k) {
    const ContactSet* const set = session.contacts();
    if (set == nullptr) continue;
    ++found.ticks;
    if (!way.is_free(set->answers_tick, k)) free_since = k + 1 + kRelease * age;
    const double felt = felt_in(session.frame());
    // NaN counts as felt
    const uint64_t is_felt = felt == 0 ? 0 : 1;
    if (k < free_since) {
      found.touched += is_felt;
      continue;
    }
    ++found.free;
    found.felt += is_felt;
    found.largest = std::max(found.largest, felt);
  }
  return found;
}

void eval_free(const FreeEval& eval, const Rows& all) {
  const std::vector<JudgedRenderer>& renderers = free_renderers();
  std::vector<FreeFound> found(renderers.size());
  const auto scenes = free_scenes_of(eval);
  Progress progress("eval free", 2 * static_cast<double>(scenes.size()));
  for (const FreeScene& scene : scenes) {
    for (const bool as_point : {true, false}) {
      judge_scene(scene, as_point, eval, found);
      progress.step();
    }
  }
  all.machine("free");
  for (size_t i = 0; i < renderers.size(); ++i) {
    add_free(renderers[i].name, found[i], all);
  }
}

Measured suite_free(Command&) {
  return measured(eval_free, std::make_shared<FreeEval>());
}

}  // namespace haptic
