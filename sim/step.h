// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "proto/config/config.h"
#include "proto/wire/wire.h"
#include "sim/bodies.h"
#include "sim/given/given_objects.h"

namespace haptic {

/// The scene as configured; constant after start.
struct SimModel {
  uint32_t n_objects = 0, n_hands = 1;
  std::array<ObjectConfig, kMaxObjects> objects{};
  BodiesModel bodies;
  GivenModel given;

  /// Something can be pushed, so sim belongs to the hand's loop.
  bool moves_by_pushes() const { return !bodies.with_mass.empty() || !given.objects.empty(); }
};

/// What persists from step to step; it can be moved, not copied. Phase of object i: first_phase[i]
/// + 2π·frequency·scene_ns. The scene clock is an integer, so it never drifts; it stands still
/// while no sim runs.
struct SimState {
  SimState() = default;
  explicit SimState(const SimModel& model) : given(begin_given(model.given, model.n_hands)) {}

  uint64_t seq = 0;      // of the last frame; the first is 1
  int64_t t_ns = 0;      // of the last frame
  int64_t scene_ns = 0;  // since start or resumption
  bool started = false;
  bool resumed = false;  // t_ns is that of the previous sim's last frame
  std::array<double, kMaxObjects> first_phase{};
  BodiesState bodies;
  GivenState given;
};

/// `shapes` and `pieces`: as contact has baked them, in the order of the config, where an object
/// has mass; they must outlive the model. Throws std::invalid_argument as build_bodies.
SimModel build_sim(const SessionConfig& config, std::span<const MeshShape> shapes = {},
                   std::span<const PieceTree> pieces = {});

/// Scene at t_ns; the caller fills in busy_ns. Scripted objects have exact poses and twists, and
/// the first step of a new scene shows the configured poses. Scene time advances by time_scale (≥
/// 0) times the time since the last step, and scripted twists are scaled with it; a t_ns before the
/// last step repeats the last instant. Bodies with mass are moved by what the hands have pushed
/// them with, in real time.
SceneFrame sim_step(const SimModel& model, SimState& state, const HandFrames& hands, int64_t t_ns,
                    double time_scale = 1);
/// Without a hand.
SceneFrame sim_step(const SimModel& model, SimState& state, int64_t t_ns, double time_scale = 1);

/// Continues after a restart: seq follows last.seq, and the phases are derived from last's poses
/// and twists. The first step advances by the time since `last`, at most kExtrapolationNs
/// (proto/wire/scene_pose.h), where the readers' extrapolation stopped, so that no outage makes the
/// objects jump. Bodies go on with the twists of `last`; what hands have pushed them with meanwhile
/// is forgotten. Call before the first step.
void resume(const SimModel& model, SimState& state, const SceneFrame& last);

}  // namespace haptic
