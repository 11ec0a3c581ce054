// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/artefacts.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/options.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/scripted_hand.h"
#include "clients/lockstep/lockstep.h"
#include "clients/report/plot_svg.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kSettled = 0.1;  // [s]; approach from above before measuring
constexpr double kAgrees = 0.03;  // relative to the closed form; one tick of motion

struct Script {
  Soup soup;
  double stiffness;
  double seconds;
  std::function<Vec3(double)> path;
};

/// The centre of a sphere is a radius above the contact.
Script script_of(ArtefactScene scene, double radius) {
  if (scene == ArtefactScene::kEdge) {
    // faces z = 50 mm and x = 50 mm; half way along, both are kEdgeDepth away
    return {make_box({0.1, 0.1, 0.1}), kEdgeStiffness, 0.6, [=](double t) {
              const double above = radius + 0.1 * std::max(0.0, kSettled - t);
              const double x = 0.0475 + 2e-3 * std::max(0.0, t - kSettled);
              return Vec3{x, 3e-3, 0.05 - kEdgeDepth + above};
            }};
  }
  const double top = 0.5 * kPlateWidth + radius;
  return {make_box({0.2, 0.2, kPlateWidth}), kPlateStiffness, kSettled + 0.2, [=](double t) {
            const double down = 0.04 * std::max(0.0, t - kSettled);
            return Vec3{1e-3, 2e-3, top - std::min(down, kPlateEnd)};
          }};
}

double share_off(double value, double exact) {
  return std::fabs(value / exact - 1);
}

void judge_edge(const ArtefactRun& run, bool is_penalty, Rows& rows) {
  const double turn = std::sqrt(2.0) * kEdgeStiffness * kEdgeDepth;
  if (is_penalty) {
    rows.add("edge of a block: largest step of the force in a tick", run.largest_step(), "N",
             given(turn, share_off(run.largest_step(), turn) <= kAgrees));
  } else {
    const double beyond = run.largest_step(kEdgeStiffness);
    rows.add({{"edge of a block: largest step of the force in a tick", run.largest_step(), "N"},
              {"edge of a block: step beyond stiffness times motion", beyond, "N", at_most(1e-9)}});
  }
}

void judge_plate(const ArtefactRun& run, bool is_penalty, Rows& rows) {
  const double half = 0.5 * kPlateStiffness * kPlateWidth, whole = kPlateStiffness * kPlateEnd;
  const double resists = run.most_along({0, 0, 1}), helps = run.most_along({0, 0, -1});
  const double at_end = run.force_W.back().z;
  const double wanted = is_penalty ? half : whole;
  rows.add(
      {{"thin plate: resists at most", resists, "N",
        given(wanted, share_off(resists, wanted) <= kAgrees)},
       {"thin plate: helps the tool through by", helps, "N",
        given(is_penalty ? half : 0, is_penalty ? share_off(helps, half) <= kAgrees : helps == 0)},
       {"thin plate: force with the tool 2 mm behind it", at_end, "N",
        given(is_penalty ? 0 : whole,
              is_penalty ? at_end == 0 : share_off(at_end, whole) <= kAgrees)}});
}

Series force_along(const std::string& name, const ArtefactRun& run) {
  Series series{name, run.t, {}};
  for (const Vec3& f : run.force_W) series.y.push_back(f.z);
  return series;
}

}  // namespace

double ArtefactRun::largest_step(double stiffness) const {
  double largest = 0;
  for (size_t i = 1; i < force_W.size(); ++i) {
    const double allowed = stiffness * norm(tool_W[i] - tool_W[i - 1]);
    largest = std::max(largest, norm(force_W[i] - force_W[i - 1]) - allowed);
  }
  return largest;
}

double ArtefactRun::most_along(const Vec3& direction) const {
  double most = 0;
  for (const Vec3& f : force_W) most = std::max(most, dot(f, direction));
  return most;
}

ArtefactRun run_artefact(ArtefactScene scene, Renderer renderer) {
  SessionConfig config = plain_session(0);
  config.renderer = renderer;
  const double radius = renderer == Renderer::kVirtualProxy3 ? config.proxy_radius : 0;
  Script script = script_of(scene, radius);
  config.coupling.translational_stiffness = script.stiffness;
  const MeshShapeData mesh = build_shape(std::move(script.soup));
  const MeshShape shape = mesh.view();
  ScriptedHand hand(script.path);
  Lockstep lockstep(config, std::span(&shape, 1), hand, {1, 0});
  ArtefactRun run;
  for (double t = 0; t < script.seconds && lockstep.step(); t += 1e-3) {
    if (t < kSettled + 0.01) continue;
    const ServoFrame& frame = lockstep.frame();
    run.t.push_back(t - kSettled);
    run.tool_W.push_back(frame.X_WT.p);
    run.force_W.push_back(frame.F_coupling_W.f);
  }
  return run;
}

void eval_artefacts(const std::string& plot, const Rows& all) {
  all.machine("artefacts of penalty3");
  Panel edge{"edge of a block: force upwards", "N", {}},
      plate{"thin plate: force upwards", "N", {}};
  for (const RendererRow& row : kRenderers) {
    if (is_of_body(row.id)) continue;  // the scenes are for a point
    const std::string name(row.name);
    Rows rows = all.of(name);
    const bool is_penalty = row.id == Renderer::kPenalty3;
    const ArtefactRun on_edge = run_artefact(ArtefactScene::kEdge, row.id);
    const ArtefactRun on_plate = run_artefact(ArtefactScene::kPlate, row.id);
    rows.note("renderer", name);
    judge_edge(on_edge, is_penalty, rows);
    judge_plate(on_plate, is_penalty, rows);
    edge.series.push_back(force_along(name, on_edge));
    plate.series.push_back(force_along(name, on_plate));
  }
  if (!plot.empty()) write_svg(plot, "the artefacts of the penalty method", {edge, plate});
}

Measured suite_artefacts(Command& command) {
  struct Options {
    std::string plot;
    bool overwrite = false;
  };
  const auto options = std::make_shared<Options>();
  add_plot(command, options->plot, "draw the forces into this file");
  add_overwrite(command, options->overwrite);
  return [options](Report& report) {
    check_outputs({options->plot}, {}, options->overwrite);
    eval_artefacts(options->plot, report.rows);
  };
}

}  // namespace haptic
