// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "clients/lab/torture/force_judge.h"

namespace haptic {

/// Faults that can be injected into a running session.
enum class FaultKind {
  kContactKill,
  kContactHang,
  kContactStop,
  kContactNaN,
  kContactInfinity,
  kContactTenTimes,
  kContactThousandTimes,
  kContactLies,
  kSimKill,
  kSimStop,
  kServoKill,
  kServoStop,
  kServoPause,
  kHapticdKill,
  kHapticdServoKill,
  kHapticdStop,
  kRecorderKill,
  kRecorderStop,
  kClientKill,
  kClientStop,
  kManyClients,
  kPoseJump,
  kDeviceSilent,
  kDeviceFrozen,
  kDeviceOldFirst,
  kDeviceDelayed,
  kDeviceNoise,
  kTurnJump,
  kDeviceTurnNoise,
  kMemory,
  kBusy,
};
inline constexpr size_t kFaultKinds = 31;

/// Properties of a kind of fault.
struct FaultInfo {
  FaultKind kind;
  std::string_view name;
  int share;                               // per hundred faults
  Effect effect;                           // allowed effect on the force
  int64_t goal_ns;                         // documented time to recovery; 0: none
  int64_t zero_ns = ForceRules{}.zero_ns;  // documented time to zero force, if the effect is zero
  bool is_misled = false;                  // the device reports false data
  bool is_of_six = false;                  // of a device that turns only
};
extern const std::array<FaultInfo, kFaultKinds> kFaults;

const FaultInfo& info_of(FaultKind kind);

}  // namespace haptic
