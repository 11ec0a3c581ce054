// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/voxel_contact.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "clients/lab/bench/peers/pair.h"
#include "clients/lab/bench/workloads/lod_pairs.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/bench/workloads/workload.h"
#include "clients/lab/support/scan.h"
#include "clients/lab/support/step_budget.h"
#include "clients/lab/support/thread_cpu.h"
#include "contact/bake/volume.h"
#include "contact/detect/body/voxel.h"
#include "contact/shape/parts/machine_parts.h"
#include "proto/math/motion_metric.h"
#include "proto/math/units.h"
#include "proto/os/environment.h"
#include "proto/wire/look_ahead.h"

namespace haptic {
namespace {

constexpr double kGoalStep = 1e-3;    // [s]
constexpr double kDeadline = 0.8e-3;  // of a budget [s]
constexpr int kTicksATry = 3000;      // to try a budget

/// A tool that a hand moves in or on an object.
struct Pair {
  std::string name;
  BakedShape tool, object;
  VoxelConfig voxel;
  std::function<Pose(double t)> path;  // X_OT at time t [s]
  std::function<Pose(double t)> deep;  // the path pressed in deep; empty: skipped
};

BakedShape baked(const Soup& soup) {
  ShapeConfig metres;
  metres.unit = 1;
  return bake_soup(soup.vertices, soup.triangles, metres);
}

VoxelConfig voxels_of(double size, double spacing) {
  VoxelConfig voxel = tight_voxels(size, spacing);
  voxel.budget = 0;  // no limit
  return voxel;
}

/// Workload W3 of the collision queries: the rings of both threads are at the same heights, so that
/// the triangles leave a gap of 20 to 50 µm throughout.
Pair bolt_in_nut(bool is_free) {
  primitive::Bolt bolt;
  bolt.grid.along = 140;
  primitive::Nut nut;
  nut.height = bolt.length * 100 / 140;
  nut.grid.along = 100;
  const auto at = [bolt](double t, double press, double most_turn, double tilt) -> Pose {
    const double turn = swing(most_turn, 0.5, t);
    const Quat lean = from_rotation_vector({swing(tilt, 1.1, t), swing(tilt, 0.7, t), 0});
    return {{press * std::sin(2 * kPi * 2.3 * t), press * std::cos(2 * kPi * 1.9 * t),
             bolt.pitch * turn / (2 * kPi) + swing(0.1 * press, 5, t)},
            lean * from_rotation_vector({0, 0, turn})};
  };
  Pair pair{is_free ? "bolt free in nut" : "bolt in nut",
            baked(make_bolt(bolt)),
            baked(make_nut(nut)),
            voxels_of(0.2e-3, 0.24e-3),
            {},
            {}};
  if (is_free) {
    pair.path = [at](double t) { return at(t, 5e-6, 2e-4, 1e-4); };
    return pair;
  }
  pair.path = [at](double t) { return at(t, 0.015e-3 + swing(0.015e-3, 0.8, t), 0.05, 5e-4); };
  pair.deep = [at](double t) { return at(t, 0.3e-3, 0.2, 5e-4); };
  return pair;
}

Pair peg_in_hole() {
  primitive::Hole hole;
  hole.grid.along = 64;
  const auto at = [](double t, double press) -> Pose {
    const Quat tilt = from_rotation_vector({swing(2e-3, 1.1, t), swing(2e-3, 0.7, t), 0});
    return {{press * std::sin(2 * kPi * 2.3 * t), press * std::cos(2 * kPi * 1.9 * t),
             swing(5e-3, 0.5, t)},
            tilt * from_rotation_vector({0, 0, swing(0.5, 0.4, t)})};
  };
  return {"peg in hole",
          baked(make_peg(hole)),
          baked(make_hole(hole)),
          voxels_of(0.2e-3, 0.22e-3),
          [at](double t) { return at(t, 0.11e-3 + swing(0.11e-3, 0.8, t)); },
          [at](double t) { return at(t, 0.5e-3); }};
}

BakedShape jaw(const std::string& file) {
  const std::string data = environment("HAPTICD_DATA");
  if (data.empty()) throw MeshError("HAPTICD_DATA names no folder with meshes/chai3d/" + file);
  ShapeConfig shape;
  assign(shape.mesh, data + "/meshes/chai3d/" + file);
  shape.unit = 0.2e-3;
  shape.allow_open = 1;
  return bake_object(shape, uint64_t{4} << 30);
}

/// The upper jaw grinds on the lower one. Throws MeshError.
Pair jaw_pair() {
  Pair pair{"jaws", jaw("teeth-top.obj"), jaw("teeth-bottom.obj"), voxels_of(0.25e-3, 0.25e-3), {},
            {}};
  // the height at which the teeth just meet, by triangles
  const double bite = lowest_free(pair.object.shape, pair.tool.shape, -0.03, 0.05);
  const auto at = [bite](double t, double press) -> Pose {
    return {
        {swing(0.5e-3, 1.3, t), bite - press * (0.5 + swing(0.5, 2.1, t)), swing(0.5e-3, 0.9, t)},
        from_rotation_vector({swing(5e-3, 0.7, t), 0, swing(5e-3, 1.1, t)})};
  };
  pair.path = [at](double t) { return at(t, 0.4e-3); };
  pair.deep = [at](double t) { return at(t, 2e-3); };
  return pair;
}

/// The detector on one pair.
struct Contest {
  BakedVolume tool, object;
  std::array<VoxelObject, 1> objects;
  VoxelModel model;
  std::unique_ptr<ContactSet> set = std::make_unique<ContactSet>();

  explicit Contest(const Pair& pair)
      : tool(bake_tool(pair.tool, pair.voxel)), object(bake_obstacle(pair.object, pair.voxel)) {
    objects[0] = {object.content.map, object.content.field};
    model = voxel_model(pair.voxel, tool.content.shell);
    model.objects = objects;
  }
  // the model points into this object
  Contest(const Contest&) = delete;
  Contest& operator=(const Contest&) = delete;

  /// CPU time of a step [s].
  double step(VoxelState& state, const Pose& X_OT, double reach) {
    BodyQuestion question;
    question.X_WO.resize(1);
    question.V_WO.resize(1);
    question.X_WT = X_OT;
    question.reach = reach;
    return cpu_seconds_of([&] { detect_voxel(model, state, question, *set); });
  }
};

/// Look-ahead of a session at 1 kHz: the motion of three ticks.
double reach_of(const Contest& contest, const Pose& before, const Pose& X_OT) {
  return std::max(3 * largest_travel(way_between(before, X_OT), contest.model.shell.radius),
                  kLeastBodyReach);
}

/// Results along a path.
struct Course {
  std::vector<double> times;  // CPU [s]
  std::vector<double> tested, touching, clusters;
  std::vector<double> collides, distances;  // CPU of a peer [s]
  double meeting = 0;                       // number of collisions by the peer
  size_t cut_short = 0;                     // steps ended by the budget
};

/// Follows a path tick by tick, with the peer, if any, in between.
Course follow(Contest& contest, const std::function<Pose(double)>& path, int ticks, PairPeer* peer,
              int peer_asked) {
  Course course;
  VoxelState state(contest.model);
  const int every = std::max(ticks / std::max(peer_asked, 1), 1);
  for (int tick = 0; tick < ticks; ++tick) {
    const Pose X_OT = path(kTick * tick);
    const double reach = reach_of(contest, path(kTick * (tick - 1)), X_OT);
    contest.set->flags = 0;
    course.times.push_back(contest.step(state, X_OT, reach));
    course.tested.push_back(static_cast<double>(state.tested));
    course.cut_short += (contest.set->flags & kContactIterationLimit) != 0;
    course.clusters.push_back(static_cast<double>(contest.set->contacts.size()));
    course.touching.push_back(static_cast<double>(state.touching));
    if (peer == nullptr || tick % every != every / 2) continue;
    course.collides.push_back(
        cpu_seconds_of([&] { course.meeting += peer->collides(X_OT) ? 1 : 0; }));
    course.distances.push_back(cpu_seconds_of([&] { peer->distance(X_OT); }));
  }
  return course;
}

void add_course(Rows& rows, const std::string& prefix, const Course& course) {
  add_times(rows, prefix + "CPU", course.times, kGoalStep);
  rows.add({{prefix + "CPU p99.9", percentile(course.times, 99.9), "s"},
            {prefix + "contact rate", 1 / mean_of(course.times), "Hz", at_least(1 / kGoalStep)},
            {prefix + "points tested p50", percentile(course.tested, 50)},
            {prefix + "points tested max", percentile(course.tested, 100)},
            {prefix + "points touching p50", percentile(course.touching, 50)},
            {prefix + "points touching max", percentile(course.touching, 100)},
            {prefix + "clusters p50", percentile(course.clusters, 50)}});
}

void add_peer(Rows& rows, const std::string& prefix, const Course& course) {
  const auto asked = static_cast<double>(course.collides.size());
  rows.add(prefix + "FCL says that they meet, of the poses", course.meeting / asked);
  const std::string name = prefix + "CPU", beside = ", beside";
  add_beside(rows, name, course.times, "FCL, whether they meet", course.collides, beside);
  add_beside(rows, name, course.times, "FCL, how far they are apart", course.distances, beside);
}

/// Pressed in deep: without a budget, then with the one that meets the deadline.
void add_deadline(Rows& rows, const std::string& prefix, Contest& contest, const Pair& pair,
                  int ticks) {
  const int few = std::min(ticks, kTicksATry);
  const Course whole = follow(contest, pair.deep, few, nullptr, 0);
  rows.add({{prefix + "deep, CPU p99, any number of points", percentile(whole.times, 99), "s"},
            {prefix + "deep, points tested p50", percentile(whole.tested, 50)}});
  // every node once, and every point twice
  const Pointshell& shell = contest.model.shell;
  const auto most = static_cast<uint32_t>(shell.nodes.size() + 2 * shell.x.size());
  const auto p99_with = [&](uint32_t budget) {
    if (budget == most) return percentile(whole.times, 99);
    contest.model.budget = budget;
    return percentile(follow(contest, pair.deep, few, nullptr, 0).times, 99);
  };
  const uint32_t budget = budget_for(kDeadline, most, p99_with);
  rows.add(prefix + "budget for 0.8 ms", budget);
  contest.model.budget = budget;
  const Course cut = follow(contest, pair.deep, ticks, nullptr, 0);
  contest.model.budget = ~0u;
  const double worst = percentile(cut.times, 99.9);
  rows.add({{prefix + "deep, steps that the budget ends",
             static_cast<double>(cut.cut_short) / static_cast<double>(cut.times.size())},
            {prefix + "deep, with the budget, CPU p99.9", worst, "s", at_most(kGoalStep)},
            {prefix + "deep, with the budget, CPU max", percentile(cut.times, 100), "s"}});
  const double over = std::max(percentile(cut.tested, 100) - budget, 0.0);
  rows.add(prefix + "deep, points over the budget", over, "", at_most(0));
}

void run_pair(const Pair& pair, const BenchVoxelContactOptions& options, const Rows& all) {
  Rows rows = all.of(pair.name);
  const std::string prefix = pair.name + ", ";
  Contest contest(pair);
  const MeshShape &tool = pair.tool.shape, &object = pair.object.shape;
  rows.add({{prefix + "triangles of the tool", tool.mesh.triangles.size()},
            {prefix + "triangles of the object", object.mesh.triangles.size()},
            {prefix + "points", contest.model.shell.x.size()},
            {prefix + "points apart", pair.voxel.point_spacing, "m"},
            {prefix + "cell of the field", pair.voxel.size, "m"}});
  const auto peer = make_fcl_peer(object.mesh, tool.mesh);
  const Course course = follow(contest, pair.path, options.ticks, peer.get(), options.peer_asked);
  add_course(rows, prefix, course);
  if (peer) {
    add_peer(rows, prefix, course);
  } else {
    rows.note(prefix + "FCL", kLeftOut);
  }
  if (pair.deep) add_deadline(rows, prefix, contest, pair, options.ticks);
}

/// A pair by its name on the command line. Throws MeshError.
Pair make_pair(const std::string& name) {
  if (name == "bolt" || name == "free-bolt") return bolt_in_nut(name == "free-bolt");
  if (name == "peg") return peg_in_hole();
  return jaw_pair();
}

}  // namespace

void bench_voxel_contact(const BenchVoxelContactOptions& options, const Rows& all) {
  Rows rows = all.of("contact step");
  for (const std::string& name : options.pairs) {
    try {
      Pair pair = make_pair(name);
      for (double* length : {&pair.voxel.size, &pair.voxel.band, &pair.voxel.point_spacing}) {
        *length *= options.coarser;
      }
      run_pair(pair, options, all);
    } catch (const MeshError& error) {
      rows.note(name, std::string("LEFT OUT: ") + error.what());
    }
  }
}

}  // namespace haptic
