// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "contact/step.h"
#include "device-io/device.h"
#include "proto/config/config.h"
#include "servo/step.h"
#include "sim/step.h"

namespace haptic {

/// Timing that a real session leaves to the machine, fixed here, of one hand.
struct LockstepOptions {
  uint32_t contact_period = 1;   // servo ticks between two contact steps
  uint32_t contact_latency = 1;  // ticks until an answer is visible; 0: within the same tick
  uint32_t scene_latency = 0;    // ticks until a scene is visible
  uint32_t frame_latency = 0;    // ticks until sim has a frame of the servo
  // servo and contact place bodies by their twists alone, as if they did not know what is pushed
  bool without_counters = false;
};

/// A hand of a lockstep session. Its config is with_tools, and its shapes hold theirs, where the
/// tools of the others are objects for it. Device and shapes must outlive the session.
struct LockstepHand {
  const SessionConfig& config;
  const ContactShapes& shapes;
  Device& device;
  LockstepOptions options = {};
};

/// All steps in one process on virtual time, bit-identical on every run. Used by offline evaluation
/// and by the tests. The grid is the first hand's; the others tick at their own rates, spread over
/// its period as hapticd spreads them.
class Lockstep {
 public:
  Lockstep(const SessionConfig& config, const ContactShapes& shapes, Device& device,
           const LockstepOptions& options = {});
  /// Makes a session of several hands, by number.
  explicit Lockstep(std::span<const LockstepHand> hands);

  /// Sim makes no scenes from here on, as after SIGSTOP or kill -9. It goes on with what it knew,
  /// or begins anew from the last scene that was published; then the servos see its scenes after so
  /// many ticks more, as while they map a new segment.
  void stop_sim() { has_sim_ = false; }
  void continue_sim() { has_sim_ = true; }
  void restart_sim(uint64_t mapped_after = 0);
  /// Contact answers nothing from here on, until it goes on with what it knew or begins anew.
  void stop_contact(uint32_t hand = kFirstHand) { hands_[hand].has_contact = false; }
  void continue_contact(uint32_t hand = kFirstHand) { hands_[hand].has_contact = true; }
  void restart_contact(uint32_t hand = kFirstHand);
  /// The servo of a hand ticks no more, as after kill -9, until it begins anew.
  void stop_servo(uint32_t hand) { hands_[hand].has_servo = false; }
  void restart_servo(uint32_t hand = kFirstHand);

  /// A frame of a client, which the next step of sim takes or refuses.
  void give(uint32_t client, const GivenFrame& given);
  /// The client leaves; it comes again with its next frame.
  void leave(uint32_t client);

  /// One tick of the first hand, and what the others have until then. False once the recording of a
  /// device has ended; that tick produces no frame.
  bool step();
  /// The first hand's servo misses a tick: its device holds its force, hand and sim go on.
  void miss_tick();

  /// The instant of the next tick.
  int64_t next_t_ns() const { return time_of(hands_.front()); }

  const ServoFrame& frame(uint32_t hand = kFirstHand) const { return hands_[hand].frame; }
  /// The set used by the last tick, or null.
  const ContactSet* contacts(uint32_t hand = kFirstHand) const {
    return hands_[hand].visible.get();
  }
  /// The scene used by the last tick.
  const SceneFrame& scene(uint32_t hand = kFirstHand) const { return *hands_[hand].scene; }
  /// The desired state, as hapticd would publish it before the next tick.
  ControlFrame& control(uint32_t hand = kFirstHand) { return hands_[hand].control; }

  /// FNV-1a over what every tick so far has come to (poses, velocities, wrenches, flags): equal for
  /// equal runs, of two builds too.
  uint64_t hash() const { return hash_; }

 private:
  using Scene = std::shared_ptr<const SceneFrame>;
  struct Answer {
    uint64_t visible_at;
    std::unique_ptr<ContactSet> set;
  };
  struct MadeScene {
    uint64_t visible_at;
    Scene scene;
  };
  /// A servo and its contact.
  struct OneHand {
    explicit OneHand(const LockstepHand& hand);

    SessionConfig config;
    LockstepOptions options;
    Device* device;
    ServoModel servo_model;
    ServoState servo_state;
    ContactModel contact_model;
    std::unique_ptr<ContactState> contact_state;
    ControlFrame control{};
    std::deque<MadeScene> scenes;
    Scene scene;
    std::deque<Answer> pending;
    std::unique_ptr<ContactSet> visible;
    ServoFrame frame{};
    std::deque<ServoFrame> past;  // its frames, as far back as anybody is behind; the newest last
    SceneFrame seen;              // the scene as it sees it beside other hands
    uint64_t tick = 0;
    uint64_t scene_mapped_at = 0;  // the tick
    bool has_contact = true, has_servo = true;
    uint64_t contact_generation = 0;
  };

  static int64_t time_of(const OneHand& hand);
  static const ServoFrame* frame_behind(const OneHand& hand, uint64_t ticks);
  const SceneFrame* seen_scene(OneHand& hand, ToolStiffnesses& stiffnesses) const;
  void move_scene(int64_t t_ns);
  void move_scene_until(int64_t t_ns);
  bool tick(OneHand& hand, int64_t t_ns);
  void miss(OneHand& hand, int64_t t_ns);
  void let_go(OneHand& hand, int64_t t_ns);
  bool tick_others_until(int64_t t_ns);

  std::vector<OneHand> hands_;
  uint64_t farthest_behind_ = 0;  // [ticks], of a frame that somebody uses
  SimModel sim_model_;
  SimState sim_state_;
  Scene last_scene_;
  uint64_t sim_ticks_ = 0;
  bool has_sim_ = true;
  uint64_t hash_ = 14695981039346656037ull;
};

}  // namespace haptic
