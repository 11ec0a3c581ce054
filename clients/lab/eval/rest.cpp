// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/rest.h"

#include <algorithm>
#include <functional>

#include "clients/lab/eval/oracle/place.h"
#include "clients/lab/eval/oracle/rest_cgal.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/scripted_hand.h"
#include "clients/lockstep/lockstep.h"
#include "proto/os/progress.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kProxyStiffness = 1000;   // [N/m]
constexpr double kLeastForce = 0.05;       // [N]; positions with less are not tested
constexpr double kLeastGain = 1e-3;        // [N]; smallest reduction of the force that counts
constexpr double kRestlessDescent = 1e-6;  // [N]; as in EvalJudge
constexpr double kRestShare = 0.999;       // goal: share of ticks in a local minimum
constexpr uint64_t kSphereShare = 5;       // the sphere gets a fifth as many meshes

/// A family of meshes, one per seed, and the radius of the proxy led over them.
struct RestScene {
  std::string name;
  double radius;  // of the proxy; 0: a point [m]
  std::function<Soup(uint64_t)> make;
  uint64_t meshes;
};

std::vector<RestScene> rest_scenes_of(const RestEval& eval) {
  const uint64_t rolled = std::max<uint64_t>(eval.meshes / kSphereShare, 1);
  return {{"point on spiky spheres", 0, [](uint64_t s) { return make_spiky_sphere(6, 0.6, s); },
           eval.meshes},
          {"sphere of 3 mm on spiky spheres", 3e-3,
           [](uint64_t s) { return make_spiky_sphere(16, 0.4, s); }, rolled},
          {"sphere of 3 mm in a gyroid", 3e-3, [](uint64_t) { return make_gyroid(40); }, rolled}};
}

void add_count(const std::string& name, const RestCount& count, bool is_point, const Rows& all) {
  Rows rows = all.of(name);
  rows.add({{"ticks in contact", count.touching},
            {"of them not at rest within the tick", count.restless}});
  const auto ticks = static_cast<double>(std::max<uint64_t>(count.touching, 1));
  const double share = 1 - static_cast<double>(count.restless) / ticks;
  rows.add({{"share at rest within the tick", share, "", at_least(kRestShare)},
            {"ticks at a solver's limit", count.limits}});
  if (!is_point) return;
  rows.add({{"places that ways are tried from", count.judged},
            {"of them caught: a straight way is free", count.caught, "", kMustBeZero},
            {"force such a way would take, max", count.worst, "N"},
            {"of a force of", count.of_force, "N"},
            {"of them with the verified proxy inside", count.inside, "", kMustBeZero}});
}

}  // namespace

void RestCount::add(const RestCount& other) {
  if (other.worst > worst) worst = other.worst, of_force = other.of_force;
  touching += other.touching, restless += other.restless, limits += other.limits;
  judged += other.judged, caught += other.caught, inside += other.inside;
}

RestCount judge_rests(const Soup& soup, RestHand kind, double radius, const RestEval& eval,
                      uint64_t seed) {
  const MeshShapeData data = build_shape(soup);
  const MeshShape shape = data.view();
  const WayJudge ways(shape.mesh);
  const FacetBins facets(shape.mesh);
  ScriptedHand hand(rest_path(kind, kRestRadius, eval.ticks, seed));
  SessionConfig config = plain_session(kProxyStiffness);
  config.renderer = radius > 0 ? Renderer::kVirtualProxy3 : Renderer::kGodObject3;
  config.proxy_radius = radius;
  Lockstep lockstep(config, std::span(&shape, 1), hand, {1, 0});
  RestCount count;
  for (uint64_t k = 0; k < eval.ticks && lockstep.step(); ++k) {
    const ServoFrame& frame = lockstep.frame();
    const ContactSet* const set = lockstep.contacts();
    const Vec3 tool = frame.X_WT.p, proxy = frame.X_WP.p;
    const double force = kProxyStiffness * norm(proxy - tool);
    if (force == 0) continue;
    ++count.touching;
    count.limits += set != nullptr && (set->flags & kContactIterationLimit) != 0;
    count.restless +=
        kProxyStiffness * free_descent(facets, proxy, tool, radius) > kRestlessDescent;
    if (radius > 0 || k % eval.every != 0 || force < kLeastForce) continue;
    ++count.judged;
    count.inside += ways.holds(frame.X_WG.p);
    const std::optional<double> way =
        ways.free_way(proxy, tool, kLeastGain / kProxyStiffness, eval.directions, seed + k);
    count.caught += way.has_value();
    const double gain = kProxyStiffness * way.value_or(0);
    if (gain > count.worst) count.worst = gain, count.of_force = force;
  }
  return count;
}

void eval_rest(const RestEval& eval, const Rows& all) {
  all.machine("rest");
  const auto scenes = rest_scenes_of(eval);
  Progress progress("eval rest", static_cast<double>(scenes.size() * kRestHands.size()));
  for (const RestScene& scene : scenes) {
    for (const RestHand hand : kRestHands) {
      RestCount count;
      for (uint64_t m = 0; m < scene.meshes; ++m) {
        const uint64_t seed = eval.seed + m;
        count.add(judge_rests(scene.make(seed), hand, scene.radius, eval, seed));
      }
      add_count(scene.name + ", " + name_of(hand), count, scene.radius == 0, all);
      progress.step();
    }
  }
}

Measured suite_rest(Command&) {
  return measured(eval_rest, std::make_shared<RestEval>());
}

}  // namespace haptic
