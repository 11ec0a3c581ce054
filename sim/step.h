// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "proto/config/config.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The scene as configured; constant after start.
struct SimModel {
  uint32_t n_objects = 0;
  std::array<ObjectConfig, kMaxObjects> objects{};
};

/// What persists from step to step. Phase of object i: first_phase[i] + 2π·frequency·scene_ns. The
/// scene clock is an integer, so it never drifts; it stands still while no sim runs.
struct SimState {
  uint64_t seq = 0;      // of the last frame; the first is 1
  int64_t t_ns = 0;      // of the last frame
  int64_t scene_ns = 0;  // since start or resumption
  bool started = false;
  bool resumed = false;  // t_ns is that of the previous sim's last frame
  std::array<double, kMaxObjects> first_phase{};
};

SimModel build_sim(const SessionConfig& config);

/// Scene at t_ns with exact poses and twists; the caller fills in busy_ns. The first step of a new
/// scene shows the configured poses. Scene time advances by time_scale (≥ 0) times the time since
/// the last step, and twists are scaled with it; a t_ns before the last step repeats the last
/// instant.
SceneFrame sim_step(const SimModel& model, SimState& state, int64_t t_ns, double time_scale = 1);

/// Continues after a restart: seq follows last.seq, and the phases are derived from last's poses
/// and twists. The first step advances by the time since `last`, at most kMaxExtrapolation
/// (proto/wire/scene_pose.h), where the readers' extrapolation stopped, so that no outage makes the
/// objects jump. Call before the first step.
void resume(const SimModel& model, SimState& state, const SceneFrame& last);

}  // namespace haptic
