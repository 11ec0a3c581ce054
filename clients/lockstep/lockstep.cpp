// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lockstep/lockstep.h"

#include <cmath>
#include <cstring>

#include "proto/config/renderer_needs.h"
#include "proto/ipc/control.h"
#include "proto/wire/mapping.h"
#include "proto/wire/renderer.h"
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

}  // namespace

Lockstep::Lockstep(const SessionConfig& config, const ContactShapes& shapes, Device& device,
                   const LockstepOptions& options)
    : config_(config),
      options_(options),
      device_(device),
      servo_model_(build_servo_model(config, actuators_of(device.caps()))),
      contact_model_(build_contact_model(config, shapes)),
      contact_state_(std::make_unique<ContactState>(contact_model_)),
      sim_model_(build_sim(config, shapes.objects, shapes.collision_pieces)),
      sim_state_(sim_model_),
      control_(initial_control(config)) {
  contact_model_.prediction = options.contact_latency / config.servo_rate;
  scene_ = std::make_unique<SceneFrame>(sim_step(sim_model_, sim_state_, kStartNs));
  sim_ticks_ = 1;
}

void Lockstep::move_scene(int64_t t_ns) {
  // its hand's frame is that of the tick before
  const HandFrames hands{tick_ > 0 ? &frame_ : nullptr};
  if (tick_ > 0) see_hand(sim_model_.given, sim_state_.given, kFirstHand, frame_);
  auto scene = std::make_unique<SceneFrame>(sim_step(sim_model_, sim_state_, hands, t_ns));
  if (options_.without_counters) {
    for (ObjectResponse& response : scene->responses) response.mobility = {};
  }
  const uint64_t visible_at = std::max(tick_ + options_.scene_latency, scene_mapped_at_);
  scenes_.push_back({visible_at, std::move(scene)});
}

ServoFrame Lockstep::question_of(const DeviceState& device, int64_t t_ns) const {
  ServoFrame question{};
  question.tick = tick_;
  question.t_ns = t_ns;
  question.device.buttons = device.buttons;
  question.X_WT = tool_pose(config_.map, servo_state_.clutch, device.X_BH);
  question.V_WT = tool_twist(config_.map, device.X_BH, device.V_BH);
  question.flags = kServoNoContactSet;
  question.renderer = static_cast<uint32_t>(config_.renderer);
  question.held_back_W = frame_.held_back_W;
  // as of the last tick: 0, not known, before the first
  question.translational_stiffness = frame_.translational_stiffness;
  question.rotational_stiffness = frame_.rotational_stiffness;
  // a 6-DoF proxy with springs is where the last tick left it, any other at the tool
  question.X_WP = question.X_WT;
  if (tick_ > 0 && is_of_body(config_.renderer) && has_springs(config_.proxy, config_.renderer)) {
    question.X_WP = frame_.X_WP;
    question.V_WP = frame_.V_WP;
  }
  return question;
}

void Lockstep::answer(const ServoFrame& question, uint64_t visible_at) {
  auto set = std::make_unique<ContactSet>(
      contact_step(contact_model_, *contact_state_, question, scene_.get()));
  pending_.push_back({visible_at, std::move(set)});
}

void Lockstep::give(uint32_t client, const GivenFrame& given) {
  set_giving(sim_model_.given, sim_state_.given, client, 1);
  const int64_t t_ns = grid_time(config_.servo_rate, tick_);
  see_client(sim_model_.given, sim_state_.given, client, 1, given, t_ns);
  const GivenTouchModel& touching = contact_model_.given;
  for (size_t k = 0; k < touching.clients.size(); ++k) {
    if (touching.clients[k].client != client) continue;
    contact_state_->given.clients[k].heard.follow(1);
    see_client(touching, contact_state_->given, k, 1, given, t_ns);
  }
}

void Lockstep::leave(uint32_t client) {
  set_giving(sim_model_.given, sim_state_.given, client, 0);
  for (size_t k = 0; k < contact_model_.given.clients.size(); ++k) {
    if (contact_model_.given.clients[k].client == client) {
      contact_state_->given.clients[k].heard.follow(0);
    }
  }
}

int64_t Lockstep::next_t_ns() const {
  return grid_time(config_.servo_rate, tick_);
}

void Lockstep::restart_sim(uint64_t mapped_after) {
  const SceneFrame& last = scenes_.empty() ? *scene_ : *scenes_.back().scene;
  sim_state_ = SimState(sim_model_);
  resume(sim_model_, sim_state_, last);
  has_sim_ = true;
  scene_mapped_at_ = tick_ + mapped_after;
}

void Lockstep::restart_contact() {
  contact_state_ = std::make_unique<ContactState>(contact_model_);
  ++contact_generation_;
  has_contact_ = true;
}

void Lockstep::move_scene_until(int64_t t_ns) {
  for (; grid_time(config_.sim_rate, sim_ticks_) <= t_ns; ++sim_ticks_) {
    if (has_sim_) move_scene(grid_time(config_.sim_rate, sim_ticks_));
  }
}

void Lockstep::miss_tick() {
  const int64_t t_ns = grid_time(config_.servo_rate, tick_++);
  move_scene_until(t_ns);
  DeviceState unread;
  device_.read({t_ns, t_ns}, unread);
}

bool Lockstep::step() {
  const int64_t t_ns = grid_time(config_.servo_rate, tick_);
  move_scene_until(t_ns);
  while (!scenes_.empty() && scenes_.front().visible_at <= tick_) {
    scene_ = std::move(scenes_.front().scene);
    scenes_.pop_front();
  }

  ServoInput input;
  input.tick = tick_;
  input.t_ns = input.realtime_ns = t_ns;
  device_.read({t_ns, t_ns}, input.device);
  if ((input.device.flags & kDeviceEnded) != 0) return false;
  const GravityConfig& gravity = config_.device.gravity;
  if (has_weight(gravity)) input.holding_B = device_.holding(gravity);

  const bool asks = has_contact_ && tick_ % options_.contact_period == 0;
  if (asks && options_.contact_latency == 0) answer(question_of(input.device, t_ns), tick_);
  while (!pending_.empty() && pending_.front().visible_at <= tick_) {
    visible_ = std::move(pending_.front().set);
    pending_.pop_front();
  }
  input.contacts = contacts();
  input.contact_generation = contact_generation_;
  input.scene = scene_.get();
  input.control = &control_;
  frame_ = servo_step(servo_model_, servo_state_, input);
  servo_model_.admittance ? device_.move(frame_.X_command_B) : device_.write(frame_.F_device_B);
  device_.lead(led_handle(config_.map, servo_state_.clutch, input.control, t_ns));
  if (asks && options_.contact_latency > 0) answer(frame_, tick_ + options_.contact_latency);

  add_frame(hash_, frame_);
  ++tick_;
  return true;
}

}  // namespace haptic
