// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <deque>
#include <memory>

#include "contact/step.h"
#include "device-io/device.h"
#include "proto/config/config.h"
#include "servo/step.h"
#include "sim/step.h"

namespace haptic {

/// Timing that a real session leaves to the machine, fixed here.
struct LockstepOptions {
  uint32_t contact_period = 1;   // servo ticks between two contact steps
  uint32_t contact_latency = 1;  // ticks until an answer is visible; 0: within the same tick
  uint32_t scene_latency = 0;    // ticks until a scene is visible
  // servo and contact place bodies by their twists alone, as if they did not know what is pushed
  bool without_counters = false;
};

/// All three steps in one process on virtual time, bit-identical on every run. Used by offline
/// evaluation and by the tests. Device and shapes must outlive it.
class Lockstep {
 public:
  Lockstep(const SessionConfig& config, const ContactShapes& shapes, Device& device,
           const LockstepOptions& options = {});

  /// Sim makes no scenes from here on, as after SIGSTOP or kill -9. It goes on with what it knew,
  /// or begins anew from the last scene that was published; then the servo sees its scenes after so
  /// many ticks more, as while it maps a new segment.
  void stop_sim() { has_sim_ = false; }
  void continue_sim() { has_sim_ = true; }
  void restart_sim(uint64_t mapped_after = 0);
  /// Contact answers nothing from here on, until it goes on with what it knew or begins anew.
  void stop_contact() { has_contact_ = false; }
  void continue_contact() { has_contact_ = true; }
  void restart_contact();
  /// The servo begins anew, as after a restart.
  void restart_servo() { servo_state_ = {}; }

  /// A frame of a client, which the next step of sim takes or refuses.
  void give(uint32_t client, const GivenFrame& given);
  /// The client leaves; it comes again with its next frame.
  void leave(uint32_t client);

  /// One tick. False once the device's recording has ended; that tick produces no frame.
  bool step();
  /// The servo misses a tick: the device holds its force, hand and sim go on.
  void miss_tick();

  /// The instant of the next tick.
  int64_t next_t_ns() const;

  const ServoFrame& frame() const { return frame_; }
  /// The set used by the last tick, or null.
  const ContactSet* contacts() const { return visible_ ? visible_.get() : nullptr; }
  /// The scene used by the last tick.
  const SceneFrame& scene() const { return *scene_; }
  /// The desired state, as hapticd would publish it before the next tick.
  ControlFrame& control() { return control_; }

  /// FNV-1a over what every tick so far has come to (poses, velocities, wrenches, flags): equal for
  /// equal runs, of two builds too.
  uint64_t hash() const { return hash_; }

 private:
  struct Answer {
    uint64_t visible_at;
    std::unique_ptr<ContactSet> set;
  };
  struct MadeScene {
    uint64_t visible_at;
    std::unique_ptr<SceneFrame> scene;
  };
  void move_scene(int64_t t_ns);
  void move_scene_until(int64_t t_ns);
  void answer(const ServoFrame& question, uint64_t visible_at);
  ServoFrame question_of(const DeviceState& device, int64_t t_ns) const;

  SessionConfig config_;
  LockstepOptions options_;
  Device& device_;
  ServoModel servo_model_;
  ServoState servo_state_;
  ContactModel contact_model_;
  std::unique_ptr<ContactState> contact_state_;
  SimModel sim_model_;
  SimState sim_state_;
  ControlFrame control_{};
  std::deque<MadeScene> scenes_;
  std::unique_ptr<SceneFrame> scene_;
  std::deque<Answer> pending_;
  std::unique_ptr<ContactSet> visible_;
  ServoFrame frame_{};
  uint64_t tick_ = 0;
  uint64_t sim_ticks_ = 0;
  uint64_t scene_mapped_at_ = 0;  // the tick
  bool has_sim_ = true, has_contact_ = true;
  uint64_t contact_generation_ = 0;
  uint64_t hash_ = 14695981039346656037ull;
};

}  // namespace haptic
