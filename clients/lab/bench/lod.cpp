// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "clients/lab/bench/workloads/lod_pairs.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/thread_cpu.h"
#include "contact/bake/session.h"
#include "contact/step.h"
#include "proto/config/command_line.h"
#include "proto/math/motion_metric.h"
#include "proto/math/units.h"
#include "proto/os/progress.h"
#include "proto/wire/renderer.h"
#include "servo/solve/body/soft_proxy.h"

namespace haptic {
namespace {

constexpr double kGoalStep = 2e-3;    // p99 of sensation [s]; half of the paper's 100 Hz, and more
constexpr double kGoalFaster = 10;    // sensation than the exact query, at least
constexpr double kGoalError = 0.05;   // of its force, rms, of the rms force of the exact query
constexpr uint32_t kJudged = 40'000;  // triangles of a pair from which on the goals apply
constexpr int kChunk = 20;            // ticks of one renderer before the next takes its turn
// ticks from nothing to pressed, which no hand does within one: they are not counted
constexpr int kWarmUp = 100;

struct Options {
  std::vector<std::string> pairs = kLodPairs;
  int ticks = 500;
  double threshold = PieceConfig{}.threshold;  // [m]
};

/// One renderer on the way, with what it answered.
struct Course {
  std::string name;
  Renderer renderer;
  std::unique_ptr<ContactModel> model;
  std::unique_ptr<ContactState> state;
  std::vector<double> times;   // CPU of contact_step [s]
  std::vector<Wrench> forces;  // of the contacts where the tool is
  size_t n_cut = 0;            // answers that were cut short
};

Course course_of(const LodPair& pair, const ContactShapes& shapes, Renderer renderer) {
  SessionConfig config = pair.config;
  config.renderer = renderer;
  auto model = std::make_unique<ContactModel>(build_contact_model(config, shapes));
  auto state = std::make_unique<ContactState>(*model);
  return {std::string(row_of(renderer).name), renderer, std::move(model), std::move(state), {}, {}};
}

/// Force and torque of the contacts of a set where the tool is, about its origin.
Wrench wrench_of(const ContactSet& set, const ServoFrame& servo) {
  SoftProxyModel model;
  model.solver = SoftSolver::kDirect;
  SoftProxyState state;
  TickScene scene;
  for (const ObjectSeen& object : set.objects) scene.X_WO.push_back(object.X_WO);
  scene.V_WO.resize(set.objects.size());
  const BodyTick tick{scene, {servo.X_WT, servo.V_WT}, &set, kTick, set.tool, {}};
  return solve_soft_proxy(model, state, tick).F_hand_W;
}

void step(const LodPair& pair, int tick, Course& course) {
  ServoFrame servo{};
  servo.tick = static_cast<uint64_t>(kWarmUp + tick);
  servo.t_ns = int64_t{1'000'000} * (kWarmUp + tick + 1);
  servo.X_WT = servo.X_WP = pair.path(kTick * tick);
  const Twist way = way_between(pair.path(kTick * (tick - 1)), servo.X_WT);
  servo.V_WT = servo.V_WP = {way.v / kTick, way.w / kTick};
  servo.renderer = static_cast<uint32_t>(course.renderer);
  std::unique_ptr<const ContactSet> set;
  const double took = cpu_seconds_of([&] {
    set.reset(new ContactSet(contact_step(*course.model, *course.state, servo, nullptr)));
  });
  if (tick < 0) return;
  course.times.push_back(took);
  course.n_cut += (set->flags & kContactIterationLimit) != 0;
  const bool is_soft = row_of(course.renderer).moves == Moves::kSoftBody;
  course.forces.push_back(is_soft ? wrench_of(*set, servo) : Wrench{});
}

double rms_of(const std::vector<Wrench>& forces, const std::vector<Wrench>* less = nullptr) {
  double sum = 0;
  for (size_t i = 0; i < forces.size(); ++i) {
    sum += norm_squared(forces[i].f - (less != nullptr ? (*less)[i].f : Vec3{}));
  }
  return std::sqrt(sum / static_cast<double>(std::max<size_t>(forces.size(), 1)));
}

const Course& course_named(const std::vector<Course>& courses, Renderer renderer) {
  return *std::find_if(courses.begin(), courses.end(),
                       [&](const Course& c) { return c.renderer == renderer; });
}

void run_pair(const LodPair& pair, const BakedSession& baked, const Options& options,
              const Rows& all) {
  Rows rows = all.of(pair.name);
  const size_t triangles =
      baked.objects[0].shape.mesh.triangles.size() + baked.tool->shape.mesh.triangles.size();
  rows.add("triangles of both", triangles);
  const ContactShapes shapes = baked.shapes();
  const auto leaves_of = [](const PieceTree& tree) { return tree.level_pieces.front(); };
  rows.add("convex pieces of both",
           leaves_of(shapes.bodies.pieces[0]) + leaves_of(shapes.bodies.tool_pieces));
  std::vector<Course> courses;
  for (const Renderer renderer : {Renderer::kVoxel, Renderer::kSensation, Renderer::kLocalized,
                                  Renderer::kDirect6, Renderer::kGodObject6}) {
    courses.push_back(course_of(pair, shapes, renderer));
  }
  for (int begin = -kWarmUp; begin < options.ticks; begin += kChunk) {
    for (Course& course : courses) {
      for (int i = begin; i < std::min(begin + kChunk, options.ticks); ++i) step(pair, i, course);
    }
  }
  const Course& sensation = course_named(courses, Renderer::kSensation);
  const Course& exact = course_named(courses, Renderer::kLocalized);
  const Course& triangle = course_named(courses, Renderer::kDirect6);
  for (const Course& course : courses) {
    const std::string prefix = course.name + ", ";
    const bool is_judged = &course == &sensation && triangles >= kJudged;
    add_times(rows, prefix + "contact_step CPU", course.times, goal_if(is_judged, kGoalStep));
    rows.add(prefix + "answers cut short", course.n_cut);
    if (row_of(course.renderer).moves != Moves::kSoftBody) continue;
    rows.add({{prefix + "force, rms", rms_of(course.forces), "N"},
              {prefix + "error of the force, rms, of that of localized (every piece)",
               rms_of(course.forces, &exact.forces) / rms_of(exact.forces), "",
               at_most(goal_if(is_judged, kGoalError))},
              {prefix + "error of the force, rms, of that of direct6 (every triangle)",
               rms_of(course.forces, &triangle.forces) / rms_of(triangle.forces)}});
  }
  const bool is_judged = triangles >= kJudged;
  rows.add({{"localized (every piece) over sensation, mean CPU",
             mean_of(exact.times) / mean_of(sensation.times), "",
             at_least(goal_if(is_judged, kGoalFaster))},
            {"direct6 (every triangle) over sensation, mean CPU",
             mean_of(triangle.times) / mean_of(sensation.times)}});
}

void run(const Options& options, const Rows& all) {
  Rows rows = all.machine("contact levels of detail");
  rows.add("threshold of sensation", options.threshold, "m");
  for (const std::string& name : options.pairs) {
    LodPair pair = make_lod_pair(name);
    pair.config.pieces.threshold = options.threshold;
    run_pair(pair, bake_session(pair.config), options, all);
  }
}

}  // namespace

/// Contact levels of detail: whole contact steps of voxel, sensation, localized, direct6 and
/// god-object6 on the same poses of pairs in contact over much of their surface, in turns, with the
/// force of each and its error against the exact queries (every piece, every triangle).
Measured bench_lod(Command& command) {
  const auto options = std::make_shared<Options>();
  command.option("--pair PAIR", options->pairs, "bolt, teeth or joint; several may be given")
      .one_of(kLodPairs);
  add_counts(command, {{"--ticks", &options->ticks, "of 1 ms, for each pair", 1, 1'000'000}});
  command.quantity("--threshold", options->threshold, Dimension::kLength, {0, 10e-3},
                   "haptic error beyond which sensation refines", "m");
  return measured(run, options);
}

}  // namespace haptic
