// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/wire/wire.h"

/// The state of the servo in words, for the log and for `hapt status`.
namespace haptic {

/// One word for each flag that is set.
std::vector<std::string> words_of_flags(uint32_t servo_flags);

/// "contact, soft start"; "ok" without flags.
std::string state_text(uint32_t servo_flags);

/// Says what was wrong when the force was latched at zero.
const char* reason_of(Fault fault);

/// Says why the hand feels nothing whatever it touches, and what ends that, one entry each; empty
/// while the force is open.
std::vector<std::string> reasons_for_no_force(const ServoFrame& frame);

}  // namespace haptic
