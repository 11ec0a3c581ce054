// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/mesh/renderer.h"

#include <memory>

#include "clients/lab/eval/mesh/friction.h"
#include "clients/lab/eval/oracle/oracle.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/offline_session.h"
#include "clients/lab/support/scripted_hand.h"
#include "clients/report/plot_svg.h"
#include "proto/config/devices.h"
#include "proto/os/progress.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kLockstepError = 1e-6;  // answered within the tick [N]
constexpr double kLateError = 0.02;      // rms, answered one tick late [N]
constexpr double kFlatRipple = 1e-5;     // on the plane [N]
constexpr double kNearby = 2e-3;         // a verified proxy is never farther from the surface [m]

/// The mesh, ready for queries, and the owners of its data.
struct Subject {
  MeshShapeData made;
  BakedShape baked;
  MeshShape shape;
  ToolPath path;
  bool closed_work = false;  // a benchmark mesh with a closed formula: all goals apply
};

/// 0 (a point) for every renderer except virtual-proxy3.
double radius_of(const RendererEval& eval) {
  return eval.renderer == Renderer::kVirtualProxy3 ? eval.radius : 0;
}

std::string case_name(const RendererEval& eval) {
  std::string text = std::string(row_of(eval.renderer).name) + " on " + eval.mesh;
  if (eval.renderer == Renderer::kVirtualProxy3)
    text += ", radius " + readable(radius_of(eval), "m");
  if (eval.lockstep.contact_latency > 0) {
    text += ", " + std::to_string(eval.lockstep.contact_latency) + " late";
  }
  return text;
}

Subject open_subject(const RendererEval& eval) {
  Subject subject;
  if (is_eval_work(eval.mesh)) {
    EvalWork work = make_eval_work(eval.mesh, radius_of(eval));
    subject.made = build_shape(std::move(work.soup));
    subject.shape = subject.made.view();
    subject.path = std::move(work.path);
    subject.closed_work = true;
    return subject;
  }
  subject.baked = bake_scan(eval.mesh, eval.size);
  subject.shape = subject.baked.shape;
  if (eval.trace.empty()) subject.path = way_around(subject.shape, radius_of(eval), eval.ticks);
  return subject;
}

/// Why there is no exact answer to compare with; empty if there is one.
std::string why_no_answer(const Subject& subject, const EvalJudge& judge) {
  const BakeReport& report = subject.baked.report;
  if (subject.shape.mesh.closed && report.self_intersections > 0) {
    return "the closed mesh cuts itself: what is inside is not defined; cut it apart";
  }
  if (judge.began_overlapping()) {
    return "the tool overlaps the mesh where it starts; make it smaller or begin further out";
  }
  return "";
}

EvalGoals goals_of(const RendererEval& eval, const Subject& subject, bool has_answer) {
  EvalGoals goals;
  goals.force_limit = eval.max_force;
  goals.follows_oracle = false;
  if (!has_answer) return goals;
  // on an open mesh the god-object is not uniquely defined
  goals.follows_oracle = (subject.closed_work || subject.shape.mesh.closed) &&
                         eval.renderer != Renderer::kPenalty3 && eval.friction == 0;
  if (!goals.follows_oracle || eval.lockstep.contact_period != 1) return goals;
  goals.rests = eval.lockstep.contact_latency == 0;
  // a scan may have several rest positions, and two exact paths can lead to different ones
  if (!subject.closed_work) return goals;
  if (eval.lockstep.contact_latency == 0) goals.max_force_error = kLockstepError;
  if (eval.lockstep.contact_latency == 1) goals.rms_force_error = kLateError;
  if (eval.mesh.rfind("flat:", 0) == 0) goals.max_ripple = kFlatRipple;
  return goals;
}

/// True if a tool at p_O overlaps a closed mesh, by every facet.
bool overlaps(const FacetBins& facets, const Vec3& p_O, double radius) {
  const TriangleMesh& mesh = facets.mesh();
  const double far = norm(mesh.upper - mesh.lower);
  return mesh.closed && behind_surface(facets, p_O, radius, far).depth > 0;
}

void plot_judged(const std::string& path, const std::string& title, const EvalJudge& judge) {
  const EvalJudge::Trace& trace = judge.trace();
  write_svg(path, title,
            {{"force", "N", {{"rendered", trace.t, trace.force}, {"oracle", trace.t, trace.exact}}},
             {"force error", "N", {{"|F − F*|", trace.t, trace.error}}},
             {"ripple", "N", {{"|ΔF − ΔF*|", trace.t, trace.ripple}}}});
}

}  // namespace

EvalJudge judge_run(const SessionConfig& config, const MeshShape& shape, Device& hand,
                    const LockstepOptions& options, uint64_t ticks,
                    const std::function<void(const ServoFrame&)>& watch, const std::string& name) {
  const std::span<const MeshShape> shapes(&shape, 1);
  Lockstep lockstep(config, shapes, hand, options);
  const FacetBins facets(shape.mesh);
  const double radius = config.renderer == Renderer::kVirtualProxy3 ? config.proxy_radius : 0;
  const std::unique_ptr<ProxyOracle> oracle = make_oracle(facets, radius);
  EvalJudge judge(config.coupling.translational_stiffness);
  Progress progress(name, static_cast<double>(ticks));
  for (uint64_t k = 0; k < ticks && lockstep.step(); ++k) {
    progress.at(static_cast<double>(k));
    const ServoFrame& frame = lockstep.frame();
    const ContactSet* const set = lockstep.contacts();
    const Vec3& tool = frame.X_WT.p;
    if (k == 0) {
      judge.begin(overlaps(facets, tool, radius));
      oracle->seed(tool);
    }
    const OracleAnswer truth = oracle->follow(tool);
    // on a broken mesh the oracle may be trapped: it restarts from the servo's proxy
    if (!truth.converged) oracle->seed(frame.X_WP.p);
    JudgedPlace place;
    if (set != nullptr && norm(frame.X_WG.p - truth.proxy_O) < kNearby) {
      place.behind = behind_surface(facets, frame.X_WG.p, radius, kNearby);
    }
    place.descent = free_descent(facets, frame.X_WP.p, tool, radius);
    if (watch) watch(frame);
    judge.add(frame, set != nullptr ? set->flags : 0, truth, place);
  }
  return judge;
}

void eval_renderer(const RendererEval& eval, const Rows& all) {
  const Subject subject = open_subject(eval);
  SessionConfig config = plain_session(eval.stiffness);
  config.renderer = eval.renderer;
  config.proxy_radius = eval.radius;
  config.objects[0].material.friction_static = eval.friction;
  config.objects[0].material.friction_dynamic = eval.friction;
  config.safety.max_force = eval.max_force;
  std::unique_ptr<Device> hand;
  uint64_t ticks = eval.ticks;
  if (eval.trace.empty()) {
    hand = std::make_unique<ScriptedHand>(subject.path);
  } else {
    use_trace(config, eval.trace);
    hand = open_device(config.device);
    ticks = ~uint64_t{0};
  }
  // the normal of a plane is known, which separates normal and tangential force
  const bool is_flat = eval.mesh.rfind("flat:", 0) == 0;
  FrictionJudge friction(eval.friction, {0, 0, 1});
  const EvalJudge judge = judge_run(
      config, subject.shape, *hand, eval.lockstep, ticks,
      [&](const ServoFrame& frame) { friction.add(frame); }, eval.progress);
  const std::string name = case_name(eval);
  Rows rows = all.machine(name);
  rows.note("lockstep", pace_of(eval.lockstep));
  for (const std::string& line : subject.baked.report.lines) rows.note("mesh", line);
  rows.add("triangles", subject.shape.mesh.triangles.size());
  const std::string why = why_no_answer(subject, judge);
  if (!why.empty()) rows.note(kNoAnswer, why);
  judge.add_rows(name, goals_of(eval, subject, why.empty()), all);
  if (is_flat && eval.friction > 0) friction.add_rows(name, all);
  if (!eval.plot.empty()) plot_judged(eval.plot, name, judge);
}

}  // namespace haptic
