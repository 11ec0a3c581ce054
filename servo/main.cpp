// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-servo: device, coupling, proxy solver and safety, once per period.
#include <cstdio>
#include <memory>

#include "device-io/device.h"
#include "proto/process.h"
#include "servo/step.h"

namespace haptic {
namespace {

constexpr int kFifoPriority = 80;
// what an operator wants to read in the log; contact itself comes and goes all the time
constexpr uint32_t kNotable = kServoStale | kServoFault | kServoClutched | kServoPaused |
                              kServoNoContactSet | kServoTorqueDropped | kServoNoDevice;

/// The newest item of each ring this process reads; they stay where they are from tick to tick.
struct Inbox {
  RingSource<&ContactChannels::sets> contacts;
  RingSource<&SimChannels::frames> scenes;
  RingSource<&ControlChannels::frames> controls;
  ContactSet contact_set{};
  SceneFrame scene{};
  ControlFrame control{};
  bool any_contact = false, any_scene = false, any_control = false;

  explicit Inbox(Child<ServoChannels>& child)
      : contacts(child.ring<&ContactChannels::sets>(Start::kOldest)),
        scenes(child.ring<&SimChannels::frames>(Start::kOldest)),
        controls(child.ring<&ControlChannels::frames>(Start::kOldest)) {}

  void receive(ServoInput& input) noexcept {
    any_contact |= contacts.latest(contact_set);
    any_scene |= scenes.latest(scene);
    any_control |= controls.latest(control);
    input.contacts = any_contact ? &contact_set : nullptr;
    input.contact_generation = contacts.item_generation();
    input.scene = any_scene ? &scene : nullptr;
    input.control = any_control ? &control : nullptr;
  }
};

int run(const ChildArguments& arguments) {
  Child<ServoChannels> child(arguments);
  const auto inbox = std::make_unique<Inbox>(child);
  const std::unique_ptr<Device> device =
      open_device(child.config().device, FileDescriptor(arguments.device_fd));
  const DeviceCaps caps = device->caps();
  const ServoModel model = build_servo_model(child.config(), {caps.max_force, caps.max_torque});
  ServoState state;
  std::fprintf(stderr, "haptic-servo: device: %s\n", device->description().c_str());
  child.start({.fifo_priority = kFifoPriority, .lock_memory = true});

  uint32_t notable = 0;
  ServoInput input;
  ServoFrame frame{};
  DeadlineClock clock(period_ns(child.config().servo_rate));
  while (!child.stopping()) {
    const Tick tick = clock.wait();
    child.beat(tick);
    const int64_t woke_ns = tick.deadline_ns + tick.late_ns;
    device->read({tick.deadline_ns, woke_ns}, input.device);
    inbox->receive(input);
    input.tick = tick.index;
    input.t_ns = tick.deadline_ns;
    input.realtime_ns = realtime_now_ns() - (now_ns() - tick.deadline_ns);
    input.wake_late_ns = tick.late_ns;
    input.skipped = tick.skipped;

    frame = servo_step(model, state, input);
    device->write(frame.F_device_B);
    frame.busy_ns = now_ns() - woke_ns;
    child.channels().frames.publish(frame);

    // torque comes and goes with contact: that it is dropped is said once
    const uint32_t now_notable = (frame.flags | (notable & kServoTorqueDropped)) & kNotable;
    if (now_notable != notable) {
      child.event(EventCode::kFlagsChanged,
                  {static_cast<double>(notable), static_cast<double>(now_notable),
                   static_cast<double>(tick.index), 0, 0});
      notable = now_notable;
    }
  }
  // every way out of the loop ends with a zero wrench, and the ring says so
  device->stop();
  ++frame.tick;
  frame.F_device_B = {};
  frame.flags = kServoStopped;
  frame.device.flags = (frame.device.flags & ~uint32_t{kDeviceFresh}) | kDeviceHeld;
  child.channels().frames.publish(frame);
  child.finish();
  return kExitClean;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  return haptic::run_child(argc, argv, haptic::run);
}
