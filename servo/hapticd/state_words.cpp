// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/state_words.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>

#include "proto/os/message.h"
#include "proto/wire/behind.h"

namespace haptic {
namespace {

/// A flag in a word, and why the hand feels nothing where it is set; empty: it may feel something,
/// or the fault says why.
struct FlagRow {
  uint32_t flag;
  const char* word;
  std::string_view no_force = {};
};
/// First what keeps the force closed, as people are told of it.
constexpr FlagRow kFlags[] = {
    {kServoPaused, "paused", "paused ('hapt resume')"},
    {kServoDisarmed, "not armed", "not armed ('hapt arm')"},
    {kServoTooFast, "too fast", "the hand was too fast (hold it still)"},
    {kServoNoDevice, "device lost or not homed",
     "the device is lost or not homed (plug it in, calibrate it)"},
    {kServoNoContactSet, "waiting for contacts", "waiting for contacts"},
    {kServoStale, "contacts stale", "the contacts are too old (see the log)"},
    {kServoContact, "contact"},
    {kServoHolding, "holding"},
    {kServoFading, "fading"},
    {kServoReopening, "reopening"},
    {kServoSaturated, "saturated"},
    {kServoSoftStart, "soft start"},
    {kServoFault, "FAULT"},
    {kServoClutched, "clutched"},
    {kServoSolverLimit, "solver limit"},
    {kServoTorqueDropped, "no torque actuators"},
    {kServoSlewing, "slewing"},
    {kServoThermal, "motors warm"},
    {kServoPassivity, "damped to stay passive"},
    {kServoWorkspaceEdge, "edge of the workspace"},
    {kServoSoftened, "softened towards a light body"},
    {kServoForced, "stiffer than the device holds"},
    {kServoWeightEnded, "the arm ran away and is not held up ([device.gravity])"}};

/// One line for each Fault, by its number.
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
  for (uint32_t bit = 1; bit <= servo_flags && bit != 0; bit <<= 1) {
    const auto* row = std::ranges::find(kFlags, servo_flags & bit, &FlagRow::flag);
    if (row != std::end(kFlags)) words.emplace_back(row->word);
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
  for (const FlagRow& row : kFlags) {
    if ((frame.flags & row.flag) != 0 && !row.no_force.empty()) reasons.emplace_back(row.no_force);
  }
  return reasons;
}

}  // namespace haptic
