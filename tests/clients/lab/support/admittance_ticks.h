// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "contact/shape/mesh/primitives.h"
#include "tests/clients/lab/support/arm_session.h"
#include "tests/support/frames.h"

namespace haptic::test {

/// An arm, a block of 0.1 m, and the steps of servo and contact around them, whose samples,
/// instants and answers a test may spoil between them.
struct ArmTicks {
  MeshShapeData block = build_shape(make_box({0.1, 0.1, 0.1}));
  SimulatedArm arm;
  ServoModel model;
  ContactModel contact;
  std::unique_ptr<ContactState> contact_state;
  std::unique_ptr<ServoState> servo = std::make_unique<ServoState>();
  std::unique_ptr<ContactSet> set;  // that the next tick uses; null: none yet
  ControlFrame control{};
  SceneFrame scene{};

  ArmTicks(const SessionConfig& config, Intention intention)
      : arm(config.device, std::move(intention)),
        model(build_servo_model(config, {arm.caps().max_force, arm.caps().max_torque, true})),
        contact(build_contact_model(config, std::array{block.view()})),
        contact_state(std::make_unique<ContactState>(contact)) {
    control.armed = 1;
    scene.objects.push_back(scene_object(config.objects[0].X_WO));
  }

  /// The input of that tick, with the arm's sample.
  ServoInput read(uint64_t tick, int64_t wake_late_ns = 0) {
    ServoInput input;
    input.tick = tick;
    input.t_ns = 1'000'000'000 + static_cast<int64_t>(tick) * 1'000'000;
    input.wake_late_ns = wake_late_ns;
    arm.read({input.t_ns, input.t_ns + wake_late_ns}, input.device);
    return input;
  }
  /// The servo's tick; the arm moves as it is told.
  ServoFrame move(ServoInput input) {
    set_time(scene, input.t_ns);
    input.scene = &scene;
    input.control = &control;
    input.contacts = set.get();
    const ServoFrame frame = servo_step(model, *servo, input);
    arm.move(frame.X_command_B);
    return frame;
  }
  /// Contact's answer to a frame, at the scene as it stands.
  std::unique_ptr<ContactSet> answer(const ServoFrame& frame) {
    return std::make_unique<ContactSet>(contact_step(contact, *contact_state, frame, &scene));
  }
};

}  // namespace haptic::test
