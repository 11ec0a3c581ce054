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

/// What survives a step. Phase of object i: first_phase[i] + 2π·frequency·scene_ns. The scene clock
/// is an integer, so nothing drifts however long it runs, and stands still while no sim runs.
struct SimState {
  uint64_t seq = 0;      // of the last frame; the first is 1
  int64_t t_ns = 0;      // of the last frame
  int64_t scene_ns = 0;  // scene time since start or resumption
  bool started = false;
  bool resumed = false;  // t_ns is that of a frame of the previous sim
  std::array<double, kMaxObjects> first_phase{};
};

SimModel build_sim(const SessionConfig& config);

/// Scene at t_ns, poses and twists exact; busy_ns is the shell's to fill in. The first step of a
/// new scene shows the configured poses. Scene time advances by time_scale (≥ 0) times the time
/// since the last step, and twists are scaled with it; t_ns before the last step repeats that
/// instant.
SceneFrame sim_step(const SimModel& model, SimState& state, int64_t t_ns, double time_scale = 1);

/// Continues after a restart: seq follows last.seq and the phases are read from last's poses and
/// twists. The first step advances by the time since `last`, at most kMaxExtrapolation
/// (proto/wire/scene_pose.h): that is where the readers' extrapolation left the objects, so that no
/// outage, however long, makes them jump. Call before the first step.
void resume(const SimModel& model, SimState& state, const SceneFrame& last);

}  // namespace haptic
