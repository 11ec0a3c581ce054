// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "clients/lab/eval/mesh/judge.h"
#include "clients/lab/eval/scenes/scan_work.h"
#include "clients/lockstep/lockstep.h"

namespace haptic {

/// A renderer under test: its mesh, its hand and its parameters.
struct RendererEval {
  Renderer renderer{};
  std::string mesh;                // "hf:742", "sphere:235", "flat:50", or a mesh file
  std::string trace;               // a recorded hand instead of the mesh's own path
  std::string plot;                // .svg
  std::string progress = "eval";   // begins the line of progress
  double size = 0.15;              // longest side of a mesh file [m]
  double radius = 1e-3;            // proxy of virtual-proxy3 [m]
  double friction = 0;             // μ of virtual-proxy3, static and dynamic
  double stiffness = 1000;         // [N/m]
  double max_force = 1e3;          // the device's limit [N]
  uint64_t ticks = kEvalTicks;     // duration of a path; a recording is played to its end
  LockstepOptions lockstep{1, 0};  // contact in every tick, answered within it
};

/// Runs hand, contact and servo in lockstep for `ticks` ticks or to the end of a recording, and
/// compares each tick with the oracle of the renderer's proxy: the sphere for virtual-proxy3 with a
/// radius, else the god-object (penalty3 has no proxy of its own). The object lies at the origin.
/// `watch` is called with every frame; `name` begins the line of progress.
EvalJudge judge_run(const SessionConfig& config, const MeshShape& shape, Device& hand,
                    const LockstepOptions& lockstep, uint64_t ticks,
                    const std::function<void(const ServoFrame&)>& watch = {},
                    const std::string& name = "eval");

/// Name of the note that says why a run has no exact answer.
inline constexpr const char* kNoAnswer = "no answer";

/// `hapt eval mesh`: figures, goals, plot. There is no exact answer for a closed mesh that
/// intersects itself or a tool that overlaps one at the start: a note kNoAnswer says so, and only
/// NaN and the force limit have goals. Throws std::runtime_error with one line if a file cannot be
/// read.
void eval_renderer(const RendererEval& eval, const Rows& all);

}  // namespace haptic
