// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/state_words.h"

#include <array>
#include <utility>

#include "proto/os/message.h"
#include "proto/wire/behind.h"

namespace haptic {
namespace {

constexpr std::array kServoFlagNames{std::pair{kServoContact, "contact"},
                                     std::pair{kServoNoContactSet, "waiting for contacts"},
                                     std::pair{kServoHolding, "holding"},
                                     std::pair{kServoFading, "fading"},
                                     std::pair{kServoStale, "contacts stale"},
                                     std::pair{kServoReopening, "reopening"},
                                     std::pair{kServoSaturated, "saturated"},
                                     std::pair{kServoSoftStart, "soft start"},
                                     std::pair{kServoFault, "FAULT"},
                                     std::pair{kServoClutched, "clutched"},
                                     std::pair{kServoPaused, "paused"},
                                     std::pair{kServoSolverLimit, "solver limit"},
                                     std::pair{kServoTorqueDropped, "no torque actuators"},
                                     std::pair{kServoDisarmed, "not armed"},
                                     std::pair{kServoTooFast, "too fast"},
                                     std::pair{kServoSlewing, "slewing"},
                                     std::pair{kServoThermal, "motors warm"},
                                     std::pair{kServoPassivity, "damped to stay passive"},
                                     std::pair{kServoWorkspaceEdge, "edge of the workspace"},
                                     std::pair{kServoNoDevice, "device lost or not homed"},
                                     std::pair{kServoSoftened, "softened towards a light body"},
                                     std::pair{kServoForced, "stiffer than the device holds"}};

/// Beside a fault.
constexpr std::array kNoForce{
    std::pair{kServoPaused, "paused ('hapt resume')"},
    std::pair{kServoDisarmed, "not armed ('hapt arm')"},
    std::pair{kServoTooFast, "the hand was too fast (hold it still)"},
    std::pair{kServoNoDevice, "the device is lost or not homed (plug it in, calibrate it)"},
    std::pair{kServoNoContactSet, "waiting for contacts"},
    std::pair{kServoStale, "the contacts are too old (see the log)"}};

/// By the numbers of Fault.
constexpr std::array kReasons{
    "unknown",
    "the device's sample was not finite",
    "the contacts or the poses of objects were not finite",
    "the force was not finite",
    "the force was over a thousand times the limit",
    "the pose of the device jumped",
    "the device's answers do not match the requests (frozen, old, or of an arm that "
    "does not follow): free it, or unplug it and plug it in again",
    "an encoder of the device is noisy: check its cable and plug"};
static_assert(kReasons.size() == static_cast<size_t>(Fault::kDeviceNoisy) + 1);

}  // namespace

std::vector<std::string> words_of_flags(uint32_t servo_flags) {
  // while the force is closed the soft start has not begun
  if ((servo_flags & (kServoClosed | kServoClutched)) != 0) {
    servo_flags &= ~uint32_t{kServoSoftStart};
  }
  std::vector<std::string> words;
  for (const auto& [flag, name] : kServoFlagNames) {
    if ((servo_flags & flag) != 0) words.emplace_back(name);
  }
  for (const BehindRow& row : kBehind) {
    if ((servo_flags & row.flag) != 0) words.emplace_back(row.state);
  }
  return words;
}

std::string state_text(uint32_t servo_flags) {
  const std::string text = joined(words_of_flags(servo_flags));
  return text.empty() ? "ok" : text;
}

const char* reason_of(Fault fault) {
  const auto number = static_cast<size_t>(fault);
  return kReasons[number < kReasons.size() ? number : 0];
}

std::vector<std::string> reasons_for_no_force(const ServoFrame& frame) {
  std::vector<std::string> reasons;
  if ((frame.flags & kServoFault) != 0) {
    reasons.push_back("fault: " + std::string(reason_of(static_cast<Fault>(frame.fault))) +
                      " (mend that, then 'hapt clear-fault')");
  }
  for (const auto& [flag, reason] : kNoForce) {
    if ((frame.flags & flag) != 0) reasons.emplace_back(reason);
  }
  return reasons;
}

}  // namespace haptic
