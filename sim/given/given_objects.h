// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "proto/config/config.h"
#include "proto/wire/heard_client.h"
#include "proto/wire/power_window.h"
#include "proto/wire/wire.h"
#include "sim/given/guarded_model.h"
#include "sim/given/local_model.h"
#include "sim/pushes/hand_pushes.h"
#include "sim/pushes/push_history.h"

/// Objects that clients move. A client integrates its object at its own rate, and its frames come
/// late; the hand presses on a model of it that is stepped here, and the frames correct the model.
///
///   inputs   of each frame of the client: pose X_f, twist V_f and own acceleration a at t_f; the
///            object's mobility M⁻¹, stiffness K and damping D; the tick whose counters J and S
///            (servo/pushes.h) it has used; the counters of every tick since
///   model    V̇ = a − M⁻¹ [D (V − V_f) + K (X ⊖ X_f)], and V grows by M⁻¹ ΔJ at each tick
///   loop     each step of sim: push the model with what the hand has pushed since the last, let it
///            drift to the step's instant
///   frame    replay: from (X_f, V_f) at t_f, with every push after the client's tick, to now; the
///            model then follows by a tenth of the gap, over a period of the client, as far as its
///            purse pays (guarded_model.h). An object that does not answer a push closes no loop:
///            it follows by all of the gap
///   bound    with right M, K, D the loop through the client is stable at any stiffness up to
///            5000 N/m from 30 Hz on (tests/sim/given/lifted_loop_test.cpp); wrong ones give the
///            hand no more than a purse
namespace haptic {

struct GivenClient {
  ClientConfig config;
  std::vector<uint32_t> objects;  // places in GivenModel::objects
};

/// An object that a client moves; constant after start.
struct GivenObject {
  uint32_t object = 0;  // in the scene
  uint32_t client = 0;
  Pose X_WO;  // where it is before a client moves it
};

struct GivenModel {
  std::vector<GivenObject> objects;  // by response, behind those of the bodies
  std::vector<GivenClient> clients;
  uint32_t first_response = 0;
  double period = 0;  // of the frames of sim [s]
  double reach = 0;   // of an object from its place in the session file [m]
};
GivenModel build_given(const SessionConfig& config, uint32_t first_response);

/// Who moves an object.
enum class GivenPhase : uint32_t {
  kStands,  // nobody: it stands where the session file says, and is felt
  kLetGo,   // another client has come: it fades, and stands
  kFollows  // the client
};

/// An object that follows its client and answers no push: what is shown goes over to each frame
/// within a period of the client.
class FollowingModel {
 public:
  const GivenMotion& said() const { return said_; }
  ModelState shown() const;
  void place(const ModelState& at, const GivenMotion& said);
  void correct(const ModelState& replayed, const GivenMotion& said, int64_t period_ns);
  void step(double dt);
  void stop() { at_.V_WO = {}; }
  Twist acceleration() const { return own_acceleration(said_, at_); }

 private:
  GivenMotion said_{};
  ModelState at_;
  StateGap gap_;           // shown − at, of the last frame
  double since_ = 0;       // that frame [s]
  double period_ = 10e-3;  // [s]
};

struct GivenObjectState {
  GivenPhase phase = GivenPhase::kStands;
  GivenMotion said{};  // the newest statement that was taken
  bool is_said = false;
  bool is_new = false;     // the model has not taken it over yet
  bool is_placed = false;  // the model is where a client had it, since it was last let go
  std::variant<FollowingModel, GuardedModel> model;
  double share = 1;      // of the coupling that is let in
  double work = 0;       // of the hands on it since the last step [J]
  ObjectPush by_bodies;  // what sim's bodies have pushed it with, until the last step
};

struct GivenClientState {
  HeardClient heard;
  double weight = 0;  // of what it gives, in the last step
  PowerWindow power;  // of the name, whoever bears it
  int64_t cut_until_ns = 0;
};

/// What is known of a hand between its frames.
struct SeenHand {
  Pose X_WT;             // in the newest frame
  double depth = 0;      // [m]
  double stiffness = 0;  // of its coupling [N/m]
};

struct GivenState {
  std::vector<GivenObjectState> objects;
  std::array<SeenHand, kMostHands> hands{};
  std::vector<GivenClientState> clients;
  std::vector<PushHistory> histories;  // by hand
  std::array<SeenCounters, kMostHands> seen{};
  int64_t t_ns = 0;  // of the last step; 0: there was none
  size_t turn = 0;   // the object whose statement is looked at first in the next step
};

/// Allocates all that the state needs; the objects stand at the poses of the session file.
GivenState begin_given(const GivenModel& model, uint32_t n_hands);

/// Puts the objects where the last frame of a sim that is gone has them. What followed a client is
/// not felt until that client is heard again.
void resume_given(const GivenModel& model, GivenState& state, const SceneFrame& last);

/// A frame of a hand's servo: each once, in order.
void see_hand(const GivenModel& model, GivenState& state, uint32_t hand, const ServoFrame& frame);

/// Which segment of a client counts; 0: nobody gives under its name.
void set_giving(const GivenModel& model, GivenState& state, uint32_t client, uint64_t generation);

/// The newest frame of a client, of the segment with that generation; t_ns: now. What it says of an
/// object is taken or refused.
void see_client(const GivenModel& model, GivenState& state, uint32_t client, uint64_t generation,
                const GivenFrame& given, int64_t t_ns);

/// Moves the objects to the frame's instant and puts them into `frame`, which has all other
/// objects. Allocates nothing.
void step_given(const GivenModel& model, GivenState& state,
                std::span<const ServoFrame* const> hands, SceneFrame& frame);

/// What sim's bodies have pushed an object with in the step to t_ns.
void push_by_bodies(GivenState& state, size_t k, const Wrench& impulse_W, double dt);

/// Adds how they answer pushes, behind the responses of the bodies, and what has been taken of the
/// clients.
void note_given(const GivenModel& model, const GivenState& state, SceneFrame& frame);

}  // namespace haptic
