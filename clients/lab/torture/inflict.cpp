// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/fault_kinds.h"

#include "device-io/woodenhaptics/protocol.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

// documented times to recovery
constexpr int64_t kRestartGoal = 200 * kMs, kServoGoal = 3000 * kMs;
constexpr int64_t kFoundNs = 100 * kMs;  // documented: time to detect a lying device
// documented: the motors of a wrist turn its encoders so fast that noise is found later
constexpr int64_t kTurnFoundNs = 200 * kMs;

}  // namespace

const std::array<FaultInfo, kFaultKinds> kFaults{{
    {FaultKind::kContactKill, "contact: kill -9", 4, Effect::kFade, kRestartGoal},
    {FaultKind::kContactHang, "contact: hangs", 1, Effect::kFade, kRestartGoal},
    {FaultKind::kContactStop, "contact: stopped for a while", 9, Effect::kFade, kRestartGoal},
    {FaultKind::kContactNaN, "contact: NaN in an answer", 5, Effect::kZero, 0},
    {FaultKind::kContactInfinity, "contact: infinity in an answer", 5, Effect::kZero, 0},
    {FaultKind::kContactTenTimes, "contact: 10 times too slow", 5, Effect::kNothing, 0},
    {FaultKind::kContactThousandTimes, "contact: 1000 times too slow", 5, Effect::kFade, 0},
    {FaultKind::kContactLies, "contact: planes out of place", 6, Effect::kLies, 0},
    {FaultKind::kSimKill, "sim: kill -9", 4, Effect::kNothing, kRestartGoal},
    {FaultKind::kSimStop, "sim: stopped for a while", 6, Effect::kNothing, 0},
    {FaultKind::kServoKill, "servo: kill -9", 1, Effect::kZero, kServoGoal},
    {FaultKind::kServoStop, "servo: hangs", 1, Effect::kZero, kServoGoal},
    {FaultKind::kServoPause, "servo: stopped for a while", 1, Effect::kLimits, 0},
    {FaultKind::kHapticdKill, "hapticd: kill -9", 1, Effect::kZero, 0},
    {FaultKind::kHapticdServoKill, "hapticd and servo: kill -9", 1, Effect::kZero, 0,
     kFirmwareWatchdogNs},
    {FaultKind::kHapticdStop, "hapticd: stopped for a while", 1, Effect::kNothing, 0},
    {FaultKind::kRecorderKill, "recorder: kill -9", 4, Effect::kNothing, 0},
    {FaultKind::kRecorderStop, "recorder: stopped for a while", 5, Effect::kNothing, 0},
    {FaultKind::kClientKill, "watching client: kill -9", 5, Effect::kNothing, 0},
    {FaultKind::kClientStop, "watching client: stopped", 5, Effect::kNothing, 0},
    {FaultKind::kManyClients, "64 clients attach and die", 2, Effect::kNothing, 0},
    {FaultKind::kPoseJump, "device: pose jumps 0.67 m", 6, Effect::kZero, 0},
    {FaultKind::kDeviceSilent, "device: stops answering", 5, Effect::kSilence, 0},
    {FaultKind::kDeviceFrozen, "device: the same answer always", 3, Effect::kZero, 0, kFoundNs,
     true},
    {FaultKind::kDeviceOldFirst, "device: old answers between", 2, Effect::kZero, 0, kFoundNs,
     true},
    {FaultKind::kDeviceDelayed, "device: answers a second old", 2, Effect::kZero, 0, kFoundNs,
     true},
    {FaultKind::kDeviceNoise, "device: 60 counts of noise", 3, Effect::kZero, 0, kFoundNs, true},
    {FaultKind::kTurnJump, "device: orientation jumps 1 rad", 6, Effect::kZero, 0,
     ForceRules{}.zero_ns, false, true},
    {FaultKind::kDeviceTurnNoise, "device: noise of orientation", 3, Effect::kZero, 0, kTurnFoundNs,
     true, true},
    {FaultKind::kMemory, "memory pressure", 1, Effect::kLimits, 0},
    {FaultKind::kBusy, "all cores busy", 1, Effect::kLimits, 0},
}};

const FaultInfo& info_of(FaultKind kind) {
  return kFaults[static_cast<size_t>(kind)];
}

}  // namespace haptic
