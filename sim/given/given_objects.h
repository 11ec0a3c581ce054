// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/config/config.h"
#include "proto/wire/age.h"
#include "proto/wire/wire.h"
#include "sim/given/local_model.h"
#include "sim/given/power_window.h"
#include "sim/given/push_history.h"
#include "sim/hand_pushes.h"

/// Objects that clients move. A client integrates its object at its own rate, and its frames come
/// late; the hand presses on a model of it that is stepped here, and the frames correct the model.
///
///   inputs   of each frame of the client: pose X_f, twist V_f and own acceleration a at t_f; the
///            object's mobility M⁻¹, stiffness K and damping D; the tick whose counters J and S
///            (servo/pushes.h) it has used; the counters of every tick since
///   model    V̇ = a − M⁻¹ [D (V − V_f) + K (X ⊖ X_f)], and V grows by M⁻¹ ΔJ at each tick
///   loop     each step of sim: push the model with what the hand has pushed since the last, let it
///            drift to the step's instant
///   frame    replay: from (X_f, V_f) at t_f, with every push after the client's tick, to now; then
///            take over a tenth of the gap between the model and that (all of it where the object
///            does not answer a push). What is shown goes over to the corrected model within a
///            period of the client
///   bound    with right M, K, D and a rate of 30 Hz or more the loop through the client adds less
///            than 0.1 N at 3000 N/m (docs/clients-that-give.md); elsewhere EnergyWatch softens
namespace haptic {

/// A client as the session file has it.
struct GivenClient {
  double max_force = 0, max_power = 0;
  std::vector<uint32_t> objects;  // places in GivenModel::objects
};

/// An object that a client moves; constant after start.
struct GivenObject {
  uint32_t object = 0;  // in the scene
  uint32_t client = 0;
  Pose X_WO;            // where it is before a client moves it
};

struct GivenModel {
  std::vector<GivenObject> objects;  // by response, behind those of the bodies
  std::vector<GivenClient> clients;
  uint32_t first_response = 0;
  double period = 0;  // of the frames of sim [s]
};
GivenModel build_given(const SessionConfig& config, uint32_t first_response);

/// Who moves an object.
enum class GivenPhase : uint32_t {
  kStands,  // nobody: it stands where the session file says, and is felt
  kLetGo,   // a client has come: it fades, and still stands
  kFollows  // the client
};

struct GivenObjectState {
  GivenPhase phase = GivenPhase::kStands;
  GivenMotion said{};  // the newest statement that was taken
  bool is_said = false;
  bool is_new = false;  // the model has not taken it over yet
  ModelState at;        // the model
  StateGap gap;         // shown − model at the last frame, which is shown less and less
  int64_t gap_ns = 0;   // since when
  double share = 1;     // of the coupling that is let in
};

struct GivenClientState {
  Age age;
  uint64_t generation = 0;  // of its segment
  uint64_t last_seq = 0, taken_seq = 0, refused = 0;
  int64_t taken_ns = 0;  // GivenFrame::t_ns of the last that was taken
  GiverRefusal refusal = GiverRefusal::kNone;
  bool is_attached = false;
  PowerWindow power;
  int64_t cut_until_ns = 0;
};

struct GivenState {
  std::vector<GivenObjectState> objects;
  std::vector<GivenClientState> clients;
  std::vector<PushHistory> histories;  // by hand
  std::array<SeenCounters, kMostHands> seen{};
  int64_t t_ns = 0;   // of the last step; 0: there was none
  size_t turn = 0;    // the object whose statement is looked at first in the next step
};

/// Allocates all that the state needs; the objects stand at the poses of the session file.
GivenState begin_given(const GivenModel& model, uint32_t n_hands);

/// Puts the objects where the last frame of a sim that is gone has them. What followed a client is
/// not felt until that client is heard again.
void resume_given(const GivenModel& model, GivenState& state, const SceneFrame& last);

/// A frame of a hand's servo: each once, in order.
void see_hand(const GivenModel& model, GivenState& state, uint32_t hand, const ServoFrame& frame);

/// The newest frame of a client, of the segment with that generation; t_ns: now. What it says of an
/// object is taken or refused.
void see_client(const GivenModel& model, GivenState& state, uint32_t client, uint64_t generation,
                const GivenFrame& given, int64_t t_ns);

/// Moves the objects to the frame's instant and puts them into `frame`, which has all other objects.
/// Allocates nothing.
void step_given(const GivenModel& model, GivenState& state,
                std::span<const ServoFrame* const> hands, SceneFrame& frame);

/// Adds how they answer pushes, behind the responses of the bodies, and what has been taken of the
/// clients.
void note_given(const GivenModel& model, const GivenState& state, SceneFrame& frame);

}  // namespace haptic
