// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lockstep/lockstep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "proto/config/renderer_needs.h"
#include "proto/ipc/control.h"
#include "proto/wire/mapping.h"
#include "proto/wire/other_tools.h"
#include "proto/wire/packing.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"
#include "servo/lead.h"

namespace haptic {
namespace {

constexpr int64_t kStartNs = 1'000'000'000;  // virtual time of tick 0 [ns]; zero means unset

int64_t grid_time(double rate, uint64_t tick) {
  return kStartNs + std::llround(static_cast<double>(tick) * 1e9 / rate);
}

ActuatorLimits actuators_of(const DeviceCaps& caps) {
  return {caps.max_force, caps.max_torque, caps.causality == Causality::kAdmittance};
}

/// FNV-1a over the bytes of a value.
template <class T>
void add_to_hash(uint64_t& hash, const T& value) {
  unsigned char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  for (const unsigned char b : bytes) hash = (hash ^ b) * 1099511628211ull;
}

/// Hashes the results of a tick field by field, so that neither other fields nor the layout of the
/// frame matter.
void add_frame(uint64_t& hash, const ServoFrame& f) {
  add_to_hash(hash, f.tick);
  for (const Pose& X : {f.X_WT, f.X_WG, f.X_WP}) add_to_hash(hash, X);
  for (const Twist& V : {f.V_WT, f.V_WP}) add_to_hash(hash, V);
  for (const Wrench& F : {f.F_coupling_W, f.F_device_B}) add_to_hash(hash, F);
  add_to_hash(hash, f.held_back_W);
  for (const double value : {f.depth, f.fade}) add_to_hash(hash, value);
  for (const uint32_t value : {f.n_contacts, f.flags, f.fault}) add_to_hash(hash, value);
}

/// The scene alone.
std::unique_ptr<const SessionConfig> without_tools(const SessionConfig& config) {
  auto scene = std::make_unique<SessionConfig>(config);
  scene->n_objects -= scene->n_tools;
  scene->n_tools = 0;
  return scene;
}

ServoFrame question_of(const SessionConfig& config, const ServoState& state, const ServoFrame& last,
                       const ServoInput& input) {
  const DeviceState& device = input.device;
  ServoFrame question{};
  question.tick = input.tick;
  question.t_ns = input.t_ns;
  question.device.buttons = device.buttons;
  question.X_WT = tool_pose(config.map, state.clutch, device.X_BH);
  question.V_WT = tool_twist(config.map, device.X_BH, device.V_BH);
  question.flags = kServoNoContactSet;
  question.renderer = static_cast<uint32_t>(config.renderer);
  question.held_back_W = last.held_back_W;
  // as of the last tick: 0, not known, before the first
  question.translational_stiffness = last.translational_stiffness;
  question.rotational_stiffness = last.rotational_stiffness;
  // a 6-DoF proxy with springs is where the last tick left it, any other at the tool
  question.X_WP = question.X_WT;
  if (input.tick > 0 && is_of_body(config.renderer) && has_springs(config.proxy, config.renderer)) {
    question.X_WP = last.X_WP;
    question.V_WP = last.V_WP;
  }
  return question;
}

}  // namespace

Lockstep::OneHand::OneHand(const LockstepHand& hand)
    : config(hand.config),
      options(hand.options),
      device(&hand.device),
      servo_model(build_servo_model(config, actuators_of(device->caps()))),
      contact_model(build_contact_model(config, hand.shapes)),
      contact_state(std::make_unique<ContactState>(contact_model)),
      control(initial_control(config)) {
  contact_model.prediction = options.contact_latency / config.servo_rate;
}

Lockstep::Lockstep(const SessionConfig& config, const ContactShapes& shapes, Device& device,
                   const LockstepOptions& options)
    : Lockstep(std::array{LockstepHand{config, shapes, device, options}}) {}

Lockstep::Lockstep(std::span<const LockstepHand> hands)
    : sim_model_(build_sim(*without_tools(hands.front().config), hands.front().shapes.objects,
                           hands.front().shapes.collision_pieces)),
      sim_state_(sim_model_) {
  uint64_t longest_frame = 0, longest_scene = 0;
  for (const LockstepHand& hand : hands) {
    hands_.emplace_back(hand);
    longest_frame = std::max<uint64_t>(longest_frame, hand.options.frame_latency);
    longest_scene = std::max<uint64_t>(longest_scene, hand.options.scene_latency);
  }
  farthest_behind_ = hands.size() > 1 ? longest_frame + longest_scene : longest_frame;
  last_scene_ = std::make_shared<SceneFrame>(sim_step(sim_model_, sim_state_, kStartNs));
  for (OneHand& hand : hands_) hand.scene = last_scene_;
  sim_ticks_ = 1;
}

int64_t Lockstep::time_of(const OneHand& hand) {
  const double period = 1e9 / hand.config.servo_rate;
  return grid_time(hand.config.servo_rate, hand.tick) +
         std::llround(period * hand.config.hand / hand.config.n_hands);
}

/// The hand's frame of so many ticks ago; null: there is none.
const ServoFrame* Lockstep::frame_behind(const OneHand& hand, uint64_t ticks) {
  if (ticks == 0) return hand.tick > 0 ? &hand.frame : nullptr;
  return hand.past.size() > ticks ? &hand.past[hand.past.size() - 1 - ticks] : nullptr;
}

/// The scene where the other hands have brought it, as far as this one knows of them.
const SceneFrame* Lockstep::seen_scene(OneHand& hand, ToolStiffnesses& stiffnesses) const {
  if (hands_.size() == 1) return hand.scene.get();
  copy_in_use(*hand.scene, hand.seen);
  const bool has_tools = hand.config.n_tools > 0;
  for (const OneHand& other : hands_) {
    if (&other == &hand) continue;
    const ServoFrame* const frame =
        frame_behind(other, other.options.frame_latency + hand.options.scene_latency);
    see_other_hand(hand.seen, other.config.hand, frame, has_tools);
    if (has_tools) stiffnesses.push_back(stiffness_of_tool(frame, time_of(hand)));
  }
  return &hand.seen;
}

void Lockstep::move_scene(int64_t t_ns) {
  HandFrames frames;
  for (OneHand& hand : hands_) {
    frames.push_back(frame_behind(hand, hand.options.frame_latency));
    if (frames.back() == nullptr) continue;
    see_hand(sim_model_.given, sim_state_.given, hand.config.hand, *frames.back());
  }
  auto scene = std::make_shared<SceneFrame>(sim_step(sim_model_, sim_state_, frames, t_ns));
  if (hands_.front().options.without_counters) {
    for (ObjectResponse& response : scene->responses) response.mobility = {};
  }
  last_scene_ = scene;
  for (OneHand& hand : hands_) {
    const uint64_t visible_at =
        std::max(hand.tick + hand.options.scene_latency, hand.scene_mapped_at);
    hand.scenes.push_back({visible_at, scene});
  }
}

void Lockstep::give(uint32_t client, const GivenFrame& given) {
  set_giving(sim_model_.given, sim_state_.given, client, 1);
  const int64_t t_ns = next_t_ns();
  see_client(sim_model_.given, sim_state_.given, client, 1, given, t_ns);
  for (OneHand& hand : hands_) {
    const GivenTouchModel& touching = hand.contact_model.given;
    for (size_t k = 0; k < touching.clients.size(); ++k) {
      if (touching.clients[k].client != client) continue;
      hand.contact_state->given.clients[k].heard.follow(1);
      see_client(touching, hand.contact_state->given, k, 1, given, t_ns);
    }
  }
}

void Lockstep::leave(uint32_t client) {
  set_giving(sim_model_.given, sim_state_.given, client, 0);
  for (OneHand& hand : hands_) {
    const GivenTouchModel& touching = hand.contact_model.given;
    for (size_t k = 0; k < touching.clients.size(); ++k) {
      if (touching.clients[k].client == client) {
        hand.contact_state->given.clients[k].heard.follow(0);
      }
    }
  }
}

void Lockstep::restart_sim(uint64_t mapped_after) {
  sim_state_ = SimState(sim_model_);
  resume(sim_model_, sim_state_, *last_scene_);
  has_sim_ = true;
  for (OneHand& hand : hands_) hand.scene_mapped_at = hand.tick + mapped_after;
}

void Lockstep::restart_contact(uint32_t hand) {
  OneHand& of = hands_[hand];
  of.contact_state = std::make_unique<ContactState>(of.contact_model);
  ++of.contact_generation;
  of.has_contact = true;
}

void Lockstep::restart_servo(uint32_t hand) {
  hands_[hand].servo_state = {};
  hands_[hand].has_servo = true;
}

void Lockstep::move_scene_until(int64_t t_ns) {
  const double rate = hands_.front().config.sim_rate;
  for (; grid_time(rate, sim_ticks_) <= t_ns; ++sim_ticks_) {
    if (has_sim_) move_scene(grid_time(rate, sim_ticks_));
  }
}

/// A tick that the servo misses: the device holds its force, and the hand goes on.
void Lockstep::miss(OneHand& hand, int64_t t_ns) {
  ++hand.tick;
  move_scene_until(t_ns);
  DeviceState unread;
  hand.device->read({t_ns, t_ns}, unread);
}

/// A tick of a servo that is dead: hapticd lets go of its device.
void Lockstep::let_go(OneHand& hand, int64_t t_ns) {
  miss(hand, t_ns);
  hand.device->write({});
}

bool Lockstep::tick(OneHand& hand, int64_t t_ns) {
  move_scene_until(t_ns);
  while (!hand.scenes.empty() && hand.scenes.front().visible_at <= hand.tick) {
    hand.scene = std::move(hand.scenes.front().scene);
    hand.scenes.pop_front();
  }

  ServoInput input;
  input.tick = hand.tick;
  input.t_ns = input.realtime_ns = t_ns;
  hand.device->read({t_ns, t_ns}, input.device);
  if ((input.device.flags & kDeviceEnded) != 0) return false;
  const GravityConfig& gravity = hand.config.device.gravity;
  if (has_weight(gravity)) input.holding_B = hand.device->holding(gravity);

  const SceneFrame* const scene = seen_scene(hand, input.tool_stiffness);
  const uint64_t latency = hand.options.contact_latency;
  const bool asks = hand.has_contact && hand.tick % hand.options.contact_period == 0;
  const auto answer = [&](const ServoFrame& question) {
    hand.pending.push_back(
        {hand.tick + latency, std::make_unique<ContactSet>(contact_step(
                                  hand.contact_model, *hand.contact_state, question, scene))});
  };
  if (asks && latency == 0) {
    answer(question_of(hand.config, hand.servo_state, hand.frame, input));
  }
  while (!hand.pending.empty() && hand.pending.front().visible_at <= hand.tick) {
    hand.visible = std::move(hand.pending.front().set);
    hand.pending.pop_front();
  }
  input.contacts = hand.visible.get();
  input.contact_generation = hand.contact_generation;
  input.scene = scene;
  input.control = &hand.control;
  hand.frame = servo_step(hand.servo_model, hand.servo_state, input);
  hand.servo_model.admittance ? hand.device->move(hand.frame.X_command_B)
                              : hand.device->write(hand.frame.F_device_B);
  hand.device->lead(led_handle(hand.config.map, hand.servo_state.clutch, input.control, t_ns));
  if (asks && latency > 0) answer(hand.frame);
  if (farthest_behind_ > 0) {
    hand.past.push_back(hand.frame);
    if (hand.past.size() > farthest_behind_ + 1) hand.past.pop_front();
  }

  add_frame(hash_, hand.frame);
  ++hand.tick;
  return true;
}

bool Lockstep::tick_others_until(int64_t t_ns) {
  for (;;) {
    OneHand* next = nullptr;
    for (OneHand& hand : std::span(hands_).subspan(1)) {
      if (next == nullptr || time_of(hand) < time_of(*next)) next = &hand;
    }
    if (next == nullptr || time_of(*next) >= t_ns) return true;
    const int64_t at_ns = time_of(*next);
    if (!next->has_servo) {
      let_go(*next, at_ns);
    } else if (!tick(*next, at_ns)) {
      return false;
    }
  }
}

void Lockstep::miss_tick() {
  const int64_t t_ns = next_t_ns();
  tick_others_until(t_ns);
  miss(hands_.front(), t_ns);
}

bool Lockstep::step() {
  const int64_t t_ns = next_t_ns();
  if (!tick_others_until(t_ns)) return false;
  if (hands_.front().has_servo) return tick(hands_.front(), t_ns);
  let_go(hands_.front(), t_ns);
  return true;
}

}  // namespace haptic
