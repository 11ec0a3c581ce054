// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/ipc/ring.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Owner of a segment. A second hand adds 0x10 to the numbers of servo and contact.
enum class SegmentId : uint32_t { kControl = 1, kServo0 = 2, kContact0 = 3, kSim = 4 };

/// The rings of each process. 4096 frames of servo and contact are four seconds at 1 kHz: they
/// survive a crash of the writer, and a recorder may be that late on a busy machine.
struct ServoChannels {
  static constexpr SegmentId kId = SegmentId::kServo0;
  static constexpr const char* kName = "servo0";
  Ring<ServoFrame, 4096> frames;
  Ring<Event, 256> events;
  Ring<DeviceRelease, 4> releases;
};

struct ContactChannels {
  static constexpr SegmentId kId = SegmentId::kContact0;
  static constexpr const char* kName = "contact0";
  Ring<ContactSet, 4096> sets;
  Ring<Event, 256> events;
};

struct SimChannels {
  static constexpr SegmentId kId = SegmentId::kSim;
  static constexpr const char* kName = "sim";
  Ring<SceneFrame, 512> frames;
  Ring<Event, 256> events;
};

struct ControlChannels {
  static constexpr SegmentId kId = SegmentId::kControl;
  static constexpr const char* kName = "control";
  Ring<ControlFrame, 64> frames;
  Ring<Event, 256> events;
};

}  // namespace haptic
