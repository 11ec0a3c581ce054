// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/device.h"
#include "proto/ipc/attachments.h"
#include "proto/ipc/seen_scene.h"
#include "proto/os/realtime.h"
#include "servo/step.h"

/// The body of the servo's loop without its clock: haptic-servo runs it on a deadline clock, `hapt
/// selftest` and the tests run it a million times under a guard.
namespace haptic {

/// The newest item of each ring the servo reads; kept from tick to tick.
struct ServoInbox {
  RingSource<&ContactChannels::sets> contacts;
  SeenScene scenes;
  RingSource<&ControlChannels::frames> controls;
  ContactSet contact_set{};
  ControlFrame control{};
  bool any_contact = false, any_control = false;

  /// From a Child or from Attachments, before either is started.
  template <typename Rings>
  explicit ServoInbox(Rings& rings, const SessionConfig& config = {})
      : contacts(rings.template ring<&ContactChannels::sets>(Start::kOldest, config.hand)),
        scenes(rings, config.hand, config.n_hands, config.n_tools > 0),
        controls(rings.template ring<&ControlChannels::frames>(Start::kOldest, config.hand)) {}

  void receive(ServoInput& input) noexcept;
  /// A few microseconds before receive: starts to fetch what other cores have written.
  void prefetch() const noexcept;
};

/// Reads device and rings, makes one step, writes device and ring. Only the constructor allocates.
/// Its arguments must outlive it.
class ServoLoop {
 public:
  ServoLoop(const SessionConfig& config, Device& device, ServoInbox& inbox,
            ServoChannels& channels);

  /// One tick: read the device, receive, step, write the device, publish.
  void tick(const Tick& tick);

  /// Ends the loop: writes a zero wrench and publishes a last frame with kServoStopped.
  void stop();

  const ServoFrame& frame() const { return frame_; }

 private:
  void publish_changes();
  void publish_event(EventCode code, const std::array<double, 5>& numbers);

  Device& device_;
  ServoInbox& inbox_;
  ServoChannels& channels_;
  ServoModel model_;
  const GravityConfig gravity_;
  ServoState state_;
  ServoInput input_;
  ServoFrame frame_{};
  const int64_t patience_ns_;  // between wake-ups: after it hapticd may have released the device
  int64_t last_woke_ns_ = 0;
  bool dropped_ = false;  // the last force came too late and was not sent
  uint32_t notable_ = 0, fault_ = 0;
};

}  // namespace haptic
