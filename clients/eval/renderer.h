// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "clients/eval/judge.h"
#include "clients/eval/scenes/scan_work.h"
#include "clients/lab/lockstep.h"

namespace haptic {

/// A renderer under judgement: which, on what, led by whom.
struct RendererEval {
  Renderer renderer = Renderer::kGodObject3;
  std::string mesh;                // "hf:742", "sphere:235", "flat:50", or a mesh file
  std::string trace;               // a recorded hand instead of the path that belongs to the mesh
  std::string plot;                // .svg
  double size = 0.15;              // of the longest side of a mesh file [m]
  double radius = 1e-3;            // of the proxy of virtual-proxy3 [m]
  double friction = 0;             // μ of virtual-proxy3, static and dynamic
  double stiffness = 1000;         // [N/m]
  double max_force = 1e3;          // the device's limit [N]
  uint64_t ticks = kEvalTicks;     // of a path; a recording is played to its end
  LockstepOptions lockstep{1, 0};  // contact in every tick, answered within it
};

/// Runs hand, contact and servo in lockstep for so many ticks, or to the end of a recording, and
/// compares each tick with the oracle of the renderer's proxy: the sphere for virtual-proxy3 with a
/// radius, else the god-object (penalty3 has none of its own). The object lies at the origin.
/// `watch` sees every frame too.
EvalJudge judge_run(const SessionConfig& config, const MeshShape& shape, Device& hand,
                    const LockstepOptions& lockstep, uint64_t ticks,
                    const std::function<void(const ServoFrame&)>& watch = {});

/// The fact that says why a run is not scored.
inline constexpr const char* kNoAnswer = "no answer";

/// The whole of `hapt eval --renderer`: figures, goals, plot. A closed mesh that cuts itself and a
/// tool that overlaps one where it starts have no exact answer: the row kNoAnswer says so, and only
/// NaN and the force limit are judged. Throws std::runtime_error with one
/// line for what is not there.
std::vector<Row> eval_renderer(const RendererEval& eval);

}  // namespace haptic
