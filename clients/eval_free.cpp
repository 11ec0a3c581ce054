// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/eval_free.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "clients/lockstep.h"
#include "clients/scripted_hand.h"
#include "contact/detect/clear_pose.h"
#include "proto/renderer.h"

namespace haptic {
namespace {

constexpr double kTick = 1e-3;     // [s]
constexpr double kEnough = 0.1;    // that a distance is looked for [m]: 2.5 times 2 m/s for 20 ms
constexpr uint64_t kRelease = 3;   // ages
constexpr uint32_t kOldest = 20;   // [ticks]
constexpr double kTouch = 0.2e-3;  // no nearer to an object is a tool let down [m]

std::vector<FreeScene> scenes_of(const FreeEval& eval) {
  std::vector<FreeScene> scenes{peg_over_hole()};
  if (!eval.all_scenes) return scenes;
  scenes.push_back(box_over_moving_plate());
  for (const uint64_t seed : eval.seeds) scenes.push_back(bumpy_balls(seed));
  return scenes;
}

/// From above until the tool is no more than that off the first object.
Vec3 touch_from_above(const FreeScene& scene, bool as_point) {
  const FreeOracle oracle(scene.objects[0], as_point ? Soup{} : scene.tool);
  Vec3 p = scene.over;
  for (double way = kEnough; way > 0; p.z -= way) {
    way = oracle.at_least({p, {}}, kTouch, kEnough);
  }
  return p;
}

double felt_in(const ServoFrame& frame) {
  const Wrench &F = frame.F_coupling_W, &held = frame.F_device_B;
  return std::max({norm(F.f), norm(F.t), norm(held.f), norm(held.t)});
}

}  // namespace

const std::vector<FreeRenderer>& free_renderers() {
  static const std::vector<FreeRenderer> kJudged{
      {"god-object3", Renderer::kGodObject3, {}},
      {"virtual-proxy3", Renderer::kVirtualProxy3, {}},
      {"penalty3", Renderer::kPenalty3, {}},
      {"direct6, direct", Renderer::kDirect6, SoftSolver::kDirect},
      {"direct6, quasi-static", Renderer::kDirect6, SoftSolver::kQuasiStatic},
      {"voxel, direct", Renderer::kVoxel, SoftSolver::kDirect},
      {"voxel, quasi-static", Renderer::kVoxel, SoftSolver::kQuasiStatic},
      {"voxel, tangent planes, direct", Renderer::kVoxel, SoftSolver::kDirect, false},
      {"voxel, tangent planes, quasi-static", Renderer::kVoxel, SoftSolver::kQuasiStatic, false},
      {"god-object6", Renderer::kGodObject6, {}}};
  return kJudged;
}

void FreeFound::add(const FreeFound& other) {
  ticks += other.ticks, free += other.free, felt += other.felt;
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
  // voxels are as thick as their diagonal
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
    if (!(distance(object, asked) > (travel + layer_) / kLeastShare)) return false;
  }
  return true;
}

FreeFound judge_free(const FreeRenderer& renderer, FreeWay& way, uint32_t age, uint64_t ticks) {
  SessionConfig config = way.scene().config;
  config.renderer = renderer.renderer;
  config.proxy.solver = renderer.solver;
  config.voxel.field = renderer.reads_field ? 1 : 0;
  ScriptedHand hand(way.hand().path);
  Lockstep session(config, way.scene().shapes, hand, {1, age});
  FreeFound found;
  found.where = way.scene().name + ", " + way.hand().name + ", " + std::to_string(age) + " late";
  uint64_t free_since = 0;
  for (uint64_t k = 0; k < ticks && session.step(); ++k) {
    const ContactSet* const set = session.contacts();
    if (set == nullptr) continue;
    ++found.ticks;
    if (!way.is_free(set->answers_tick, k)) {
      free_since = k + 1 + kRelease * age;
      continue;
    }
    if (k < free_since) continue;
    ++found.free;
    const double felt = felt_in(session.frame());
    // NaN is felt too
    if (felt == 0) continue;
    ++found.felt;
    found.largest = std::max(found.largest, felt);
  }
  return found;
}

std::vector<Row> eval_free(const FreeEval& eval) {
  std::vector<uint32_t> ages = eval.ages;
  if (ages.empty()) {
    ages.resize(kOldest);
    std::iota(ages.begin(), ages.end(), 1);
  }
  const std::vector<FreeRenderer>& renderers = free_renderers();
  std::vector<FreeFound> found(renderers.size());
  const std::vector<FreeScene> scenes = scenes_of(eval);
  for (const FreeScene& scene : scenes) {
    for (const bool as_point : {true, false}) {
      const Vec3 touch = touch_from_above(scene, as_point);
      for (const FreeHand& hand : free_hands(touch, eval.seeds[0])) {
        FreeWay way(scene, hand, as_point);
        for (size_t i = 0; i < renderers.size(); ++i) {
          if (is_of_body(renderers[i].renderer) == as_point) continue;
          for (const uint32_t age : ages) {
            found[i].add(judge_free(renderers[i], way, age, eval.ticks));
          }
        }
      }
    }
  }
  Rows all("free");
  all.note("machine", machine_line());
  for (size_t i = 0; i < renderers.size(); ++i) {
    Rows rows(renderers[i].name);
    rows.add("ticks", static_cast<double>(found[i].ticks), "");
    rows.add("free ticks", static_cast<double>(found[i].free), "");
    rows.add("free ticks in which something is felt", static_cast<double>(found[i].felt), "", 0,
             found[i].felt == 0 && found[i].free > 0);
    rows.add("force or torque in them, max", found[i].largest, "N", 0, found[i].largest == 0);
    if (found[i].felt > 0) rows.note("the most was felt", found[i].where);
    all.append(rows.rows());
  }
  return all.rows();
}

}  // namespace haptic
