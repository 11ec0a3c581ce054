// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/loop.h"

#include <limits>

#include "proto/wire/packing.h"
#include "servo/lead.h"

namespace haptic {
namespace {

// changes worth a line in the log; contact itself comes and goes all the time
constexpr uint32_t kNotable = kServoStale | kServoFault | kServoClutched | kServoPaused |
                              kServoNoContactSet | kServoTorqueDropped | kServoDisarmed |
                              kServoTooFast | kServoThermal | kServoNoDevice | kServoWeightEnded;

// [ticks] hapticd releases the device after kReleaseAfterTicks; margin for the skew of its checks
constexpr int64_t kMaybeReleasedTicks = kReleaseAfterTicks - 2;

ServoModel build_model(const SessionConfig& config, const Device& device) {
  const DeviceCaps caps = device.caps();
  return build_servo_model(
      config, {caps.max_force, caps.max_torque, caps.causality == Causality::kAdmittance});
}

}  // namespace

void ServoInbox::prefetch() const noexcept {
  contacts.prefetch_newest();
  scenes.prefetch();
}

void ServoInbox::receive(ServoInput& input) noexcept {
  any_contact |= contacts.latest(contact_set);
  any_control |= controls.latest(control);
  input.contacts = any_contact ? &contact_set : nullptr;
  input.contact_generation = contacts.item_generation();
  input.scene = scenes.latest();
  input.tool_stiffness = scenes.stiffnesses(input.t_ns);
  input.control = any_control ? &control : nullptr;
}

ServoLoop::ServoLoop(const SessionConfig& config, Device& device, ServoInbox& inbox,
                     ServoChannels& channels)
    : device_(device),
      inbox_(inbox),
      channels_(channels),
      model_(build_model(config, device)),
      gravity_(config.device.gravity),
      patience_ns_(device.release().size > 0 ? kMaybeReleasedTicks * period_ns(config.servo_rate)
                                             : std::numeric_limits<int64_t>::max()) {
  if (device.release().size > 0) channels_.releases.publish(device.release());
}

void ServoLoop::tick(const Tick& tick) {
  const int64_t woke_ns = tick.deadline_ns + tick.late_ns;
  channels_.frames.prefetch();
  inbox_.prefetch();
  device_.read({tick.deadline_ns, woke_ns}, input_.device);
  if (has_weight(gravity_)) input_.holding_B = device_.holding(gravity_);
  input_.tick = tick.index;
  input_.t_ns = tick.deadline_ns;
  inbox_.receive(input_);
  input_.realtime_ns = realtime_now_ns() - (now_ns() - tick.deadline_ns);
  input_.wake_late_ns = tick.late_ns;
  input_.released = dropped_ || woke_ns - last_woke_ns_ >= patience_ns_;
  last_woke_ns_ = woke_ns;
  input_.skipped = tick.skipped;

  copy_in_use(servo_step(model_, state_, input_), frame_);
  // after such a delay the force belongs to an outdated position of the hand
  dropped_ = now_ns() - woke_ns >= patience_ns_;
  if (dropped_) frame_.F_device_B = {};
  model_.admittance ? device_.move(frame_.X_command_B) : device_.write(frame_.F_device_B);
  device_.lead(led_handle(model_.map, state_.clutch, input_.control, woke_ns));
  frame_.busy_ns = now_ns() - woke_ns;
  channels_.frames.publish(frame_);
  publish_changes();
}

void ServoLoop::publish_event(EventCode code, const std::array<double, 5>& numbers) {
  channels_.events.publish({now_ns(), static_cast<uint32_t>(code),
                            static_cast<uint32_t>(servo_segment(model_.hand)), numbers});
}

void ServoLoop::publish_changes() {
  if (frame_.fault != fault_ && frame_.fault != 0) {
    publish_event(EventCode::kFault,
                  {static_cast<double>(frame_.fault), static_cast<double>(frame_.tick),
                   norm(frame_.device.V_BH.v), norm(frame_.F_coupling_W.f), 0});
  }
  fault_ = frame_.fault;

  // reported once: a dropped torque comes and goes with contact
  const uint32_t now_notable = (frame_.flags | (notable_ & kServoTorqueDropped)) & kNotable;
  if (now_notable == notable_) return;
  publish_event(EventCode::kFlagsChanged,
                {static_cast<double>(notable_), static_cast<double>(now_notable),
                 static_cast<double>(frame_.tick), 0, 0});
  notable_ = now_notable;
}

void ServoLoop::stop() {
  device_.stop();
  ++frame_.tick;
  frame_.F_device_B = {};
  frame_.flags = kServoStopped;
  frame_.device.flags = (frame_.device.flags & ~uint32_t{kDeviceFresh}) | kDeviceHeld;
  channels_.frames.publish(frame_);
}

}  // namespace haptic
